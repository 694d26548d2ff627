"""A printed figure and its recomputation."""

import math
from dataclasses import dataclass
from enum import StrEnum


class Status(StrEnum):
    """How a printed figure compares with the printed formula."""

    AGREES = "agrees"  # to one unit of the last printed digit
    EXPLAINED = "explained"  # it differs, and the given slip reproduces it
    NAMED = "named"  # it differs and is known to be wrong, but cannot be derived from the source
    UNEXPLAINED = "unexplained"
    NOT_PRINTED = "not printed"  # a computed figure without a printed one


@dataclass(frozen=True)
class Slip:
    """The error in one printed figure.

    Attributes
    ----------
    text
        Explanation in words.
    value
        The figure that results from it; None if the error cannot be reproduced.
    is_rounding
        Whether an intermediate figure was only rounded.
    """

    text: str
    value: float | None
    is_rounding: bool = False


@dataclass(frozen=True)
class Row:
    """A printed figure, the result of the printed formula, and the correct figure.

    Attributes
    ----------
    source, table, quantity, at, unit
        Identify the figure; `at` is crank angle and speed.
    published
        The figure as printed, or None.
    digit
        One unit of the last printed digit.
    as_published
        From the printed formula and intermediate figures, including its systematic error.
    corrected
        From correct mechanics.
    formula_cause
        Why `as_published` and `corrected` differ.
    slip
        Why `published` and `as_published` differ in this one cell.
    """

    source: str
    table: str
    quantity: str
    at: str
    unit: str
    published: float | None
    digit: float
    as_published: float
    corrected: float
    formula_cause: str = ""
    slip: Slip | None = None

    @property
    def difference(self) -> float:
        """|published − as published|, zero if nothing is printed."""
        return 0.0 if self.published is None else abs(self.published - self.as_published)

    @property
    def error(self) -> float:
        """|published − corrected|, zero if nothing is printed."""
        return 0.0 if self.published is None else abs(self.published - self.corrected)

    @property
    def is_wrong(self) -> bool:
        """Whether the printed figure differs from the correct one."""
        return self.published is not None and not self._within(self.corrected)

    @property
    def status(self) -> Status:
        """How the printed figure compares."""
        if self.published is None:
            return Status.NOT_PRINTED
        if self._within(self.as_published):
            return Status.AGREES
        if self.slip is None:
            return Status.UNEXPLAINED
        if self.slip.value is None:
            return Status.NAMED
        return Status.EXPLAINED if self._within(self.slip.value) else Status.UNEXPLAINED

    @property
    def cause(self) -> str:
        """All reasons why the three figures differ; empty if they do not."""
        wrong = self.published is None or not self._within(self.corrected)
        slipped = self.slip is not None and self.status is not Status.AGREES
        parts = [self.slip.text] if self.slip is not None and slipped else []
        return "; ".join(parts + [self.formula_cause] * (wrong and bool(self.formula_cause)))

    def as_dict(self) -> dict[str, object]:
        """Return the row with the names that other programs rely on."""
        return {
            "source": self.source,
            "table": self.table,
            "quantity": self.quantity,
            "at": self.at,
            "unit": self.unit,
            "published": self.published,
            "as_published": self.as_published,
            "corrected": self.corrected,
            "cause": self.cause,
            "status": self.status.value,
        }

    def _within(self, value: float) -> bool:
        # One unit of the last digit, plus rounding, which matters for figures printed with ten digits.
        assert self.published is not None  # noqa: S101
        return abs(self.published - value) <= self.digit * (1 + 1e-6) + 4 * math.ulp(self.published)
