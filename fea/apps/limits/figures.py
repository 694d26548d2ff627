"""The results of `fea limits`, as `summary.json` holds them, and in words."""

from collections.abc import Mapping

from fea.analysis.figures import Figures
from fea.base.note import Note
from fea.base.shipped import shipped_toml

# What ends a rod, by the mode; the place is that of the whole rod.
ENDS: Mapping[str, str] = shipped_toml("base/failures.toml")["limits"]
# Modes that end it at one crank angle.
_AT_ONCE = ENDS.keys() - {"fatigue", "bolt fatigue"}


class LimitFigures(Figures):
    """A point at which a safety factor is the required one."""

    mode: str
    rpm: float
    peak_pressure_bar: float  #: absolute
    bar: float | None  #: of the factor, by the stress there, percent; None where there is no estimate
    gas_scale: float  #: multiple of the charge of the study: the key of [engine] that gives this peak
    interpolated: bool = False  #: between states that were solved
    at_mm: tuple[float, ...] | None  #: None where the mode has no place
    crank_deg: float | None


class Largest(LimitFigures):
    """The largest speed along a line of operation, or the largest peak pressure at a speed."""

    value: float  #: rpm, or absolute peak pressure, bar
    bar: float | None  #: of the value, in its unit; None where the stress has no error bar
    place: str  #: in words; empty where the mode has no place
    boost_bar: float  #: gauge pressure in the intake
    safe_from: float | None  #: the least value that is safe, where it is not the least of all


class LimitsFigures(Figures):
    """The limits of a rod in its engine."""

    study: str
    required_safety_factor: float
    text: str  #: the answer in words
    trusted: bool
    rpm: float  #: of the study, the highest
    #: safe_rpm, safe_boost: up to which speed, rpm, and boost, bar, it is safe; None where it is at none
    safe_rpm: float | None
    safe_boost: float | None
    largest_rpm: Largest | None
    largest_peak_pressure_bar: Largest | None
    closed_throttle: Largest | None
    limits: tuple[LimitFigures, ...]
    #: Hours of life by the speeds of the study, rpm, at its load; None without an end. Empty if not asked for
    life_hours: Mapping[str, float | None]
    #: (rpm, lowest, highest): peak pressures, bar, that are safe at some speeds, with what ends them
    table: tuple[tuple[str, ...], ...]
    notes: tuple[Note, ...]
    left_out: tuple[Note, ...]
    files: tuple[str, ...]
    timings_s: Mapping[str, float]
    total_s: float
    schema: str = "fea/limits/1"

    def reaches(self, rpm: float | None, boost: float | None) -> bool:
        """Whether the rod reaches a speed at full load, and a boost, bar, at its speed, less error bars."""
        fast, pressed = self.largest_rpm, self.largest_peak_pressure_bar
        if rpm is not None and (self.safe_rpm is None or rpm > self.safe_rpm - ((fast and fast.bar) or 0.0)):
            return False
        if boost is None:
            return True
        if self.safe_boost is None:
            return False
        spread = 0.0 if pressed is None else (pressed.bar or 0.0) / pressed.value * (self.safe_boost + 1.0)
        return self.safe_boost - spread >= boost


def ends(largest: Largest) -> str:
    """Say what ends a rod."""
    said = ENDS[largest.mode].format(place=f"the {largest.place}")
    at_once = largest.mode in _AT_ONCE and largest.crank_deg is not None
    return f"{said}, at {largest.crank_deg:.0f}°" if at_once else said


def with_bar(value: float, bar: float | None, unit: str) -> str:
    """Return a value with its error bar, both rounded: speeds to 10 rpm, pressures to 1 bar."""
    if bar is None:
        return f"{float(f'{value:.3g}'):.0f} {unit}"
    step = 10 if unit == "rpm" else 1
    return f"{step * round(value / step):.0f} ± {max(step * round(bar / step), step):.0f} {unit}"
