"""Nodal stress from a displacement field.

The mean over elements uses the strain normal to the surface from one side only. But at a boundary three
stress components are given by the traction, and the other three follow from the strain within the surface, to
which elements on both sides contribute: the displacement of the surface nodes around a vertex is fitted by a
polynomial in two surface coordinates and differentiated. Boundary-element codes recover boundary stress in
the same way (Brebbia, Telles & Wrobel 1984, section 5.7); the fit is that of polynomial-preserving recovery
(Zhang & Naga 2005), on the surface instead of in the volume.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from scipy import sparse

from fea.base.material import Material
from fea.solid.assembly import (
    COMPONENTS,
    gauss_places,
    inverse_and_determinant,
    jacobians,
    reference_nodes,
    shape_functions,
    stress_from_gradient,
)
from fea.solid.boundary import BoundarySurface
from fea.solid.parity import Parity
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import PLANE_AXIS, Surface
from mesh.tetmesh import FACET_EDGES, TetMesh, submesh

# Weight of the tractions of both sides of an edge relative to the strain, which is fitted from one side. With
# a much larger one the stress across a blunt edge would be zero, which is right only at the very edge.
TRACTION_WEIGHT = 3.0
# Smallest accepted ratio of the eigenvalues of a fit's normal matrix.
RANK_TOLERANCE = 1e-9
# Smallest accepted cosine between the normal of a fan and those at its nodes: a surface that turns further
# cannot be projected onto one tangent plane.
LEAST_COSINE = 0.2


def _monomials(place: Floats, order: int) -> Floats:
    p, q = place.T
    linear = [np.ones_like(p), p, q]
    return np.stack(linear if order == 1 else [*linear, p * p, p * q, q * q], axis=1)


def _monomial_slopes(place: Floats, order: int) -> Floats:
    """Derivatives (n, 2, n_monomials)."""
    p, q = place.T
    ones, zero = np.ones_like(p), np.zeros_like(p)
    along = [[zero, ones, zero], [zero, zero, ones]]
    if order == 2:
        along = [[*along[0], 2 * p, q, zero], [*along[1], zero, p, 2 * q]]
    return np.stack([np.stack(row, axis=1) for row in along], axis=1)


def dyads(a: Floats, b: Floats) -> Floats:
    """Row (n, 6) whose product with stress components is a · σ b."""
    return np.stack([a[:, i] * b[:, j] + (a[:, j] * b[:, i] if i != j else 0) for i, j in COMPONENTS], axis=1)


class SurfaceStress:
    """Stress at the boundary nodes of a mesh, on `surfaces` of known traction.

    The surface nodes around a vertex, up to the next sharp edge, form a *fan*. Its fit gives the stress at
    the vertex and at the mid-edge nodes next to it. A node with several fans gets their least-squares
    compromise, so that on a sharp outer edge the tractions of both sides and the strain along the edge
    decide. Left out are nodes on inner (re-entrant) edges, where the stress is singular, nodes on surfaces
    other than `surfaces`, and nodes of fits that are rank-deficient or whose surface turns too far.
    """

    def __init__(self, mesh: TetMesh, surfaces: tuple[Surface, ...], planes: tuple[Surface, ...]) -> None:
        self.surfaces = surfaces
        others = [s for s in mesh.facets if s not in surfaces and s not in planes]
        self.boundary = boundary = BoundarySurface.of(mesh, [*surfaces, *others], planes)

        # Fans around vertices of the mesh itself.
        loaded = boundary.label < len(surfaces)
        facet, corner = np.nonzero((boundary.facets[:, :3] < len(mesh.points)) & loaded[:, None])
        _, first, number = np.unique(boundary.fans[facet, corner], return_index=True, return_inverse=True)
        vertex, label = boundary.facets[facet, corner][first], boundary.label[facet][first]
        normal = np.zeros((len(first), 3))
        np.add.at(normal, number, boundary.normals[facet, corner])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)

        tangent = np.cross(np.eye(3)[np.abs(normal).argmin(axis=1)], normal)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        self._origin, self._tangent = boundary.points[vertex], (tangent, np.cross(normal, tangent))
        self._fit(mesh.order, number, boundary.facets[facet])
        turn = (boundary.normals[facet] * normal[number, None]).sum(axis=2).min(axis=1)
        self._usable[number[turn < LEAST_COSINE]] = False
        served = [boundary.facets[facet, corner]]
        if mesh.order == 2:
            served += [boundary.facets[facet, 3 + (corner + back) % 3] for back in (0, 2)]
        self._serve(mesh.order, number, np.stack(served, axis=1), self._open_nodes(mesh))
        self._label = label[self._fan]
        self._frame()
        self._operators_of: dict[tuple[float, float], tuple[Floats, Floats]] = {}  # by E and ν

    def _open_nodes(self, mesh: TetMesh) -> Mask:
        """Nodes of the mesh that lie on known surfaces only and not on an inner edge."""
        facets, edges = self.boundary.facets, self.boundary.edges
        allowed = np.zeros(len(self.boundary.points), dtype=bool)
        allowed[facets] = True
        allowed[facets[self.boundary.label >= len(self.surfaces)]] = False
        facet, place = edges.facet[~edges.convex, 0], edges.place[~edges.convex, 0]
        allowed[facets[facet[:, None], FACET_EDGES[place]]] = False
        if facets.shape[1] == 6:
            allowed[facets[facet, place + 3]] = False
        return allowed[: len(mesh.points)]

    def _fit(self, order: int, number: Ints, facets: Ints) -> None:
        """Compute the linear map from nodal values to the polynomial of each fan."""
        n_ext = len(self.boundary.points)
        pairs = np.unique((number[:, None] * n_ext + facets).ravel())
        fan, node = np.divmod(pairs, n_ext)
        _, start = np.unique(fan, return_index=True)
        flat = self._flattened(fan, node)
        self._scale = np.maximum.reduceat(np.linalg.norm(flat, axis=1), start)
        terms = _monomials(flat / self._scale[fan, None], order)
        outer = terms[:, :, None] * terms[:, None, :]
        gram = np.add.reduceat(outer, start)
        values, vectors = np.linalg.eigh(gram)
        self._usable = values[:, 0] > RANK_TOLERANCE * values[:, -1]
        values[~self._usable] = np.inf
        inverse = (vectors / values[:, None, :]) @ vectors.transpose(0, 2, 1)
        weights = (inverse[fan] @ terms[:, :, None])[:, :, 0]
        n_terms = terms.shape[1]
        rows = fan[:, None] * n_terms + np.arange(n_terms)
        self._polynomial = sparse.csr_array(
            (weights.ravel(), (rows.ravel(), np.repeat(node, n_terms))), shape=(start.size * n_terms, n_ext)
        )

    def _flattened(self, fan: Ints, node: Ints) -> Floats:
        """Coordinates (n, 2) of nodes in the tangent plane at their fan's vertex."""
        away = self.boundary.points[node] - self._origin[fan]
        return np.stack([(away * tangent[fan]).sum(axis=1) for tangent in self._tangent], axis=1)

    def _serve(self, order: int, number: Ints, nodes: Ints, allowed: Mask) -> None:
        """List the nodes of each fan: its vertex and the mid-edge nodes next to it."""
        n_points = len(allowed)
        key = np.unique((nodes + number[:, None] * len(self.boundary.points)).ravel())
        fan, node = np.divmod(key, len(self.boundary.points))
        fan, node = fan[node < n_points], node[node < n_points]
        allowed = allowed.copy()
        allowed[node[~self._usable[fan]]] = False
        fan, node = fan[allowed[node]], node[allowed[node]]
        by_node = np.argsort(node, kind="stable")
        self._fan, self._node = fan[by_node], node[by_node]
        self.nodes, self._start = np.unique(self._node, return_index=True)
        place = self._flattened(self._fan, self._node) / self._scale[self._fan, None]
        self._slopes = _monomial_slopes(place, order)

    def _derivatives(self, values: Floats) -> Floats:
        """Derivatives (n_served, 2, …) of values (n, …) on the boundary along the surface coordinates."""
        n_terms = self._slopes.shape[2]
        terms = (self._polynomial @ values.reshape(len(values), -1)).reshape(len(self._scale), n_terms, -1)
        return np.asarray((self._slopes @ terms[self._fan]).reshape(-1, 2, *values.shape[1:]))

    def _frame(self) -> None:
        """Orthonormal frame at each served place, and the directions in surface coordinates."""
        tangent = self._derivatives(self.boundary.points)
        first = tangent[:, 0] / np.linalg.norm(tangent[:, 0], axis=1, keepdims=True)
        normal = np.cross(tangent[:, 0], tangent[:, 1])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        self.normal, self._axes = normal, np.stack([first, np.cross(normal, first)], axis=1)
        # Axis a is the combination c_ab of the tangents: c = (a · t) (t · t)⁻¹.
        metric = tangent @ tangent.transpose(0, 2, 1)
        self._combine = (self._axes @ tangent.transpose(0, 2, 1)) @ np.linalg.inv(metric)

    def __call__(
        self,
        displacement: Floats,
        material: Material,
        traction: Mapping[Surface, Floats],
        parity: Parity = Parity.SYMMETRIC,
    ) -> Floats:
        """Stress (n_nodes, 6, n_cases), MPa, at `nodes`; parameters as for `Recovery.nodal_stress`."""
        from_slope, from_traction = self._operators(material.youngs_modulus, material.poissons_ratio)
        slope = self._derivatives(self.boundary.displacement(displacement, parity))
        parts = from_slope @ slope.reshape(len(slope), 6, -1)
        for surface, values in traction.items():
            rows = np.flatnonzero(self._label == self.surfaces.index(surface))
            parts[rows] += from_traction[rows] @ values[self._node[rows]]
        return np.asarray(np.add.reduceat(parts, self._start))

    def _operators(self, E: float, nu: float) -> tuple[Floats, Floats]:
        """Share of each fan in the stress of a node, from slopes (n, 6, 6) and traction (n, 6, 3).

        The least-squares solution of σ n = t and the plane stress-strain relations of all fans at a node.
        """
        if (E, nu) not in self._operators_of:
            first, second, normal = self._axes[:, 0], self._axes[:, 1], self.normal
            unit, across = np.eye(3), nu / (1 - nu) * dyads(normal, normal)
            rows = np.stack(  # weighted traction, then normal and shear stress along the surface
                [TRACTION_WEIGHT * dyads(np.broadcast_to(unit[i], normal.shape), normal) for i in range(3)]
                + [dyads(first, first) - across, dyads(second, second) - across, dyads(first, second)],
                axis=1,
            )
            transposed = rows.transpose(0, 2, 1)
            inverse = np.linalg.inv(np.add.reduceat(transposed @ rows, self._start))
            fans = np.diff(np.append(self._start, len(rows)))
            share = np.repeat(inverse, fans, axis=0) @ transposed
            # along[:, a, b]: component a of the derivative along axis b.
            along = np.einsum("nai,nbk->nabki", self._axes, self._combine).reshape(-1, 2, 2, 6)
            e11, e22, g12 = along[:, 0, 0], along[:, 1, 1], along[:, 0, 1] + along[:, 1, 0]
            membrane, shear = E / (1 - nu**2), E / (2 * (1 + nu))
            stress = np.stack([membrane * (e11 + nu * e22), membrane * (e22 + nu * e11), shear * g12], axis=1)
            self._operators_of[E, nu] = share[:, :, 3:] @ stress, TRACTION_WEIGHT * share[:, :, :3]
        return self._operators_of[E, nu]


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

        A pressure (n_points, n_cases), MPa, of `fea.solvers.mixed` takes the place of λ ∇·u.
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
    signs of a mirror image, so that the mean does not change for even components and is zero for odd ones.
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
        entries = weights.ravel(), (nodes.ravel(), places.ravel())
        mean = sparse.csr_array(entries, shape=(n_points, n_elements * n_places))
        self._inside = np.setdiff1d(np.arange(n_points), self._surface.nodes if self._surface else [])
        mean = mean[self._inside]
        slopes = self.gauss_stress.slopes()
        n_elements, n_places, _, n_nodes = slopes.shape
        columns = np.repeat(mesh.tets.astype(mean.indices.dtype), n_places, axis=0).ravel()
        starts = np.arange(0, columns.size + 1, n_nodes, dtype=columns.dtype)
        shape = (n_elements * n_places, len(mesh.points))
        of_axes = (slopes[:, :, axis].ravel() for axis in range(3))
        along = [sparse.csr_array((values, columns, starts), shape=shape) for values in of_axes]
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
            axis, turned = PLANE_AXIS[plane], parity if plane is Surface.SYMMETRY_Y else 1
            sign = np.array([-turned if (i == axis) != (j == axis) else turned for i, j in COMPONENTS])
            stress[np.ix_(nodes, np.flatnonzero(sign < 0))] = 0.0
        return stress


class PartRecovery:
    """Recovers each part's stress from its own elements; interfaces are not surfaces of known traction."""

    def __init__(self, mesh: TetMesh, surfaces: tuple[Surface, ...]) -> None:
        self._n_points = len(mesh.points)
        self.nodes: list[Ints] = []  #: (n,) of each part
        self._pieces: list[tuple[Recovery, tuple[Surface, ...]]] = []  # and its surfaces of known traction
        for number in [0] if mesh.part is None else np.unique(mesh.part).tolist():
            piece, nodes = (mesh, np.arange(self._n_points)) if mesh.part is None else submesh(mesh, number)
            of_piece = tuple(surface for surface in surfaces if surface in piece.facets)
            self.nodes.append(nodes)
            self._pieces.append((Recovery(piece, piece.planes, of_piece), of_piece))

    def nodal_stress(
        self,
        displacement: Floats,
        materials: Sequence[Material],
        parity: Parity = Parity.SYMMETRIC,
        traction: Mapping[Surface, Floats] | None = None,
        pressure: Mapping[int, Floats] | None = None,
    ) -> list[Floats]:
        """Recover the stress of each part, (n_points, 6, n_cases), MPa; NaN at nodes outside the part.

        There is one material per part; pressures are given by number; the rest as for
        `Recovery.nodal_stress`.
        """
        stresses = list(self.part_stress(displacement, materials, parity, traction, pressure))
        for number, (nodes, stress) in enumerate(zip(self.nodes, stresses, strict=True)):
            if len(nodes) < self._n_points:
                stresses[number] = np.full((self._n_points, *stress.shape[1:]), np.nan)
                stresses[number][nodes] = stress
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
        pieces = zip(self._pieces, self.nodes, materials, strict=True)
        for number, ((recovery, surfaces), of_piece, material) in enumerate(pieces):
            nodes = slice(None) if len(of_piece) == self._n_points else of_piece  # without a copy
            tractions = {s: values[nodes] for s, values in (traction or {}).items() if s in surfaces}
            p = pressure[number][nodes] if pressure and number in pressure else None
            yield recovery.nodal_stress(displacement[nodes], material, parity, tractions, p)
