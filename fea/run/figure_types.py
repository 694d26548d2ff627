"""What the figures of `summary.json` are made of."""

from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from fea.units import DEG

if TYPE_CHECKING:
    from fea.judge.bore_shape import BoreShape

Vector = tuple[float, float, float]
Known = TypeVar("Known")
ONLY_WHERE_KNOWN = "only where known"
WhereKnown = Annotated[Known | None, ONLY_WHERE_KNOWN]


def vector(values: Any) -> Vector:
    """Return three coordinates as plain numbers."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def shape_figures(shape: "BoreShape") -> dict[str, float]:
    """Ovality, and the largest and the least change of diameter with their directions in degrees."""
    (widest, wide), (narrowest, narrow) = shape.widest, shape.narrowest
    return {
        "ovality_mm": shape.ovality,
        "widest_mm": widest,
        "widest_deg": wide / DEG,
        "narrowest_mm": narrowest,
        "narrowest_deg": narrow / DEG,
    }
