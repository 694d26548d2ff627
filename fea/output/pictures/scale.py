"""Round numbers for legends, scale bars and exaggerated deformation."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import pyvista

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


Colours = npt.NDArray[np.uint8]


def _colours(of: str) -> npt.NDArray[np.int64]:
    return np.array([list(bytes.fromhex(each)) for each in of.split()])


# From blue over green to red, of even brightness and without dark ends, which would hide the shading.
RAINBOW = _colours("4052c8 4294ff 25c0e7 1be5b5 53fb77 96fe44 cdec34 f3c73a fe9b2d f36315 c82403")
# Blue below zero, red above, and pale near zero.
DIVERGING = _colours("314ab2 69a0e6 e4e4e0 f0966e ba1e26")


@dataclass(frozen=True)
class Bands:
    """Colours by value: increasing limits of the bands, and (n_bands, 3) red, green and blue."""

    limits: tuple[float, ...]
    colours: Colours

    @classmethod
    def up_to(cls, maximum: float, *, low: bool = False) -> "Bands":
        """Return bands from zero to `maximum`; with `low` small values are red."""
        limits = band_limits(maximum)
        places = np.linspace(0, 1, len(limits) - 1)
        return cls(tuple(limits), _between(RAINBOW, places)[:: -1 if low else 1])

    @classmethod
    def around_zero(cls, least: float, largest: float) -> "Bands":
        """Return bands for values of both signs, more saturated the farther from zero."""
        limits = band_limits(max(largest, 0.0), minimum=min(least, 0.0))
        middles = np.convolve(limits, [0.5, 0.5], mode="valid")
        return cls(tuple(limits), _between(DIVERGING, 0.5 + 0.5 * middles / np.abs(limits).max()))

    def table(self) -> "pyvista.LookupTable":
        """Return the colours for VTK."""
        import pyvista  # noqa: PLC0415 - a report has colours without VTK

        opaque = np.column_stack([self.colours, np.full(len(self.colours), 255, np.uint8)])
        return pyvista.LookupTable(values=opaque, scalar_range=(self.limits[0], self.limits[-1]))


def _between(scheme: npt.NDArray[np.int64], places: npt.NDArray[np.float64]) -> Colours:
    at = np.linspace(0, 1, len(scheme))
    return np.stack([np.interp(places, at, channel) for channel in scheme.T], axis=1).round().astype(np.uint8)
