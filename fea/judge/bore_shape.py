"""How a bore changes its shape under load."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# Even harmonics of the radial displacement; odd ones move a bore without changing any diameter, or cancel on
# opposite sides.
_ORDERS = np.arange(13)
_DIRECTIONS = np.linspace(0.0, np.pi, 181)


@dataclass(frozen=True)
class BoreShape:
    """Change of a bore's diameter, mean along the bore."""

    direction: Floats  #: (n,) from rod +x, 0 … π, rad; the last is the first diameter again
    change: Floats  #: (n,) of the diameter in that direction, mm

    @property
    def widest(self) -> tuple[float, float]:
        """The largest change, mm, and its direction, rad."""
        place = int(self.change[:-1].argmax())
        return float(self.change[place]), float(self.direction[place])

    @property
    def narrowest(self) -> tuple[float, float]:
        """The least change, mm, and its direction, rad."""
        place = int(self.change[:-1].argmin())
        return float(self.change[place]), float(self.direction[place])

    @property
    def ovality(self) -> float:
        """Difference of the largest and the least diameter of a bore that was round, mm."""
        return float(np.ptp(self.change))


def bore_shape(mesh: TetMesh, surface: Surface, center_x: float, displacement: Floats) -> BoreShape:
    """Fit harmonics to the radial displacement of the nodes of a bore of the whole rod.

    The axis of the bore is parallel to z and passes through (`center_x`, 0); the displacement is (n_nodes,
    3), mm.
    """
    nodes = np.unique(mesh.facets[surface])
    x, y = mesh.points[nodes, 0] - center_x, mesh.points[nodes, 1]
    angle = np.arctan2(y, x)
    outwards = displacement[nodes, 0] * np.cos(angle) + displacement[nodes, 1] * np.sin(angle)
    amplitudes = np.linalg.lstsq(_waves(angle, _ORDERS), outwards, rcond=None)[0]
    even = np.concatenate([_ORDERS, _ORDERS[1:]]) % 2 == 0
    return BoreShape(_DIRECTIONS, 2 * _waves(_DIRECTIONS, _ORDERS)[:, even] @ amplitudes[even])


def _waves(angle: Floats, orders: Ints) -> Floats:
    turned = np.multiply.outer(angle, orders)
    return np.asarray(np.concatenate([np.cos(turned), np.sin(turned[:, 1:])], axis=1))
