"""One printed figure against its recomputation."""

import math
from dataclasses import dataclass
from enum import StrEnum


class Status(StrEnum):
    """How a printed figure compares with the printed formula."""

    AGREES = "agrees"  # to one unit of the last printed digit
    EXPLAINED = "explained"  # it differs, and the named slip reproduces it
    NAMED = "named"  # it differs, and is known to be wrong, but nothing of the source yields it
    UNEXPLAINED = "unexplained"
    NOT_PRINTED = "not printed"  # a figure of ours that belongs beside the printed ones


@dataclass(frozen=True)
class Slip:
    """What happened to one printed figure.

    Attributes
    ----------
    text
        In words.
    value
        The figure that results from it; None where the slip cannot be traced.
    is_rounding
        Whether an intermediate figure was only rounded.
    """

    text: str
    value: float | None
    is_rounding: bool = False


@dataclass(frozen=True)
class Row:
    """A printed figure, the printed formula's, and the right one.

    Attributes
    ----------
    source, table, quantity, at, unit
        Which figure it is; `at` holds crank angle and speed.
    published
        As printed, or None.
    digit
        One unit of the last printed digit.
    as_published
        From the printed formula and intermediates, its systematic slip included.
    corrected
        From sound mechanics.
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
        """|published − as published|, zero where nothing is printed."""
        return 0.0 if self.published is None else abs(self.published - self.as_published)

    @property
    def error(self) -> float:
        """|published − corrected|, zero where nothing is printed."""
        return 0.0 if self.published is None else abs(self.published - self.corrected)

    @property
    def is_wrong(self) -> bool:
        """Whether the printed figure is not that of sound mechanics."""
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
        """Every reason why the three figures differ; empty where they do not."""
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
        # A unit of the last digit, and the rounding of figures that print ten digits.
        assert self.published is not None  # noqa: S101
        return abs(self.published - value) <= self.digit * (1 + 1e-6) + 4 * math.ulp(self.published)
