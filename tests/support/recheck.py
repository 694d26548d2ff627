"""A written run examined again, with nothing of the program but its files: piston, equilibrium, sections.

The internal forces K u are integrated from the displacement of the VTU files, the loads from the figures of
the summary.
"""

import json
import math
import re
from dataclasses import dataclass
from functools import cache, cached_property
from typing import NamedTuple

import meshio
import numpy as np
import pyvista as pv
from scipy import sparse
from scipy.sparse.linalg import spsolve
from skfem import ElementTetP1, ElementTetP2, ElementTriP1, ElementTriP2, MeshTet, MeshTri
from skfem.quadrature import get_quadrature

_ELEMENTS = {4: ElementTetP1, 10: ElementTetP2, 3: ElementTriP1, 6: ElementTriP2}


@cache
def rule(n_nodes, degree):
    """Weights, values (q, n) and slopes (q, n, dim) of the reference element with so many nodes."""
    points, weights = get_quadrature((MeshTet if n_nodes in (4, 10) else MeshTri).elem.refdom, degree)
    return weights, *shapes(n_nodes, points)


def shapes(n_nodes, points):
    """Values (q, n) and slopes (q, n, dim) of the shape functions at points (dim, q)."""
    element = _ELEMENTS[n_nodes]()
    tables = [element.lbasis(points, i) for i in range(n_nodes)]
    values = np.stack([np.broadcast_to(v, points.shape[1]) for v, _ in tables], axis=1)
    slopes = np.stack([_spread(np.asarray(g, dtype=float), points.shape) for _, g in tables], axis=1)
    return values, slopes


def _spread(slope, shape):
    return np.broadcast_to(slope.reshape(shape[0], -1), shape).T


# Above this Poisson's ratio second-order elements have a continuous linear pressure of their own.
LIMIT = 0.4
_CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])


def pressures(tets, dilation, volumes, values, constants):
    """Pressure (n_elements, n_points), positive in tension.

    Parameters
    ----------
    tets
        (n_elements, 4 or 10).
    dilation, volumes
        (n_elements, n_points) ∇·u, and weight times determinant.
    values
        (n_points, 4 or 10) shape functions.
    constants
        (λ, ν, number of the material), each (n_elements,).
    """
    lame, nu, material = constants
    found = lame[:, None] * dilation
    if tets.shape[1] == 4:
        return found
    places = values @ np.vstack([_CORNERS, _CORNERS[_EDGES].mean(axis=1)])
    linear = np.stack([np.broadcast_to(ElementTetP1().lbasis(places.T, i)[0], len(places)) for i in range(4)])
    for number in np.unique(material[nu > LIMIT]):
        own = material == number
        nodes, local = np.unique(tets[own, :4], return_inverse=True)
        local = local.reshape(-1, 4)
        right = np.bincount(local.ravel(), ((volumes * found)[own] @ linear.T).ravel())
        squares = np.einsum("eq,iq,jq->eij", volumes[own], linear, linear)
        rows, columns = np.repeat(local, 4, axis=1).ravel(), np.tile(local, (1, 4)).ravel()
        mass = sparse.csc_array(sparse.coo_array((squares.ravel(), (rows, columns)), shape=(nodes.size,) * 2))
        found[own] = spsolve(mass, right)[local] @ linear
    return found


# The law of the pressure on a bore is the program's documented one: p = p(ψ) (a + b sin ψ) with the exact
# resultant, and an arc that ends within a facet on the straight line, in reference coordinates, where the
# angle interpolated between the corners is the arc's end. The integration over the facets it crosses is
# another: along lines of equal angle.
FACES = np.array([[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 2, 3, 6, 9, 7]])
DEGREE, LINES = 12, 12
_TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def bore_faces(points, tets, center, radius):
    """Faces (n, 3 or 6) of the skin that lie on a bore."""
    local = FACES if tets.shape[1] == 10 else FACES[:, :3]
    faces = tets[:, local].reshape(-1, local.shape[1])
    _, first, counts = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    faces = faces[first[counts == 1]]
    away = np.hypot(points[:, 0] - center, points[:, 1])
    return faces[(np.abs(away - radius) < 1e-6 * radius)[faces[:, :3]].all(axis=1)]


def arc(pressure, axial):
    """Relative pressure over the angle from the force, and half its arc; an end is pulled if axial > 0."""
    if pressure == "webster":
        pressure = "cosine-180" if axial > 0 else "uniform-120"
    shape, degrees = re.fullmatch(r"(cosine|uniform)-([\d.]+)", pressure).groups()
    half = math.radians(float(degrees)) / 2
    return (np.ones_like if shape == "uniform" else lambda psi: np.cos(np.pi / (2 * half) * psi)), half


def bore_forces(points, faces, center, force, pressed):
    """Pressure on a bore with the resultant `force` (x, y), as nodal forces (n, 3)."""
    out = np.zeros_like(points)
    magnitude, direction = math.hypot(*force), math.atan2(force[1], force[0])
    if not magnitude:
        return out
    shape, half = pressed
    corners = points[faces] - [center, 0, 0]
    samples = []  # number of the facet, area, values, angle
    psi = _turned(np.arctan2(corners[:, :3, 1], corners[:, :3, 0]), direction)
    for facet in np.flatnonzero((psi.max(axis=1) > -half) & (psi.min(axis=1) < half)):
        if np.abs(psi[facet]).max() <= half:
            weights, values, slopes = rule(faces.shape[1], DEGREE)
        else:
            places, weights = lines(psi[facet], half)
            values, slopes = shapes(faces.shape[1], places.T)
        tangents = np.einsum("ni,qnk->qik", corners[facet], slopes)
        area = np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=-1) * weights
        x, y, _ = (values @ corners[facet]).T
        samples.append((faces[facet], area, values, np.arctan2(y, x)))
    area, angle = (np.concatenate([sample[part] for sample in samples]) for part in (1, 3))
    psi = np.mod(angle - direction + math.pi, 2 * math.pi) - math.pi
    basis = [shape(psi), shape(psi) * np.sin(psi)]
    system = [[(area * b * trig(psi)).sum() for b in basis] for trig in (np.cos, np.sin)]
    a, b = np.linalg.solve(system, [magnitude, 0.0])
    pressure, start = area * (a * basis[0] + b * basis[1]), 0
    for nodes, own, values, angle in samples:
        force = pressure[start : start + len(own), None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        out[nodes, :2] += values.T @ force
        start += len(own)
    return out


def lines(psi, half):
    """Places (q, 2) and weights for the part within ±`half` of a triangle, psi (3,) at its corners."""
    order = np.argsort(psi)
    (low, middle, high), (first, second, third) = psi[order], _TRIANGLE[order]
    t, w = (each / 2 for each in np.polynomial.legendre.leggauss(LINES))
    t = t + 0.5
    places, weights = [], []
    for start, end, one, other in ((low, middle, first, second), (middle, high, second, third)):
        at, stop = max(start, -half), min(end, half)
        if at >= stop:
            continue
        v, along = (each.ravel() for each in np.meshgrid(at + t * (stop - at), t, indexing="ij"))
        whole, part = (third - first) / (high - low), (other - one) / (end - start)
        a, b = first + (v - low)[:, None] * whole, one + (v - start)[:, None] * part
        slope = whole + along[:, None] * (part - whole)
        across = b - a
        places.append(a + along[:, None] * across)
        area = np.abs(slope[:, 0] * across[:, 1] - slope[:, 1] * across[:, 0])
        weights.append(area * (stop - at) * np.outer(w, w).ravel())
    return np.concatenate(places), np.concatenate(weights)


def _turned(angle, direction):
    """Angles (n, 3) from a direction, of the corners of a facet without a jump among them."""
    first = np.mod(angle[:, :1] - direction + math.pi, 2 * math.pi) - math.pi
    return first + np.mod(angle - angle[:, :1] + math.pi, 2 * math.pi) - math.pi


VOLUME = 5
AT_REST = ("gas", "given")


@dataclass(frozen=True)
class Told:
    """Parameters of a run: mm, t, N, MPa, rad/s; materials as (E, nu, density), the bushing's last."""

    materials: tuple[tuple[float, float, float], ...]
    big_radius: float
    small_radius: float
    length: float
    bushing: float = 0.0
    pressure: str = "cosine-180"
    clamped: bool = False
    crank_radius: float = 0.0
    speed: float = 0.0
    offset: float = 0.0
    friction: float = 0.0
    piston_mass: float = 0.0


class Errors(NamedTuple):
    """The largest over the cases of a run, each relative to the largest force."""

    equilibrium: float = 0.0
    section: float = 0.0
    piston: float = 0.0

    def worst(self, other):
        """The larger of each."""
        return Errors(*map(max, self, other))


@dataclass(frozen=True)
class Body:
    """The mesh of a run: places, elements with their materials, and what lies on its bores."""

    points: np.ndarray
    tets: np.ndarray
    material: np.ndarray
    small: np.ndarray
    big: np.ndarray

    @classmethod
    def of(cls, written, told):
        """The body of a VTU file."""
        points, tets = written.points.astype(float), written.cells[0].data.astype(int)
        small, big = (
            bore_faces(points, tets, center, radius)
            for center, radius in ((told.length, told.small_radius), (0.0, told.big_radius))
        )
        part = written.cell_data.get("part")
        return cls(points, tets, _materials(points, tets, told, part), small, big)

    @cached_property
    def internal(self):
        """At the stiffness's points: shape functions, gradients (n, n_local, 3), volumes (n, q)."""
        weights, values, slopes = rule(self.tets.shape[1], 2 if self.tets.shape[1] == 10 else 0)
        J = [self.points[self.tets].transpose(0, 2, 1) @ slope for slope in slopes]
        volumes = weights * np.stack([np.linalg.det(j) for j in J], axis=1)
        return values, [slope @ np.linalg.inv(j) for slope, j in zip(slopes, J, strict=True)], volumes

    @cached_property
    def inertial(self):
        """At the points of the rule of volumes: shape functions, volumes (n,), x and y (n,)."""
        corners = self.points[self.tets]
        found = []
        for weight, value, slope in zip(*rule(self.tets.shape[1], VOLUME), strict=True):
            x, y, _ = (value @ corners).T
            found.append((value, weight * np.linalg.det(corners.transpose(0, 2, 1) @ slope), x, y))
        return found

    def scattered(self, forces):
        """Sum forces (n_elements, n_local, 3) at their nodes."""
        sums = [
            np.bincount(self.tets.ravel(), forces[..., axis].ravel(), minlength=len(self.points))
            for axis in range(3)
        ]
        return np.stack(sums, axis=1)


def internal_forces(body, u, told):
    """K u at the nodes (n, 3): the work of the stress of u with each shape function's gradient."""
    values, g, volumes = body.internal
    E, nu = np.array([(E, nu) for E, nu, _ in told.materials])[body.material].T
    mu, lame = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    H = [u[body.tets].transpose(0, 2, 1) @ one for one in g]
    dilation = np.stack([np.trace(h, axis1=1, axis2=2) for h in H], axis=1)
    pressure = pressures(body.tets, dilation, volumes, values, (lame, nu, body.material))
    out = np.zeros((*body.tets.shape, 3))
    for one, h, p, volume in zip(g, H, pressure.T, volumes.T, strict=True):
        stress = mu[:, None, None] * (h + h.transpose(0, 2, 1)) + p[:, None, None] * np.eye(3)
        out += volume[:, None, None] * (one @ stress)
    return body.scattered(out)


def rod_angle(told, theta):
    """β of the rod, its first and second rate."""
    ratio, w = told.crank_radius / told.length, told.speed
    sin_b = ratio * math.sin(theta) - told.offset / told.length
    cos_b = math.sqrt(1 - sin_b**2)
    rate = ratio * w * math.cos(theta) / cos_b
    return math.asin(sin_b), rate, (-ratio * w * w * math.sin(theta) + rate**2 * sin_b) / cos_b


def inertia_forces(body, told, crank_deg, cut):
    """D'Alembert forces at the nodes (n, 3), and their resultant beyond x = `cut`."""
    theta, w = math.radians(crank_deg), told.speed
    beta, rate, growth = rod_angle(told, theta)
    inward = -told.crank_radius * w * w * np.array([math.cos(theta), math.sin(theta)])
    a_x, a_y = inward @ [math.cos(beta), -math.sin(beta)], inward @ [math.sin(beta), math.cos(beta)]
    density = np.array([rho for _, _, rho in told.materials])[body.material]
    beyond, out = np.zeros(3), np.zeros((*body.tets.shape, 3))
    for value, volume, x, y in body.inertial:
        mass = density * volume
        force = -mass * np.stack([a_x + growth * y - rate**2 * x, a_y - growth * x - rate**2 * y, 0 * x])
        beyond += force[:, x > cut].sum(axis=1)
        out += force.T[:, None, :] * value[:, None]
    return body.scattered(out), beyond


def piston_error(load, told):
    """Residual of m ẍ = −gas + friction − pin on the piston, over the largest of them."""
    theta, w, r, l = math.radians(load["crank_deg"]), told.speed, told.crank_radius, told.length
    beta, rate, growth = rod_angle(told, theta)
    velocity = -r * w * math.sin(theta) - l * rate * math.sin(beta)
    a = -r * w * w * math.cos(theta) - l * (rate**2 * math.cos(beta) + growth * math.sin(beta))
    along, across = load["pin_axial_N"], load["pin_transverse_N"]
    pin_x = along * math.cos(beta) + across * math.sin(beta)
    pin_y = across * math.cos(beta) - along * math.sin(beta)
    friction = -told.friction * abs(pin_y) * np.sign(velocity)
    parts = [told.piston_mass * a, load["gas_N"], -friction, pin_x]
    return float(abs(sum(parts)) / max(map(abs, parts)))


def recheck(folder, told):
    """Largest errors over the cases of a run: of piston, equilibrium, and the section amid the shank.

    Returns
    -------
    Errors
    """
    figures = json.loads((folder / "summary.json").read_text())
    found, body = Errors(), None
    for name, load in figures["loads"].items():
        written = meshio.read(folder / f"{name}.vtu")
        if body is None:  # the first file has exact coordinates
            body = Body.of(written, told)
        pin = load["pin_axial_N"], load["pin_transverse_N"]
        crank = -load["crank_axial_N"], load["crank_transverse_N"]
        largest = max(math.hypot(*pin), math.hypot(*crank))
        cut = 0.5 * told.length + 1e-3
        f = bore_forces(body.points, body.small, told.length, pin, arc(told.pressure, load["pin_axial_N"]))
        beyond = np.zeros(3)
        if name not in AT_REST:
            inertia, beyond = inertia_forces(body, told, load["crank_deg"], cut)
            f += inertia
        if not told.clamped:
            f += bore_forces(body.points, body.big, 0.0, crank, arc(told.pressure, load["crank_axial_N"]))
        left = internal_forces(body, written.point_data["displacement"].astype(float), told) - f
        reaction = 0.0
        if told.clamped:
            held = np.unique(body.big)
            reaction = float(np.abs(left[held].sum(axis=0)[:2] - crank).max() / largest)
            left[held] = 0.0
        plane = pv.read(folder / f"{name}.vtu").slice(normal="x", origin=(cut, 0, 0))
        stress = plane.integrate_data()["stress"][0]
        carried = np.array([stress[0], stress[3]])
        found = found.worst(
            Errors(
                max(float(np.abs(left).max() / np.abs(f).max()), reaction),
                float(np.abs(carried - (pin + beyond[:2])).max() / largest),
                0.0 if name in AT_REST else piston_error(load, told),
            )
        )
    return found


def _materials(points, tets, told, part):
    """Which material (n_tets,) an element has: the bushing's where it lies within its outer radius.

    An element with all corners on that radius may be of either part: the file says of which.
    """
    if not told.bushing:
        return np.zeros(len(tets), dtype=int)
    outer = told.small_radius + told.bushing
    away = np.hypot(points[:, 0] - told.length, points[:, 1])[tets[:, :4]] - outer
    between = (np.abs(away) < 1e-6 * outer).all(axis=1)
    return np.where(between, part[0], (away <= 1e-6 * outer).all(axis=1))
