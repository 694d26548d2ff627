"""The data of an animation of the crank cycle."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from fea.output.pictures.scale import exaggeration
from fea.output.pictures.surface import DrawnSurface
from geometry.arrays import Floats

Singles = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Film:
    """A rod at instants of the cycle, and how it is drawn there."""

    skin: DrawnSurface  #: its outer surface without load, rod frame, mm
    displacement: Singles  #: (n_frames, n_nodes, 3) of the skin's nodes, rod frame, mm
    von_mises: Singles  #: (n_frames, n_nodes), in the unit that is shown
    crank_angle: Floats  #: (n_frames,), rad
    #: crank_radius, rod_length, pin_offset: of the engine, mm
    crank_radius: float
    rod_length: float
    pin_offset: float
    title: tuple[str, ...]  #: lines of the title: study and speed
    unit: str = "MPa"  #: of the stress

    @cached_property
    def exaggeration(self) -> float:
        """Magnification of the displacements in the drawing."""
        largest = float(np.linalg.norm(self.displacement, axis=2).max())
        return exaggeration(float(np.ptp(self.skin.points, axis=0).max()), largest)

    def deformed(self, k: int) -> Floats:
        """(n_nodes, 3) drawn positions of the nodes in the rod's frame."""
        return np.asarray(self.skin.points + self.exaggeration * self.displacement[k])

    def placement(self, k: int) -> Floats:
        """(4, 4) transformation from the rod's frame to the engine's.

        The crank pin is on its circle; the rod is rotated so that its small end, at the magnified length, is
        on the cylinder axis.
        """
        theta, r = self.crank_angle[k], self.crank_radius
        near = np.abs(self.skin.points[:, 0] - self.rod_length) < 0.05 * self.rod_length
        stretched = self.rod_length + self.exaggeration * float(self.displacement[k, near, 0].mean())
        sin = (r * np.sin(theta) - self.pin_offset) / stretched
        cos = np.sqrt(1 - sin**2)
        placed = np.eye(4)
        placed[:2] = [[cos, sin, 0, r * np.cos(theta)], [-sin, cos, 0, r * np.sin(theta)]]
        return placed
