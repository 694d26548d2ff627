"""Three plain sentences on what to use when."""

from collections.abc import Sequence

from fea.verify.converge.front import fastest_within
from fea.verify.converge.row import Row

PERCENTS = (5.0, 2.0, 1.0)


def advice(rows: Sequence[Row]) -> list[str]:
    """A sentence for each accuracy, from the rows of the rod."""
    return [_sentence(rows, percent) for percent in PERCENTS]


def _sentence(rows: Sequence[Row], percent: float) -> str:
    found = fastest_within(rows, percent)
    if not found:
        return f"Within {percent:g} %: nothing that was computed in the time."
    ranked = sorted(found.items(), key=lambda item: item[1].measured.seconds)
    ((tool, element), best), others = ranked[0], ranked[1:]
    text = (
        f"For a peak within {percent:g} % use `{tool}` with {element.upper()} elements: "
        f"{best.measured.seconds:.1f} s at {best.measured.dofs} degrees of freedom"
    )
    calculix = [row for (name, _), row in others if name == "CalculiX"]
    first = [name for name, kind in found if kind == "p1"]
    if calculix:
        text += f"; CalculiX takes {calculix[0].measured.seconds:.0f} s"
    elif any(row.computation.tool == "CalculiX" for row in rows):
        text += "; CalculiX did not get there in the time"
    return text + ("." if first else ", and no first-order mesh got there.")
