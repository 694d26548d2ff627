"""Round numbers for legends, scale bars and exaggerated deformation."""

import math

STEPS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
BANDS = 10
DEFORMED = 0.04  # the largest displacement is drawn as about so much of the rod's extent


def round_up(value: float) -> float:
    """Return the next round number, not below a positive `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in STEPS if step * power >= value * (1 - 1e-9))


def round_down(value: float) -> float:
    """Return the last round number, not above a positive `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in STEPS if step * power <= value * (1 + 1e-9))


def band_limits(maximum: float, minimum: float = 0.0) -> list[float]:
    """Return the limits, 0 among them, of `BANDS` or one more equal bands that hold both extremes.

    `minimum` is 0 or less; where it is 0 there are no more than `BANDS`.
    """
    if not (maximum > minimum and math.isfinite(maximum - minimum)):
        return [0.0, 1.0]
    step = round_up((maximum - minimum) / BANDS)
    first, last = (math.ceil(abs(end) / step * (1 - 1e-9)) for end in (minimum, maximum))
    return [step * k for k in range(-first, last + 1)]


def exaggeration(extent: float, displacement: float) -> float:
    """Return the round factor by which to draw displacements, of a body of this `extent`."""
    if not displacement > 0:
        return 1.0
    wanted = DEFORMED * extent / displacement
    return max(1.0, round_down(wanted))
