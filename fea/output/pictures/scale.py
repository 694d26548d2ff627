"""Round numbers for legends, scale bars and exaggerated deformation."""

import math

STEPS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
BANDS = 10
DEFORMED = 0.04  # drawn size of the largest displacement, relative to the rod's extent


def round_up(value: float) -> float:
    """Return the next round number, not below a positive `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in STEPS if step * power >= value * (1 - 1e-9))


def round_down(value: float) -> float:
    """Return the last round number, not above a positive `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in STEPS if step * power <= value * (1 + 1e-9))


def band_limits(maximum: float, minimum: float = 0.0) -> list[float]:
    """Return the limits, including 0, of at most `BANDS` + 1 equal bands that contain both extremes.

    `minimum` must not be positive; if it is 0, there are at most `BANDS` bands.
    """
    if not (maximum > minimum and math.isfinite(maximum - minimum)):
        return [0.0, 1.0]
    step = round_up((maximum - minimum) / BANDS)
    first, last = (math.ceil(abs(end) / step * (1 - 1e-9)) for end in (minimum, maximum))
    return [step * k for k in range(-first, last + 1)]


def exaggeration(extent: float, displacement: float) -> float:
    """Return a round magnification of the displacements for drawing a body of this `extent`."""
    if not displacement > 0:
        return 1.0
    wanted = DEFORMED * extent / displacement
    return max(1.0, round_down(wanted))
