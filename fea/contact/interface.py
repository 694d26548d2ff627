"""A bore and its pin."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fea.contact.elastic_pin import Pin, harmonics
from fea.contact.multipliers import Multipliers
from fea.solid.parity import Parity
from geometry.arrays import Floats

# Harmonics of an elastic pin's deflection, at least and at most: facets follow none that are finer.
FEWEST, HARMONICS = 16, 64
# Orders of half a cosine cos φ over |φ| < π/2, and its coefficients; those beyond do not reach the bore.
CARRIED = (0, 1, 2, 4, 6, 8, 10, 12)
_HALF_COSINE = np.array(
    [1 / np.pi, 0.5, *(2 / np.pi * (-1) ** (n // 2 + 1) / (n * n - 1) for n in CARRIED[2:])]
)


@dataclass(frozen=True)
class PinInBore:
    """A pin in a bore whose axis is parallel to z.

    Attributes
    ----------
    multipliers
        The pressures on the bore.
    center
        (x, z) of the middle of the bore and of the pin, mm.
    clearance
        Radius of the bore minus that of the pin, mm; negative for a press fit.
    relief
        Length and radial depth of the relief at either end of the bore, mm: it widens like a parabola.
    pin
        None for a rigid one.
    cut_y, cut_z
        Whether the cell represents its mirror images about y = 0, z = 0.
    harmonics
        Highest one of an elastic pin's deflection; by default what the facets can follow.
    """

    multipliers: Multipliers
    center: tuple[float, float]
    clearance: float
    pin: Pin | None
    cut_y: bool
    cut_z: bool
    relief: tuple[float, float] | None = None
    harmonics: int | None = None

    def initial(self) -> Floats:
        """Moments (n,) of the gap around the centred pin, as both are made."""
        gap = np.full_like(self.multipliers.areas, self.clearance)
        if self.relief is not None:
            length, depth = self.relief
            off = np.abs(self.multipliers.places[..., 2] - self.center[1])
            gap += depth * np.maximum(0.0, 1 - (off.max() - off) / length) ** 2
        return self.multipliers.moments(gap)

    def harmonic(self, order: int, field: Floats) -> dict[Parity, Floats]:
        """Moments (n, k) of cos nφ and of sin nφ times fields (n_facets n_points, k)."""
        waves = {Parity.SYMMETRIC: np.cos, Parity.ANTISYMMETRIC: np.sin}
        average, turned = self.multipliers.averaging, order * self._angle
        return {parity: average @ (wave(turned)[:, None] * field) for parity, wave in waves.items()}

    def resolved(self) -> int:
        """Number of equilateral facets around the bore: its facets follow no higher harmonics."""
        side = np.sqrt(4 / np.sqrt(3) * self.multipliers.areas.sum(axis=1).mean())
        x, y, _ = self.multipliers.places.reshape(-1, 3).T
        radius = float(np.hypot(x - self.center[0], y).mean())
        return int(np.clip(2 * np.pi * radius / side, FEWEST, HARMONICS))

    @cached_property
    def _angle(self) -> Floats:
        x, y, _ = self.multipliers.places.reshape(-1, 3).T
        return np.asarray(np.arctan2(y, x - self.center[0]))

    def shifted(self) -> tuple[Floats, Floats]:
        """Moments (n,) of the radial part of a unit shift of the pin along x, and along y."""
        found = self.harmonic(1, np.ones((len(self._angle), 1)))
        return found[Parity.SYMMETRIC][:, 0], found[Parity.ANTISYMMETRIC][:, 0]

    def tilted(self) -> tuple[Floats, Floats]:
        """Moments (n,) of the radial part of a unit turn of the rod about x, and about y."""
        found = self.harmonic(1, self.multipliers.places[..., 2].reshape(-1, 1))
        return -found[Parity.ANTISYMMETRIC][:, 0], found[Parity.SYMMETRIC][:, 0]

    @cached_property
    def deflection(self) -> "Deflection | None":
        """How the pin gives way, on the cell; None for a rigid one."""
        return None if self.pin is None else Deflection.of(self, self.pin)


@dataclass(frozen=True)
class Deflection:
    """Inward displacement of an elastic pin, as moments on the cell.

    Attributes
    ----------
    compliance
        Per parity (n, n), of pressures on the bore.
    carried
        Per parity (n, n_orders), of pressures of 1 MPa times cos nφ or sin nφ on the supports.
    """

    compliance: dict[Parity, Floats]
    carried: dict[Parity, Floats]

    @classmethod
    def of(cls, bore: PinInBore, pin: Pin) -> "Deflection":
        """Add up the harmonics."""
        size = bore.multipliers.size
        compliance = {parity: np.zeros((size, size)) for parity in Parity}
        carried = {parity: np.zeros((size, len(CARRIED))) for parity in Parity}
        z = bore.multipliers.places[..., 2].ravel() - bore.center[1]
        highest = bore.harmonics or bore.resolved()
        for mirrored in (True,) if bore.cut_z else (True, False):
            stations, answers = harmonics(pin, highest, mirrored=mirrored)
            along = _between(stations, np.abs(z)) * (1.0 if mirrored else np.sign(z)[:, None])
            for answer in answers:
                for parity, moments in bore.harmonic(answer.order, along).items():
                    share = (2 if bore.cut_y else 1) * (1 if bore.cut_z else 0.5)
                    compliance[parity] += share * moments @ answer.compliance @ moments.T
                    if mirrored and answer.order in CARRIED:
                        column = list(CARRIED).index(answer.order)
                        carried[parity][:, column] = moments @ answer.carried
        if not bore.cut_y:
            compliance = {Parity.SYMMETRIC: sum(compliance.values(), np.zeros((size, size)))}
        return cls(compliance, carried)

    def pressed(self, pin: Pin, force: Floats) -> dict[Parity, Floats]:
        """Moments (n,) of the deflection by the supports, for a force (2,) of the pin on the whole rod, N.

        They press with half a cosine around the side opposite to the force, constant along their length.
        """
        near, far = pin.carried or (0.0, np.inf)
        peak = 2 * float(np.hypot(*force)) / (np.pi * pin.radius * 2 * (far - near))
        turned = np.array(CARRIED) * (np.arctan2(force[1], force[0]) + np.pi)
        waves = {Parity.SYMMETRIC: np.cos(turned), Parity.ANTISYMMETRIC: np.sin(turned)}
        return {parity: self.carried[parity] @ (peak * _HALF_COSINE * wave) for parity, wave in waves.items()}


def _between(stations: Floats, z: Floats) -> Floats:
    """Values (n, n_stations) at places z of the quadratic functions: every other station ends an element."""
    ends = stations[::2]
    element = np.clip(np.searchsorted(ends, z, side="right") - 1, 0, len(ends) - 2)
    s = np.clip((z - ends[element]) / (ends[element + 1] - ends[element]), 0.0, 1.0)
    values = np.zeros((len(z), len(stations)))
    rows = np.arange(len(z))
    for place, value in enumerate(((1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1))):
        values[rows, 2 * element + place] = value
    return values
