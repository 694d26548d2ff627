"""How long a rod lasts, in the engine and in a fatigue test, in sentences."""

from collections.abc import Iterator

from fea.analysis.life_figures import CycleLifeFigures, ReliabilityFigures
from fea.analysis.summary_figures import Summary
from fea.base.units import KN
from fea.judge.cycle_life import LONGEST, LOW_CYCLE
from fea.judge.safety_factor import CycleLife
from fea.output.units import factor, hours_text, number, quantity


def life(summary: Summary) -> Iterator[str]:
    """Yield the hours of a duty, with their band and the speed that takes most of them, or of the speed."""
    if (found := summary.life) is None:
        if summary.cycle is not None and summary.cycle.life is not None:
            yield lasts(summary.cycle.life, f"at {summary.rpm:g} rpm")
        return
    low, high = (hours_text(hours) for hours in found.band_hours)
    band = "" if low == high else f" ({low} to {high})"
    most = max(found.duty, key=lambda entry: entry.damage_percent or 0.0)
    damage = f"; {number(most.damage_percent, '.3g')} % of the damage at {most.rpm:g} rpm"
    if found.assumed_line and found.hours is not None:
        least, longest, about = (roughly(hours) for hours in (*found.band_hours, found.hours))
        yield f"Life over the duty: {least} to {longest}, about {about} (assumed S–N line){damage}."
    else:
        yield f"Life over the duty: {hours_text(found.hours)}{band}{'' if found.endless else damage}."
    yield from _failing(found.reliability, "over the duty")


def log_lines(summary: Summary) -> Iterator[str]:
    """Yield which part of the log of a duty does the damage, and the hours with FKM's critical damage."""
    life, log = summary.life, None if summary.life is None else summary.life.log
    if life is None or log is None or life.hours is None:
        return
    worst, between = (number(share, ".2g") for share in (log.worst_percent, log.between_percent))
    yield (
        f"That is {number(life.duties, '.2g')} times {log.file}: {worst} % of the damage from "
        f"{log.worst_from_s:.4g} to {log.worst_to_s:.4g} s, {between} % by {log.between_cycles:.0f} cycles "
        f"between speeds or loads. With a critical damage of {log.critical_damage:g}, FKM's for varying "
        f"amplitudes (assumed): {roughly(log.hours_at_critical_damage)}."
    )


def lasts(life: CycleLifeFigures, speed: str) -> str:
    """Say how long the worst place lasts: its range first, one digit where the S–N line is assumed."""
    if not _determined(life):
        return f"Lasts minutes {speed}: below 10⁴ cycles stress is not elastic; the life is not determined."
    more = ""
    if life.steady_is_undamaged:
        more = (
            " Cycles of mean pressure alone would do no damage: single ones of more pressure exceed the "
            "endurance limit (cycle_pressure_percent of [scatter])."
        )
    for failing in _failing(life.reliability, speed):
        return f"{failing}{more}"
    ends = life.cycles is not None and life.cycles <= LONGEST
    about = f", about {roughly(life.hours)}" if ends and roughly(life.hours) != lasting(life) else ""
    return f"{'Lasts' if ends else 'Life'} {speed}: {lasting(life)}{about} {source_of(life)}.{more}"


def _failing(known: ReliabilityFigures | None, when: str) -> Iterator[str]:
    """Say by when a tenth and half of the rods fail, where that is known."""
    if known is not None and not known.conditional and known.b10_hours is not None:
        yield f"{b_lives(known)} {when}: a tenth and half of such rods fail by then, {known.first} first."


def lasting(life: CycleLifeFigures) -> str:
    """Return the range of the hours at one speed, in words."""
    if not _determined(life):
        return "minutes"
    if life.cycles is None or life.cycles > LONGEST:
        endless = "unlimited" if life.unlimited else "no failure by 10⁸ cycles expected"
        return endless if life.low_hours is None else f"{endless}, at least {roughly(life.low_hours)}"
    return " to ".join(dict.fromkeys((roughly(life.low_hours), roughly(life.high_hours))))


def b_lives(known: ReliabilityFigures) -> str:
    """Return B10 and B50 in words, as ranges where places may depend on one another."""
    most = known.at_most or known
    lives = (known.b10_hours, most.b10_hours), (known.b50_hours, most.b50_hours)
    (b10, b50) = (" to ".join(dict.fromkeys(roughly(bound, 2) for bound in bounds)) for bounds in lives)
    return f"B10 {b10}, B50 {b50}"


def _determined(life: CycleLifeFigures) -> bool:
    """Whether the hours are not merely those of elastic stress at so few cycles that it is not elastic."""
    return life.cycles is None or life.cycles >= LOW_CYCLE or life.by_strain


def roughly(hours: float | None, digits: int = 1) -> str:
    """Return hours with so many significant digits, minutes below one hour."""
    if hours is None:
        return "unlimited" if digits == 1 else "beyond 10⁸ cycles"
    value, own = (60 * hours, "min") if hours < 1 else (hours, "h")
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:,.{int(digits > 1 and rounded < 10)}f} {own}" if value >= 1 else f"less than 1 {own}"


def fatigue_test(summary: Summary) -> Iterator[str]:
    """Yield the factor of a fatigue test, and the cycles that the worst place lasts, the range first."""
    if (test := summary.bench) is None:
        return
    high, low = (quantity(force / KN, ".4g", "kN") for force in test.forces_N)
    mean, half = (quantity(stress, ".0f", "MPa") for stress in (test.mean_MPa, test.amplitude_MPa))
    lasts, life = "no S–N line is known or can be assumed", test.life
    if life is not None:
        least, middle, most = (_count(life, each) for each in (life.low, life.cycles, life.high))
        about = "" if least == most else f", {middle} in the middle"
        lasts = f"lasts {' to '.join(dict.fromkeys((least, most)))} cycles{about} {source_of(life)}"
    ratio = test.forces_N[1] / test.forces_N[0]
    yield (
        f"Fatigue test between {low} and {high} (R = {ratio:.3g}): factor {factor(test.safety_factor)} "
        f"(local stress in full), {test.where}, mean {mean}, amplitude {half}; {lasts}."
    )


def _count(life: CycleLife, cycles: float) -> str:
    if cycles > LONGEST:
        return "unlimited" if life.unlimited else "more than 10⁸"
    return f"{float(f'{cycles:.{0 if life.assumed else 1}e}'):,.0f}"


def source_of(life: CycleLifeFigures | CycleLife) -> str:
    """Return where a life comes from, in brackets."""
    line = "assumed S–N line" if life.assumed else "S–N line"
    if life.by_strain:
        line = f"low-cycle: Coffin–Manson with {'assumed' if life.assumed else 'known'} constants"
    return f"({line}, strength ± {life.band_percent:.0f} %)"
