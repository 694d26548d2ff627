"""Which computations are worth their time."""

from collections.abc import Sequence

from fea.verify.converge.row import Row

# Errors below this are the reference's or an accident, percent.
FLOOR = 0.05


def pareto(rows: Sequence[Row], floor: float = FLOOR) -> list[Row]:
    """The rows of one problem that no other beats in both time and error, the fastest first.

    Parameters
    ----------
    rows
        Of one problem.
    floor
        Smaller errors, percent, count as this.
    """
    best: list[Row] = []
    for row in sorted(rows, key=lambda row: (row.measured.seconds, abs(row.error_percent))):
        if not best or max(abs(row.error_percent), floor) < max(abs(best[-1].error_percent), floor):
            best.append(row)
    return best


def fastest_within(rows: Sequence[Row], percent: float) -> dict[tuple[str, str], Row]:
    """Per tool and element the fastest row from which on, as sizes shrink, every error is within `percent`.

    A coarse mesh that happens to be right does not count.
    """
    found = {}
    for tool in dict.fromkeys((row.computation.tool, row.computation.element) for row in rows):
        own = [row for row in rows if (row.computation.tool, row.computation.element) == tool]
        own.sort(key=lambda row: row.computation.size)
        settled = []
        for row in own:
            if abs(row.error_percent) > percent:
                break
            settled.append(row)
        if settled:
            found[tool] = min(settled, key=lambda row: row.measured.seconds)
    return found
