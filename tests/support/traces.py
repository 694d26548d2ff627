"""Pressure traces of engines: a made-up one in any convention, and random ones with the truth of each."""

from dataclasses import dataclass

import numpy as np

from fea.study.traces import Surroundings, parse_trace
from geometry.errors import InvalidValue

ATMOSPHERE = 1.01325  # bar
RATIO = 10.0
BAR_IN = {"bar": 1.0, "kPa": 100.0, "MPa": 0.1, "Pa": 1e5, "psi": 14.503773773}


def absolute(degrees, intake=0.93, burnt=1.5):
    """Absolute pressure, bar, over degrees from firing TDC: polytropic strokes, combustion, open valves."""
    degrees = (np.asarray(degrees, float) + 360) % 720 - 360
    closed = intake * (_volume(180.0) / _volume(degrees)) ** 1.32
    burn = 1 - np.exp(-5 * (np.clip(degrees + 10, 0, None) / 50) ** 3)
    closed = closed * (1 + burnt * burn)
    end = intake * (1 + burnt)
    exhaust = 1.06 + (end - 1.06) * np.exp(-(degrees - 180) / 15)
    return np.select([degrees < -180, degrees <= 180], [np.full_like(closed, intake), closed], exhaust)


def gauge(degrees, **kwargs):
    """Gauge pressure, bar, over degrees with firing TDC at 360°."""
    return absolute(np.asarray(degrees) - 360, **kwargs) - ATMOSPHERE


def _volume(degrees):
    theta = np.radians(degrees)
    rod = (1 - np.sqrt(1 - (0.3 * np.sin(theta)) ** 2)) / 0.3
    return 1 / (RATIO - 1) + (1 - np.cos(theta) + rod) / 2


def written(angles, pressures, *, separator=",", comma=False, header=(), newline="\n"):
    """The text of a file with these columns."""
    columns = np.column_stack([angles, pressures])
    rows = [separator.join(f"{value:.9g}" for value in row) for row in columns]
    text = newline.join(rows).replace(".", ",") if comma else newline.join(rows)
    return newline.join([*header, text, ""])


UNITS = {unit: BAR_IN[unit] for unit in ("bar", "kPa", "psi")}


@dataclass(frozen=True)
class Drawn:
    """A trace, and the truth of it."""

    text: str
    around: Surroundings
    gauge: np.ndarray  #: bar, without noise and offset
    shift: float  #: bar, by which the zero of the file is off, against absolute pressure
    known: bool  #: whether unit, ratio and angles are
    misled: bool  #: whether ratio or angles are wrong
    what: str


def cycle(numbers, angles, ratio, rod_ratio):
    """Absolute pressure, bar, over degrees from firing TDC of a random engine, and whether it fires."""
    diesel, fired = ratio >= 13.5, numbers.random() < 0.7
    theta = np.radians(angles)
    rod = (1 - np.sqrt(1 - (rod_ratio * np.sin(theta)) ** 2)) / rod_ratio
    volume = 1 / (ratio - 1) + (1 - np.cos(theta) + rod) / 2
    intake = numbers.uniform(0.9, 2.3) if diesel else numbers.uniform(0.4, 1.9)
    exponent = numbers.normal(1.36 if diesel else 1.32, 0.02)
    shut = -180 + numbers.uniform(25, 55)
    at_shut = np.interp(shut, angles, volume)
    closed = intake * (at_shut / volume) ** exponent
    if fired:
        start = numbers.uniform(-8, 2) if diesel else numbers.uniform(-25, -5)
        length = numbers.uniform(40, 70)
        burnt = 1 - np.exp(-5 * (np.clip(angles - start, 0, None) / length) ** numbers.uniform(2, 3.2))
        closed = closed * (1 + numbers.uniform(0.5, 2.2) * burnt)
    else:  # heat and leaks
        closed = closed * (1 - 0.004 * numbers.uniform(0.5, 1.5) * np.clip(angles + 10, 0, None) ** 0.8)
    end = np.interp(140, angles, closed)
    back = ATMOSPHERE + numbers.uniform(0, 0.4)
    exhaust = back + (end - back) * np.exp(-np.clip(angles - 140, 0, None) / 15)
    waves = 0.03 * np.sin(np.radians(angles * numbers.uniform(3, 8)))
    return np.select([angles < shut, angles <= 140], [intake + waves, closed], exhaust + waves), fired


def drawn(seed):
    """Draw a trace."""
    numbers = np.random.default_rng(seed)
    ratio, rod_ratio = numbers.uniform(8.5, 18.0), numbers.uniform(0.23, 0.32)
    step = float(numbers.choice([0.1, 0.25, 0.5, 1.0]))
    angles = np.arange(-360.0, 360.0, step)
    pressures, fired = cycle(numbers, angles, ratio, rod_ratio)
    phase = float(numbers.choice([0.0, 0.0, numbers.uniform(-2, 2)]))
    told_ratio = ratio * float(numbers.choice([1.0, 1.0, 0.9, 1.1]))
    unit, heading = str(numbers.choice(list(UNITS))), bool(numbers.random() < 0.6)
    reference = str(numbers.choice(["absolute", "gauge"]))
    offset = float(numbers.choice([0.0, numbers.uniform(-6, 6)]))
    noise = float(numbers.choice([0.0, 0.02, 0.05]))
    shift = offset - ATMOSPHERE * (reference == "gauge")
    file = (pressures + shift + noise * numbers.normal(size=angles.size)) * UNITS[unit]
    shown = angles + phase + float(numbers.choice([0.0, 360.0]))
    names = f"crank angle [deg],p [{unit} {'abs' if reference == 'absolute' else 'gauge'}]"
    rows = "\n".join(f"{a:.3f},{p:.6g}" for a, p in zip(shown, file, strict=True))
    return Drawn(
        text=f"{names}\n{rows}\n" if heading else f"{rows}\n",
        around=Surroundings(compression_ratio=told_ratio, rod_ratio=rod_ratio),
        gauge=pressures - ATMOSPHERE,
        shift=shift,
        known=heading and told_ratio == ratio and phase == 0,
        misled=told_ratio != ratio or phase != 0,
        what=f"{'fired' if fired else 'motored'} {unit} {reference}, {'a' if heading else 'no'} heading, "
        f"ratio {ratio:.1f} told {told_ratio:.1f}, {phase:+.1f}°, offset {offset:+.2f} bar, noise {noise}, "
        f"step {step}",
    )


def judged(one):
    """``right``, ``refused`` or ``wrong``, and why."""
    try:
        found = parse_trace(one.text, "trace.csv", around=one.around).trace
    except InvalidValue as error:
        named = "engine." in str(error) or "Set pressure_unit" in str(error)
        return ("refused" if named else "wrong"), str(error)
    reading = found.reading
    zero = reading.offset_bar + ATMOSPHERE * (reading.reference == "gauge") + one.shift
    force = 10 * found.pressures.max() / one.gauge.max() - 1
    right = abs(zero) <= (0.35 if one.misled else 0.2) and abs(force) <= 0.01
    return ("right" if right else "wrong"), f"zero off by {zero:+.3f} bar, force by {100 * force:+.2f} %"
