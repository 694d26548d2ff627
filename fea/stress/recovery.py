"""Nodal stress from a displacement field."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse

from fea.base.material import Material
from fea.solid.element import (
    COMPONENTS,
    gauss_places,
    inverse_and_determinant,
    jacobians,
    reference_nodes,
    shape_functions,
    stress_from_gradient,
)
from fea.solid.parity import Parity
from fea.stress.recovery_surface import SurfaceStress
from geometry.arrays import Floats, Ints
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.tetmesh import TetMesh, submesh


def stress_parity(plane: Surface) -> npt.NDArray[np.int64]:
    """Sign (6,) of each stress component when a symmetric field is mirrored about `plane`."""
    axis = PLANE_AXIS[plane]
    return np.array([-1 if (i == axis) != (j == axis) else 1 for i, j in COMPONENTS])


def extrapolation(n_nodes: int) -> Floats:
    """Matrix (n_nodes, n_places) that extrapolates values linearly from the Gauss points to the nodes."""
    places, nodes = gauss_places(n_nodes), reference_nodes(n_nodes)
    if len(places) == 1:
        return np.ones((n_nodes, 1))
    return np.asarray(np.insert(nodes, 0, 1, axis=1) @ np.linalg.inv(np.insert(places, 0, 1, axis=1)))


class ElementStress:
    """Stress at fixed reference places of every element; the geometry is evaluated only once.

    The places (n_places, 3) are in the reference tetrahedron: by default the Gauss points of the stiffness.
    """

    def __init__(self, mesh: TetMesh, places: Floats | None = None) -> None:
        n_nodes = mesh.tets.shape[1]
        self._tets = mesh.tets
        at = (gauss_places(n_nodes) if places is None else places).T
        self._linear, _ = shape_functions(4, at)
        _, self._slopes = shape_functions(n_nodes, at)
        self._inverse, _ = inverse_and_determinant(jacobians(mesh.points[mesh.tets], self._slopes))

    def gradient(self, displacement: Floats) -> Floats:
        """Gradients ∂u_i/∂x_j (n_elements, n_places, 3 j, 3 i, n_cases) of u (n_points, 3, n_cases)."""
        n_points, _, n_cases = displacement.shape
        n_places, n_nodes, _ = self._slopes.shape
        nodal = displacement.reshape(n_points, 3 * n_cases)[self._tets]
        slopes = self.slopes().reshape(-1, 3 * n_places, n_nodes)
        return (slopes @ nodal).reshape(-1, n_places, 3, 3, n_cases)

    def slopes(self) -> Floats:
        """Derivatives ∂N_a/∂x_j (n_elements, n_places, 3 j, n_nodes) of the shape functions."""
        return np.asarray(self._inverse.swapaxes(-1, -2) @ self._slopes.swapaxes(-1, -2))

    def __call__(self, displacement: Floats, material: Material, pressure: Floats | None = None) -> Floats:
        """Stress (n_elements, n_places, 6, n_cases), MPa, of displacements (n_points, 3, n_cases), mm.

        A pressure (n_points, n_cases), MPa, takes the place of λ ∇·u if the solution has one
        (`fea.solvers.mixed`).
        """
        gradient = self.gradient(displacement).transpose(0, 1, 4, 3, 2)
        if pressure is None:
            return stress_from_gradient(gradient, material).swapaxes(-1, -2)
        stress = stress_from_gradient(gradient, material.without_lambda()).swapaxes(-1, -2)
        stress[:, :, :3] += (self._linear @ pressure[self._tets[:, :4]])[:, :, None]
        return stress


class Recovery:
    """Continuous nodal stress; operators that depend only on the mesh are computed once.

    Inside the body it is the mean over the elements that share a node, each extrapolated linearly from its
    Gauss points. On the mirror planes at which the mesh is cut the other half adds the same values with the
    signs of `stress_parity`, so that the mean does not change for even components and is zero for odd ones.
    On surfaces of known traction, those without displacement constraints, it comes from `SurfaceStress`.
    """

    def __init__(
        self, mesh: TetMesh, planes: tuple[Surface, ...] = (), surfaces: tuple[Surface, ...] = ()
    ) -> None:
        n_points, (n_elements, n_nodes) = len(mesh.points), mesh.tets.shape
        self.gauss_stress = ElementStress(mesh)
        self._on_plane = {plane: np.unique(mesh.facets[plane]) for plane in planes}
        self._surface = SurfaceStress(mesh, surfaces, planes) if surfaces else None

        counts = np.bincount(mesh.tets.ravel(), minlength=n_points)
        weights = extrapolation(n_nodes) / counts[mesh.tets][:, :, None]
        n_places = weights.shape[2]
        places = np.broadcast_to(np.arange(n_elements * n_places).reshape(-1, 1, n_places), weights.shape)
        nodes = np.broadcast_to(mesh.tets[:, :, None], weights.shape)
        mean = sparse.csr_array(
            (weights.ravel(), (nodes.ravel(), places.ravel())), shape=(n_points, n_elements * n_places)
        )
        self._inside = np.setdiff1d(np.arange(n_points), self._surface.nodes if self._surface else [])
        mean = mean[self._inside]
        slopes = self.gauss_stress.slopes()
        n_elements, n_places, _, n_nodes = slopes.shape
        columns = np.repeat(mesh.tets.astype(mean.indices.dtype), n_places, axis=0).ravel()
        starts = np.arange(0, columns.size + 1, n_nodes, dtype=columns.dtype)
        shape = (n_elements * n_places, len(mesh.points))
        along = [
            sparse.csr_array((slopes[:, :, axis].ravel(), columns, starts), shape=shape) for axis in range(3)
        ]
        self._gradient = sparse.csr_array(sparse.vstack([mean @ slope for slope in along], format="csr"))

    def nodal_stress(
        self,
        displacement: Floats,
        material: Material,
        parity: Parity = Parity.SYMMETRIC,
        traction: Mapping[Surface, Floats] | None = None,
        pressure: Floats | None = None,
    ) -> Floats:
        """Recover the stress (n_points, 6, n_cases), MPa, at the nodes, in the order of `COMPONENTS`.

        The parity of the displacement (n_points, 3, n_cases), mm, is about y = 0, if the mesh is cut there;
        about z = 0 it is symmetric. The traction is given per loaded surface, (n_points, 3, n_cases), MPa;
        the other `surfaces` are free of it. A pressure is as for `ElementStress`. Surfaces of known traction
        do not need it: the law of `SurfaceStress` depends on ν / (1 − ν) and not on λ.
        """
        n_points, _, n_cases = displacement.shape
        stress = np.empty((n_points, 6, n_cases))
        gradient = (self._gradient @ displacement.reshape(n_points, -1)).reshape(3, -1, 3, n_cases)
        law = material if pressure is None else material.without_lambda()
        stress[self._inside] = stress_from_gradient(gradient.transpose(1, 3, 2, 0), law).swapaxes(1, 2)
        if pressure is not None:
            stress[self._inside, :3] += pressure[self._inside, None]
        if self._surface is not None:
            stress[self._surface.nodes] = self._surface(displacement, material, traction or {}, parity)
        for plane, nodes in self._on_plane.items():
            sign = stress_parity(plane) * (parity if plane is Surface.SYMMETRY_Y else 1)
            stress[np.ix_(nodes, np.flatnonzero(sign < 0))] = 0.0
        return stress


@dataclass(frozen=True)
class _Piece:
    nodes: Ints
    surfaces: tuple[Surface, ...]
    recovery: Recovery


class PartRecovery:
    """Recovers the stress of each part from its own elements.

    Interfaces of parts are not surfaces of known traction; else planes and surfaces are as for `Recovery`.
    """

    def __init__(self, mesh: TetMesh, planes: tuple[Surface, ...], surfaces: tuple[Surface, ...]) -> None:
        self._n_points = len(mesh.points)
        self._pieces: list[_Piece] = []
        for number in [0] if mesh.part is None else np.unique(mesh.part).tolist():
            piece, nodes = (mesh, np.arange(self._n_points)) if mesh.part is None else submesh(mesh, number)
            known = tuple(surface for surface in surfaces if surface in piece.facets)
            cuts = tuple(plane for plane in planes if plane in piece.facets)
            self._pieces.append(_Piece(nodes, known, Recovery(piece, cuts, known)))

    @property
    def nodes(self) -> list[Ints]:
        """Nodes (n,) of each part."""
        return [piece.nodes for piece in self._pieces]

    def nodal_stress(
        self,
        displacement: Floats,
        materials: Sequence[Material],
        parity: Parity = Parity.SYMMETRIC,
        traction: Mapping[Surface, Floats] | None = None,
        pressure: Mapping[int, Floats] | None = None,
    ) -> list[Floats]:
        """Recover the stress of each part, (n_points, 6, n_cases), MPa; NaN at nodes outside the part.

        There is one material per part, and pressures are given by the number of each part that has one; the
        rest is as for `Recovery.nodal_stress`.
        """
        stresses = []
        for piece, stress in zip(
            self._pieces, self.part_stress(displacement, materials, parity, traction, pressure), strict=True
        ):
            if len(piece.nodes) < self._n_points:
                every = np.full((self._n_points, *stress.shape[1:]), np.nan)
                every[piece.nodes] = stress
                stresses.append(every)
            else:
                stresses.append(stress)
        return stresses

    def part_stress(
        self,
        displacement: Floats,
        materials: Sequence[Material],
        parity: Parity,
        traction: Mapping[Surface, Floats] | None = None,
        pressure: Mapping[int, Floats] | None = None,
    ) -> Iterator[Floats]:
        """Stress (n, 6, n_cases) at the `nodes` of each part; parameters as for `nodal_stress`."""
        for number, (piece, material) in enumerate(zip(self._pieces, materials, strict=True)):
            nodes = piece.nodes
            known = {
                surface: values[nodes]
                for surface, values in (traction or {}).items()
                if surface in piece.surfaces
            }
            p = pressure[number][nodes] if pressure and number in pressure else None
            yield piece.recovery.nodal_stress(displacement[nodes], material, parity, known, p)
