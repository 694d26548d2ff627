"""What the figures of `summary.json` are made of."""

from typing import Annotated, Any, TypeVar

Vector = tuple[float, float, float]
Known = TypeVar("Known")
ONLY_WHERE_KNOWN = "only where known"
WhereKnown = Annotated[Known | None, ONLY_WHERE_KNOWN]


def vector(values: Any) -> Vector:
    """Return three coordinates as plain numbers."""
    x, y, z = (float(value) for value in values)
    return x, y, z
