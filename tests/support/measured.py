"""A made-up pressure over the cycle of a firing engine, and files that hold it in any convention."""

import numpy as np

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
