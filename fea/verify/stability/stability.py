"""All extreme cases, by name."""

from collections.abc import Callable, Sequence
from types import MappingProxyType

from fea.verify.stability import (
    bending,
    contrast,
    engines,
    grading,
    incompressible,
    liner,
    membrane,
    rods,
    scaling,
    slender,
    slivers,
    thin_ring,
)
from fea.verify.stability.row import ExtremeRow
from geometry.errors import InvalidValue

CASES = MappingProxyType(
    {
        "contrast": contrast.rows,
        "liner": liner.rows,
        "slender": slender.rows,
        "ring": thin_ring.rows,
        "grading": grading.rows,
        "slivers": slivers.rows,
        "bending": bending.rows,
        "incompressible": incompressible.rows,
        "membrane": membrane.rows,
        "scaling": scaling.rows,
        "engines": engines.rows,
        "rods": rods.rows,
    }
)


def stability(names: Sequence[str] = (), listener: Callable[[str], None] | None = None) -> list[ExtremeRow]:
    """Compute some cases, or all.

    Parameters
    ----------
    names
        Names of `CASES`; empty for all.
    listener
        Called with the name of each case before it begins.

    Raises
    ------
    InvalidValue
        There is no such case; it is raised before anything is computed.
    """
    for name in names:
        if name not in CASES:
            raise InvalidValue("CASE", name, "is not an extreme case", f"Choose from {', '.join(CASES)}.")
    found: list[ExtremeRow] = []
    for name in names or CASES:
        if listener:
            listener(name)
        found += CASES[name]()
    return found
