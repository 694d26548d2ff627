"""Safety factors with their intervals, and lives in cycles: the types of all that are printed or compared."""

from dataclasses import dataclass
from enum import StrEnum
from math import ceil, inf, isfinite, isnan, log10
from typing import Any, Self

# Below this a factor has two significant digits, not two decimals.
_SMALL = 0.095


class SurvivalAnswer(StrEnum):
    """Whether the rod survives, from good to bad."""

    SURVIVES = "survives"
    NOT_JUDGED = "does not yield"  # every factor that is known suffices, but fatigue is not judged
    SHAKES_DOWN = "shakes down"  # likewise, of a rod that flows at first
    UNDECIDED = "undecided"
    FAILS = "fails"


class SafetyFactor(float):
    """A safety factor: a number with its interval, the mode of failure, and where and when it holds.

    The interval contains the factor of the exact stress, as far as the error bar holds; without an estimate
    of the error it is the number itself.
    """

    low: float  #: the factor if the stress is higher by its error bar
    high: float  #: the factor if the stress is lower by its error bar
    mode: str  #: the mode of failure: ``yielding``, ``fatigue`` or ``buckling``, or one of bolts or joint
    instant: str  #: the load case; empty for the whole cycle
    place: str  #: in words; empty where the mode has no place, or the load case tells it

    def __new__(
        cls,
        value: float,
        low: float | None = None,
        high: float | None = None,
        *,
        mode: str = "yielding",
        instant: str = "",
        place: str = "",
    ) -> Self:
        """Make a factor of its number and its interval, which is the number where it is not given."""
        made = super().__new__(cls, value)
        made.low = float(value if low is None else low)
        made.high = float(value if high is None else high)
        made.mode, made.instant, made.place = mode, instant, place
        return made

    def __getnewargs_ex__(self) -> tuple[tuple[float, float, float], dict[str, str]]:
        """Return the arguments for copies and for other processes."""
        return (
            (float(self), self.low, self.high),
            {"mode": self.mode, "instant": self.instant, "place": self.place},
        )

    @classmethod
    def of_stress(cls, value: float, error_percent: float | None, **names: str) -> Self:
        """Return the factor of a stress with an error bar, percent of the stress; None: no estimate."""
        share = (error_percent or 0.0) / 100
        return cls(value, value / (1 + share), value / (1 - share) if share < 1 else inf, **names)

    def against(self, mode: str, instant: str = "", place: str = "") -> Self:
        """Return the same number and interval as a factor against a mode of failure."""
        return type(self)(float(self), self.low, self.high, mode=mode, instant=instant, place=place)

    def answer(self, required: float) -> SurvivalAnswer:
        """Compare the interval with a required factor."""
        if self.high < required:
            return SurvivalAnswer.FAILS
        return SurvivalAnswer.SURVIVES if self.low >= required else SurvivalAnswer.UNDECIDED

    @property
    def percent(self) -> float | None:
        """Error bar of the stress behind the factor; None where there is no estimate."""
        return None if self.low == self.high == self else 100 * (float(self) / self.low - 1)

    @property
    def named(self) -> str:
        """The number with its interval and the mode of failure, which is left out for yielding."""
        return f"{self.text}{'' if self.mode == 'yielding' else f' against {self.mode}'}"

    @property
    def text(self) -> str:
        """The number with its interval, load case and place, as ``1.24 (1.00 … 1.61; tension)``.

        The interval is written with ± only where it is symmetric in the digits that are printed.
        """
        where = ", ".join(part for part in (self.instant, self.place) if part)
        number, bar = printed(self), interval(self)
        if bar.startswith("("):
            return f"{number} {bar[:-1]}; {where})" if where else f"{number} {bar}"
        return " ".join(part for part in (number, bar, f"({where})" if where else "") if part)


@dataclass(frozen=True)
class CycleLife:
    """Crank cycles, or those of a fatigue test, to failure of a place; infinite (null) without damage."""

    cycles: float  #: at the assumed or median strength
    #: low, high: with all strengths lower and higher by the band
    low: float
    high: float
    band_percent: float
    assumed: bool  #: whether the line that gives the cycles is
    unlimited: bool  #: whether a life without damage may be called so
    by_strain: bool = False  #: whether cycles below 10⁴ follow from strain; else they are indicative


def decimals(value: float) -> int:
    """Return how many decimals a factor is printed with: two, or more where these would be zeros."""
    small = 0 < value < _SMALL
    return 2 - ceil(log10(value)) if small else 2


def printed(value: float | None) -> str:
    """Return the number of a factor; a dash where it is not known."""
    if value is None:
        return "–"
    return f"{float(value):.{decimals(value)}f}" if isfinite(value) else "∞" if value > 0 else "–"


def interval(factor: SafetyFactor) -> str:
    """Return the interval behind the number: ``± 0.02``, ``(1.00 … 1.61)``, or nothing without a bar."""
    if factor.low == factor.high or not isfinite(factor):
        return ""
    places = decimals(factor)
    unit = 10.0**-places
    if not isfinite(factor.high):
        return f"({factor.low:.{places}f} … ∞)"
    below, above = (round(abs(factor - end) / unit) for end in (factor.low, factor.high))
    if below == above:
        return f"± {max(below, 1) * unit:.{places}f}"
    return f"({factor.low:.{places}f} … {factor.high:.{places}f})"


def without_bar(value: Any) -> SafetyFactor | None:
    """Return a number as a factor without a bar; None for what does not apply (None or NaN)."""
    if value is None or isinstance(value, SafetyFactor):
        return value
    return None if isnan(value) else SafetyFactor(value)
