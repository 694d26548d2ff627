"""Helpers of the benchmark cases: a meshed body with its boundary conditions, and its recovered stress."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fea.base.material import Material
from fea.solid.parity import Parity
from fea.solvers.constrained import displacement
from fea.stress.recovery import Recovery
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.tetmesh import TetMesh

# The material of the NAFEMS benchmarks and most others; only some cases use density and strength.
STEEL = Material(youngs_modulus=210e3, poissons_ratio=0.3, density=7.85e-9, yield_strength=400.0)


def mirror_planes(mesh: TetMesh) -> tuple[Surface, ...]:
    """Mirror planes at which the mesh is cut."""
    return tuple(plane for plane in PLANE_AXIS if plane in mesh.facets)


def held(mesh: TetMesh, supports: Mapping[Surface, tuple[int, ...]]) -> Mask:
    """Degrees of freedom (n_nodes, 3) fixed by the mirror planes and, by axes, on other surfaces."""
    fixed = np.zeros((len(mesh.points), 3), dtype=bool)
    planes = {plane: (PLANE_AXIS[plane],) for plane in mirror_planes(mesh)}
    for surface, axes in (planes | dict(supports)).items():
        for axis in axes:
            fixed[mesh.facets[surface].ravel(), axis] = True
    return fixed


def nodes_of(mesh: TetMesh, *surfaces: Surface) -> Ints:
    """Nodes that lie on every one of the surfaces."""
    common = np.arange(len(mesh.points))
    for surface in surfaces:
        common = np.intersect1d(common, mesh.facets[surface])
    return common


def furthest(values: Floats, target: float) -> float:
    """The value that is furthest from the target."""
    return float(values[np.abs(values - target).argmax()])


@dataclass(frozen=True)
class LoadedBody:
    """A body with its loads and constraints.

    Attributes
    ----------
    mesh, material
        The body.
    forces, fixed
        (n_nodes, 3) nodal forces, N, and constrained degrees of freedom.
    known
        Surfaces of known traction.
    traction
        Traction of the loaded surfaces, (n_nodes, 3, 1), MPa.
    """

    mesh: TetMesh
    material: Material
    forces: Floats
    fixed: Mask
    known: tuple[Surface, ...] = ()
    traction: Mapping[Surface, Floats] | None = None

    def solved(self) -> "SolvedBody":
        """Solve it."""
        u = displacement(self.mesh, self.material, self.forces, self.fixed)
        return SolvedBody(self.mesh, self.material, u, self.known, self.traction)


@dataclass(frozen=True)
class SolvedBody:
    """A body with its displacement.

    Attributes
    ----------
    mesh, material
        The body.
    displacement
        (n_nodes, 3, 1), mm, symmetric about the mirror planes, except about y = 0 if `parity` differs.
    known
        Surfaces of known traction.
    traction
        Traction of the loaded surfaces, (n_nodes, 3, 1), MPa.
    parity
        Parity about y = 0.
    """

    mesh: TetMesh
    material: Material
    displacement: Floats
    known: tuple[Surface, ...] = ()
    traction: Mapping[Surface, Floats] | None = None
    parity: Parity = Parity.SYMMETRIC

    @property
    def dofs(self) -> int:
        """Degrees of freedom of the mesh."""
        return self.mesh.points.size

    @cached_property
    def stress(self) -> Floats:
        """Stress, recovered as in a run: (n_nodes, 6), MPa, components XX YY ZZ XY YZ XZ."""
        recovery = Recovery(self.mesh, mirror_planes(self.mesh), self.known)
        nodal = recovery.nodal_stress(self.displacement, self.material, self.parity, self.traction)
        return np.asarray(nodal[:, :, 0])

    def node_at(self, *place: float) -> int:
        """Node at a corner of the body."""
        away = np.linalg.norm(self.mesh.points - place, axis=1)
        nearest = int(away.argmin())
        # The point of a benchmark is a corner of its geometry, so that there is a node.
        assert away[nearest] < 1e-6 * np.ptp(self.mesh.points)  # noqa: S101
        return nearest
