"""Equilibrium check at a cross-section: resultants of the stress against the forces beyond it."""

import math
from functools import cached_property

from fea.solid.inertia import mass_beyond
from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.instants import Instants
from mesh.slices import Slice, cut
from mesh.tetmesh import TetMesh

_XX, _XY = 0, 3


class SectionBalance:
    """The section of a rod at x = `station`, mm, and the cell's mass beyond it, computed on first use."""

    def __init__(
        self, whole: TetMesh, cell: TetMesh, density: float | Floats, rod_length: float, station: float
    ) -> None:
        self._whole, self._cell, self._density = whole, cell, density
        self._rod_length, self._station = rod_length, station

    def error(self, case: Instants, stress: Floats) -> float:
        """Equilibrium error of a case's nodal stress (n_nodes, 6), MPa, at the section.

        Returns the larger of the force error and the moment error over the radius of gyration, relative to
        the largest bore force plus the moment over the radius of gyration.
        """
        x, y = map(float, case.pin)
        moment = (self._rod_length - self._station) * y
        if case.motions.any():
            along, across, turning = _inertia(self._beyond, case)
            center_x, center_y, _ = self._beyond.center
            moment += (center_x - self._station) * across - center_y * along + turning
            x, y = x + along, y + across
        values, areas = self._slice.at_corners(stress[:, [_XX, _XY]]), self._slice.areas
        normal, shear = (areas @ values.mean(axis=1)).tolist()
        sigma, height = values[..., 0], self._slice.places[..., 0]  # each linear on a triangle
        products = height.sum(axis=1) * sigma.sum(axis=1) + (height * sigma).sum(axis=1)
        off = max(abs(x - normal), abs(y - shear), abs(moment + areas @ products / 12) / self._gyration)
        return float(off / (float(case.largest_force) + abs(moment) / self._gyration))

    @cached_property
    def _slice(self) -> Slice:
        return cut(self._whole, self._station)

    @cached_property
    def _gyration(self) -> float:
        """Radius of gyration about z, mm."""
        section = self._slice.section()
        return math.sqrt(section.inertia_z / section.area)

    @cached_property
    def _beyond(self) -> MassProperties:
        return mass_beyond(self._cell, self._density, self._station)


def _inertia(body: MassProperties, motion: Instants) -> tuple[float, float, float]:
    """D'Alembert force along x and y, N, and moment about the centre of gravity, N·mm."""
    x, y, _ = body.center
    ax, square, ay, alpha = map(float, motion.motions)
    along, across = ax - alpha * y - square * x, ay + alpha * x - square * y
    return -body.mass * along, -body.mass * across, -body.inertia_z * alpha
