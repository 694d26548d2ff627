"""The colour bands of a picture: equal bands between round limits."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from fea.output.pictures.scale import band_limits

if TYPE_CHECKING:
    import pyvista

Colours = npt.NDArray[np.uint8]

# From blue over green to red, of even brightness and without dark ends, which would hide the shading.
RAINBOW = np.array(
    [
        [64, 82, 200],
        [66, 148, 255],
        [37, 192, 231],
        [27, 229, 181],
        [83, 251, 119],
        [150, 254, 68],
        [205, 236, 52],
        [243, 199, 58],
        [254, 155, 45],
        [243, 99, 21],
        [200, 36, 3],
    ],
)
# Blue below zero, red above, and pale near zero.
DIVERGING = np.array([[49, 74, 178], [105, 160, 230], [228, 228, 224], [240, 150, 110], [186, 30, 38]])


@dataclass(frozen=True)
class Bands:
    """Colours by value.

    Attributes
    ----------
    limits
        Limits of the bands, increasing.
    colours
        (n_bands, 3) red, green and blue.
    """

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
    """Colours at places from 0 to 1 of a scheme."""
    at = np.linspace(0, 1, len(scheme))
    return np.stack([np.interp(places, at, channel) for channel in scheme.T], axis=1).round().astype(np.uint8)
