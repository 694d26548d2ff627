"""Every extreme case, by name."""

from collections.abc import Callable, Sequence
from types import MappingProxyType

from fea.verify.stability import contrast, engines, incompressible, membrane, scaling, slender, slivers
from fea.verify.stability.row import ExtremeRow
from geometry.invalid import InvalidValue

CASES = MappingProxyType(
    {
        "contrast": contrast.rows,
        "slender": slender.rows,
        "slivers": slivers.rows,
        "incompressible": incompressible.rows,
        "membrane": membrane.rows,
        "scaling": scaling.rows,
        "engines": engines.rows,
    }
)


def stability(names: Sequence[str] = (), listener: Callable[[str], None] | None = None) -> list[ExtremeRow]:
    """Compute some cases, or all.

    Parameters
    ----------
    names
        Of `CASES`; empty for all.
    listener
        Told the name of each case as it begins.

    Raises
    ------
    InvalidValue
        There is no such case; nothing has been computed then.
    """
    for name in names:
        if name not in CASES:
            raise InvalidValue("CASE", name, "is no extreme case", f"Known: {', '.join(CASES)}.")
    found: list[ExtremeRow] = []
    for name in names or CASES:
        if listener:
            listener(name)
        found += CASES[name]()
    return found
