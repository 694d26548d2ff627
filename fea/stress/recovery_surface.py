"""Stress on the boundary from the quantities known best there: the strain along the surface and the traction.

The mean over elements uses the strain normal to the surface from one side only. But at a boundary
three stress components are given by the traction, and the other three follow from the strain within
the surface, to which elements on both sides contribute: the displacement of the surface nodes around
a vertex is fitted by a polynomial in two surface coordinates and differentiated. Boundary-element
codes recover boundary stress in the same way (Brebbia, Telles & Wrobel 1984, section 5.7); the fit is
that of polynomial-preserving recovery (Zhang & Naga 2005), on the surface instead of in the volume.
"""

from collections.abc import Mapping

import numpy as np
from scipy import sparse

from fea.base.material import Material
from fea.solid.element import COMPONENTS
from fea.solid.parity import Parity
from fea.stress.boundary import BoundarySurface
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import FACET_EDGES, TetMesh

# At an edge the tractions of both sides have this weight relative to the strain, which is fitted from one
# side there. A much larger weight would force the stress across a blunt edge to zero, which is right only
# at the very edge.
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
    one, zero = np.ones_like(p), np.zeros_like(p)
    along = [[zero, one, zero], [zero, zero, one]]
    if order == 2:
        along = [[*along[0], 2 * p, q, zero], [*along[1], zero, p, 2 * q]]
    return np.stack([np.stack(row, axis=1) for row in along], axis=1)


def _groups(sorted_keys: Ints) -> Ints:
    """Start of each run of equal keys."""
    return np.flatnonzero(np.r_[True, sorted_keys[1:] != sorted_keys[:-1]])


def _dyads(a: Floats, b: Floats) -> Floats:
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
        unknown = [s for s in mesh.facets if s not in surfaces and s not in planes]
        self.boundary = BoundarySurface.of(mesh, [*surfaces, *unknown], planes)
        normals, fan = self.boundary.normals, self.boundary.fans

        # Fans around vertices of the mesh itself.
        corner_facet, corner = np.nonzero(self.boundary.facets[:, :3] < len(mesh.points))
        known = self.boundary.label[corner_facet] < len(surfaces)
        corner_facet, corner = corner_facet[known], corner[known]
        _, number = np.unique(fan[corner_facet, corner], return_inverse=True)
        n_fans = int(number.max(initial=-1)) + 1
        vertex = np.empty(n_fans, dtype=np.int64)
        vertex[number] = self.boundary.facets[corner_facet, corner]
        label = np.empty(n_fans, dtype=np.int64)
        label[number] = self.boundary.label[corner_facet]
        normal = np.zeros((n_fans, 3))
        np.add.at(normal, number, normals[corner_facet, corner])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)

        least = np.eye(3)[np.abs(normal).argmin(axis=1)]
        first = np.cross(least, normal)
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        self._origin, self._tangent = self.boundary.points[vertex], (first, np.cross(normal, first))
        self._fit(mesh.order, number, self.boundary.facets[corner_facet])
        turn = (normals[corner_facet] * normal[number, None]).sum(axis=2).min(axis=1)
        self._usable[number[turn < LEAST_COSINE]] = False
        served = [self.boundary.facets[corner_facet, corner]]
        if mesh.order == 2:
            served += [self.boundary.facets[corner_facet, 3 + (corner + back) % 3] for back in (0, 2)]
        self._serve(mesh.order, number, np.stack(served, axis=1), self._open_nodes(mesh))
        self._label = label[self._fan]
        self._frame()
        self._known: dict[tuple[float, float], tuple[Floats, Floats]] = {}

    def _open_nodes(self, mesh: TetMesh) -> Mask:
        """Nodes of the mesh that lie on known surfaces only and not on an inner edge."""
        facets, label = self.boundary.facets, self.boundary.label
        allowed = np.zeros(len(self.boundary.points), dtype=bool)
        allowed[facets] = True
        allowed[facets[label >= len(self.surfaces)]] = False
        edges = self.boundary.edges
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
        start = _groups(fan)
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
        mine = node < n_points
        blocked = np.zeros(n_points, dtype=bool)
        blocked[node[mine & ~self._usable[fan]]] = True
        keep = mine.copy()
        keep[mine] = (allowed & ~blocked)[node[mine]]
        by_node = np.argsort(node[keep], kind="stable")
        self._fan, node = fan[keep][by_node], node[keep][by_node]
        self._node = node
        self._start = _groups(node) if node.size else np.zeros(0, dtype=np.int64)
        self.nodes = node[self._start]
        place = self._flattened(self._fan, node) / self._scale[self._fan, None]
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
            mine = np.flatnonzero(self._label == self.surfaces.index(surface))
            parts[mine] += from_traction[mine] @ values[self._node[mine]]
        return np.asarray(np.add.reduceat(parts, self._start))

    def _operators(self, E: float, nu: float) -> tuple[Floats, Floats]:
        """Share of each fan in the stress of a node, from slopes (n, 6, 6) and traction (n, 6, 3).

        It is the least-squares solution of σ n = t and the plane stress-strain relations of all fans at a
        node.
        """
        if (E, nu) not in self._known:
            first, second, normal = self._axes[:, 0], self._axes[:, 1], self.normal
            unit, across = np.eye(3), nu / (1 - nu) * _dyads(normal, normal)
            rows = np.stack(  # weighted traction, then normal and shear stress along the surface
                [TRACTION_WEIGHT * _dyads(np.broadcast_to(unit[i], normal.shape), normal) for i in range(3)]
                + [_dyads(first, first) - across, _dyads(second, second) - across, _dyads(first, second)],
                axis=1,
            )
            transposed = rows.transpose(0, 2, 1)
            inverse = np.linalg.inv(np.add.reduceat(transposed @ rows, self._start))
            fans = np.diff(np.append(self._start, len(rows)))
            share = np.repeat(inverse, fans, axis=0) @ transposed
            # along[:, a, b]: component a of the derivative along axis b.
            along = np.einsum("nai,nbk->nabki", self._axes, self._combine).reshape(-1, 2, 2, 6)
            e11, e22, g12 = along[:, 0, 0], along[:, 1, 1], along[:, 0, 1] + along[:, 1, 0]
            membrane = E / (1 - nu**2)
            stress = np.stack(
                [membrane * (e11 + nu * e22), membrane * (e22 + nu * e11), E / (2 * (1 + nu)) * g12], axis=1
            )
            self._known[E, nu] = share[:, :, 3:] @ stress, TRACTION_WEIGHT * share[:, :, :3]
        return self._known[E, nu]
