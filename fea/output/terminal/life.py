"""The life over a duty as lines: hours with their band, and the share of every speed."""

from collections.abc import Sequence

from fea.analysis.cycle_figures import DutyFigures, LifeFigures
from fea.output.terminal.figures import number, place

# Entries with less of the damage are not listed.
_LEAST_PERCENT = 1.0


def life_lines(life: LifeFigures | None) -> list[str]:
    """Return the lines; none without a life."""
    if life is None:
        return []
    low, high = (hours_text(hours) for hours in life.band_hours)
    band = f"{low} to {high}" if low != high else low
    times = "" if life.duties is None else f" ({number(life.duties, '.3g')} times the duty)"
    said = f"Life over the duty: {hours_text(life.hours)}{times} at ({place(life.at_mm)}) mm in {life.part}"
    if life.endless:
        largest = max(entry.reversed_amplitude_MPa for entry in life.duty)
        limit = f"the endurance limit is {number(life.endurance_MPa, '.4g')} MPa"
        said += f", where the largest reversed amplitude is {number(largest, '.4g')} MPa and {limit}"
    lines = [f"{said}; {band} with {life.band_of} (±{life.band_percent:.3g} %)."]
    if not life.endless:
        single = number(life.largest_range_percent, ".4g")
        lines.append(f"Damage there: {_shares(life.duty)}; {single} % by the largest range of each cycle.")
    return lines


def hours_text(hours: float | None) -> str:
    """Return hours with three digits, or that there is no end."""
    return "no end" if hours is None else f"{number(hours, '.3g')} h"


def _shares(duty: Sequence[DutyFigures]) -> str:
    """Return the shares of the damage that matter, the largest first."""
    by_damage = sorted(duty, key=lambda entry: -(entry.damage_percent or 0.0))
    said = [_share(entry) for entry in by_damage if (entry.damage_percent or 0.0) >= _LEAST_PERCENT]
    others = len(duty) - len(said)
    rest = f"less than {_LEAST_PERCENT:g} % at each of the rest ({others})" if others else ""
    return ", ".join(filter(None, (*said, rest)))


def _share(entry: DutyFigures) -> str:
    gas = "" if entry.gas is None else f" ({entry.gas})"
    return f"{number(entry.damage_percent, '.3g')} % at {entry.rpm:g} rpm{gas}"
