"""The facets of a bore, the nodal forces of a pressure on an arc of it, and the change of its shape."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from fea.solid.assembly import shape_functions, tabulate
from fea.solid.parity import ParityPair
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def parts_within(values: Floats, bound: float) -> tuple[Ints, Floats]:
    """Cut triangles where −`bound` ≤ value ≤ `bound`, by the values (n_triangles, 3) at their corners.

    Polygons are clipped by half-planes (Sutherland and Hodgman, 1974). Returned are the triangle (n_parts,)
    of each part, and its corners (n_parts, 3, 2) in reference coordinates; they vary continuously.
    """
    owner, parts = [], []
    for number, corner_values in enumerate(values):
        polygon = np.column_stack([_CORNERS, corner_values])
        for sign in (1, -1):
            polygon = _clipped(polygon, bound - sign * polygon[:, 2])
        fan = [polygon[[0, k, k + 1], :2] for k in range(1, len(polygon) - 1)]
        owner += [number] * len(fan)
        parts += fan
    return np.array(owner, dtype=np.int64), np.array(parts).reshape(-1, 3, 2)


def _clipped(polygon: Floats, level: Floats) -> Floats:
    """The part of a convex polygon (n, 3) where the level (n,) of its corners is not negative."""
    kept = []
    for here, there, a, b in zip(polygon, np.roll(polygon, -1, 0), level, np.roll(level, -1), strict=True):
        if a >= 0:
            kept.append(here)
        if a * b < 0:
            kept.append(here + a / (a - b) * (there - here))
    return np.array(kept).reshape(-1, 3)


# High enough for the pressure harmonics of a cycle: the highest have a period of only a few coarse facets.
FACET_DEGREE = 10


@dataclass(frozen=True)
class FacetPoints:
    """Quadrature points of facets or of parts of them."""

    nodes: Ints  #: (n_facets, n_facet_nodes)
    #: (n_points, n_facet_nodes), or (n_facets, n_points, n_facet_nodes) if each facet has its own points
    shape_values: Floats
    areas: Floats  #: (n_facets, n_points) weight times area, mm²
    angle: Floats  #: (n_facets, n_points) about the bore's axis from rod +x, rad


@dataclass(frozen=True)
class BoreFacets(FacetPoints):
    """Quadrature points of a bore's facets."""

    corners: Floats  #: (n_facets, n_facet_nodes, 3) places of the nodes from the bore's axis, mm
    node_angle: Floats  #: (n_facets, n_facet_nodes) angle of the nodes, rad
    #: cut_y, cut_z: whether the cell represents its mirror images about y = 0, z = 0
    cut_y: bool
    cut_z: bool

    @property
    def images(self) -> int:
        """Number of images of the cell in the whole rod."""
        return (2 if self.cut_y else 1) * (2 if self.cut_z else 1)

    @property
    def element_size(self) -> float:
        """Root mean square of the edges of its facets, mm."""
        edges = self.corners[:, :3] - self.corners[:, [1, 2, 0]]
        return float(np.sqrt((edges**2).sum(axis=-1).mean()))

    def resultants(self, even: Floats, odd: Floats) -> tuple[Floats, Floats]:
        """Force (2, n) on the whole rod's mesh of even and odd pressures (n, n_facets, n_points), N."""
        radial = np.stack([np.cos(self.angle), np.sin(self.angle)]) * self.areas * self.images
        of_even, of_odd = (np.einsum("dfq,nfq->dn", radial, each, optimize=True) for each in (even, odd))
        if self.cut_y:  # components that the images across y = 0 cancel
            of_even[1], of_odd[0] = 0.0, 0.0
        return of_even, of_odd


def bore_facets(mesh: TetMesh, surface: Surface, center_x: float) -> BoreFacets:
    """Quadrature points of the bore `surface`, whose axis passes through (`center_x`, 0)."""
    nodes = mesh.facets[surface]
    corners = mesh.points[nodes] - np.array([center_x, 0.0, 0.0])
    table = tabulate(nodes.shape[1], FACET_DEGREE)
    areas, angle = _areas_and_angles(corners, table.values, table.gradients)
    return BoreFacets(
        nodes=nodes,
        shape_values=table.values,
        areas=areas * table.weights,
        angle=angle,
        corners=corners,
        node_angle=np.arctan2(corners[..., 1], corners[..., 0]),
        cut_y=Surface.SYMMETRY_Y in mesh.facets,
        cut_z=Surface.SYMMETRY_Z in mesh.facets,
    )


def _areas_and_angles(corners: Floats, values: Floats, gradients: Floats) -> tuple[Floats, Floats]:
    """Area per reference area and angle (n_facets, n_points) for shape functions as in `FacetPoints`."""
    places = values @ corners
    return facet_areas(corners, gradients), np.arctan2(places[..., 1], places[..., 0])


def facet_areas(corners: Floats, gradients: Floats) -> Floats:
    """Area per reference area (n_facets, n_points) of facets with nodes `corners` (n_facets, n_nodes, 3)."""
    tangents = corners.transpose(0, 2, 1)[:, None] @ gradients
    return np.asarray(np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=-1))


def facets_within(bore: BoreFacets, direction: float, half_arc: float) -> Iterator[FacetPoints]:
    """Quadrature points of the surface within `half_arc` (rad) of a direction: whole facets, then parts.

    Within a facet the arc ends where the angle interpolated between the corners equals its end, a straight
    line: rounding switches no points, and the forces vary continuously with the direction.
    """
    corner = bore.node_angle[:, :3]
    psi = wrapped(corner[:, :1] - direction) + wrapped(corner - corner[:, :1])
    inside = (np.abs(psi) <= half_arc).all(axis=1)
    outside = (psi >= half_arc).all(axis=1) | (psi <= -half_arc).all(axis=1)
    yield FacetPoints(bore.nodes[inside], bore.shape_values, bore.areas[inside], bore.angle[inside])
    crossed = np.flatnonzero(~inside & ~outside)
    owner, parts = parts_within(psi[crossed], half_arc)
    facets = crossed[owner]
    nodes, corners = bore.nodes[facets], bore.corners[facets]
    table = tabulate(3, FACET_DEGREE)
    places = table.values @ parts
    shapes = shape_functions(nodes.shape[1], places.reshape(-1, 2).T)
    values, gradients = (each.reshape(*places.shape[:2], *each.shape[1:]) for each in shapes)
    areas, angle = _areas_and_angles(corners, values, gradients)
    share = np.abs(np.linalg.det(parts[:, 1:] - parts[:, :1]))[:, None]  # of the reference triangle
    yield FacetPoints(nodes, values, areas * share * table.weights, angle)


def wrapped(angle: Floats) -> Floats:
    """Return the same directions as angles within −π…π."""
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


def radial_forces(points: FacetPoints, n_nodes: int, pressure: Floats) -> Floats:
    """Nodal forces (n_nodes, 3) of a radial traction at the quadrature points."""
    traction = points.areas * pressure
    forces = np.zeros((n_nodes, 3))
    for axis, component in enumerate((np.cos(points.angle), np.sin(points.angle))):
        nodal = (traction * component)[:, None] @ points.shape_values
        forces[:, axis] = np.bincount(points.nodes.ravel(), nodal.ravel(), minlength=n_nodes)
    return forces


def radial_traction(bore: BoreFacets, n_nodes: int, pressure: Floats) -> Floats:
    """Radial traction (n_nodes, 3) of a pressure at the facets' nodes."""
    traction = np.zeros((n_nodes, 3))
    traction[bore.nodes, 0] = pressure * np.cos(bore.node_angle)
    traction[bore.nodes, 1] = pressure * np.sin(bore.node_angle)
    return traction


def radial_loads(
    bore: BoreFacets, n_nodes: int, there: Floats, nodal: Floats
) -> Iterator[tuple[Floats, Floats]]:
    """Yield forces and traction (n_nodes, 3) of pressures at quadrature points and at the facets' nodes."""
    for pressure, at_nodes in zip(there, nodal, strict=True):
        yield radial_forces(bore, n_nodes, pressure), radial_traction(bore, n_nodes, at_nodes)


# Angles (rad) that agree to this many decimals count as equal, so that an arc may end at a node.
ANGLE_DECIMALS = 9


@dataclass(frozen=True)
class BoreLoad:
    """A bore pressure on the cell."""

    forces: ParityPair  #: nodal forces, N
    traction: ParityPair  #: at the bore's nodes, MPa, zero elsewhere
    scale: float  #: factor on the analytic peak pressure that made the resultant exact


def bore_load(
    bore: BoreFacets,
    n_nodes: int,
    force: tuple[float, float],
    pressure: Callable[[Floats], Floats],
    half_arc: float,
) -> BoreLoad:
    """Press a bore in the direction of a `force` (x, y) on the whole rod, N, with exactly that resultant.

    The traction points along the exact radius, so that it has no moment about the bore's axis; the pressure
    p(ψ), MPa, ψ from the direction of the force, is multiplied by a + b sin ψ with the a ≈ 1 and b ≈ 0 that
    make both components of the discrete resultant exact. It is that of the whole force on the whole width,
    smooth slightly beyond |ψ| = `half_arc`, rad, too, from where on it does not act (`facets_within`).
    """
    magnitude, direction = float(np.hypot(*force)), float(np.arctan2(force[1], force[0]))
    sides = (1, -1) if bore.cut_y else (1,)  # the cell, and its mirror image reflected onto the cell
    if not magnitude:
        nothing = np.zeros((n_nodes, 3))
        split = ParityPair(nothing, nothing if bore.cut_y else None)
        return BoreLoad(split, split, 1.0)
    on_bore, nodes = np.unique(bore.nodes, return_inverse=True)  # sums over the nodes of the bore only
    local = replace(bore, nodes=nodes.reshape(bore.nodes.shape))

    def psi(angle: Floats, side: int) -> Floats:
        return np.asarray(side * wrapped(angle - side * direction))

    basis = []
    for side in sides:
        both = np.zeros((2, on_bore.size, 3))  # nodal forces of p and of p sin ψ
        for points in facets_within(local, side * direction, half_arc):
            off = psi(points.angle, side)
            pressed = pressure(off)
            both[0] += radial_forces(points, on_bore.size, pressed)
            both[1] += radial_forces(points, on_bore.size, pressed * np.sin(off))
        basis.append(both)
    sums: Floats = np.stack([forces.sum(axis=1) for forces in basis])  # (n_sides, 2, 3)
    x, y = sums[..., 0].sum(axis=0), sums[0, :, 1] - sums[1:, :, 1].sum(axis=0)
    cosine, sine = np.cos(direction), np.sin(direction)
    # Resultants along and across the force of p and of p sin ψ (columns), over every image of the cell.
    resultants = (2 if bore.cut_z else 1) * np.stack([cosine * x + sine * y, cosine * y - sine * x])
    factors = np.linalg.solve(resultants, [magnitude, 0.0])

    def nodal(side: int) -> Floats:
        off = psi(bore.node_angle, side)
        within = np.heaviside(np.round(half_arc - np.abs(off), ANGLE_DECIMALS), 0.5)
        return np.asarray(within * pressure(off) * (factors[0] + factors[1] * np.sin(off)))

    forces = [np.zeros((n_nodes, 3)) for _ in sides]
    for force_here, both in zip(forces, basis, strict=True):
        force_here[on_bore] = np.tensordot(factors, both, axes=1)
    tractions = [radial_traction(bore, n_nodes, nodal(side)) for side in sides]
    return BoreLoad(_split(forces), _split(tractions), float(factors[0]))


def _split(fields: list[Floats]) -> ParityPair:
    """Split a field into its parities, from its values on the cell and on its mirror image, if any."""
    if len(fields) == 1:
        return ParityPair(fields[0], None)
    here, image = fields
    return ParityPair((here + image) / 2, (here - image) / 2)


# Even harmonics of the radial displacement; odd ones change no diameter, or cancel on opposite sides.
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
