"""The study of one row of a sweep."""

from fea.sweep.plan import rows, study_of
from fea.sweep.sweep_file import Sweep
from geometry.invalid import require


def study_text(sweep: Sweep, number: int) -> str:
    """Return the study of a row as a file that ``fea run`` takes.

    Raises
    ------
    InvalidValue
        There is no such row, or its design breaks a rule.
    """
    found = rows(sweep)
    require(0 <= number < len(found), "--study", number, f"must be a row, 0 to {len(found) - 1}")
    row = found[number]
    return study_of(sweep, row.design, [row.rpm]).text()
