"""One sentence per accuracy on the fastest way to reach it."""

from collections.abc import Sequence

from fea.verify.converge.front import FLOOR, fastest_within
from fea.verify.converge.row import Row
from fea.verify.converge.versus import PERCENTS, EqualError, equal_error


def advice(rows: Sequence[Row], floor: float = FLOOR) -> list[str]:
    """A sentence for each accuracy, from the rows of the rod, whose errors are known to `floor` percent."""
    against = {compared.percent: compared for compared in equal_error(rows, floor)}
    return [_sentence(rows, percent, against.get(percent), floor) for percent in PERCENTS]


def _sentence(rows: Sequence[Row], percent: float, against: EqualError | None, floor: float) -> str:
    if percent < floor:
        return f"Within {percent:g} %: the reference is not accurate enough (±{floor:.2g} %)."
    found = fastest_within(rows, percent)
    ours = {kind: row for kind, row in found.items() if kind[0] != "CalculiX"}
    if not ours:
        return f"Within {percent:g} %: no computation reached this within the time limit."
    (_, element), best = min(ours.items(), key=lambda item: item[1].measured.seconds)
    text = (
        f"For a peak within {percent:g} %, confirmed by all finer meshes, use `{best.computation.name}` "
        f"with {element.upper()} elements: {best.measured.seconds:.1f} s at {best.measured.dofs} dofs"
    )
    if against is not None:
        text += "; CalculiX " + _calculix(against)
    first = [name for name, kind in found if kind == "p1"]
    return text + ("." if first else ". No first-order mesh reached this.")


def _calculix(against: EqualError) -> str:
    if against.theirs == float("inf"):
        return f"did not reach this in {against.longest:.0f} s"
    return f"takes {against.ratio:.1f} times as long for the same error"
