"""Extreme shapes and meshes: slender beams, thin rings, graded meshes, slivers, coarse bending."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fea.base.checks import check
from fea.base.choices import CONVERGED_PERCENT
from fea.solid.traction import nodal_traction, traction_forces
from fea.verify.body import STEEL, LoadedBody, eighth_ball, held, pressure, quarter_ring, rectangle, uniform
from fea.verify.michell import pressed, stresses
from fea.verify.stability.outcome import CheckedSolution, ExtremeRow, percent, solved, unconverged
from geometry.arrays import Floats
from geometry.bodies import Prism
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.quality import measure, shape
from mesh.tetmesh import EDGES, TetMesh


def slender() -> Iterator[ExtremeRow]:
    """A cantilever in bending: w = F L³/(3 E I) plus the shear deflection of Timoshenko.

    Second-order elements are twice as long as the beam is thick.
    """
    side, soft = 2.0, replace(STEEL, poissons_ratio=0.0)
    section = rectangle((0.0, side), (0.0, side), (Surface.FREE,) * 4)
    for slenderness in (10, 30, 100, 300, 1000):
        length = side * slenderness
        mesh = mesh_body(Prism(section, (0.0, length), Surface.CLAMPED, Surface.LOADED), 2 * side)
        forces = traction_forces(mesh, Surface.LOADED, uniform(1 / side**2, 0.0, 0.0))
        result = solved(LoadedBody(mesh, soft, forces, held(mesh, {Surface.CLAMPED: (0, 1, 2)})))
        E, area, inertia = soft.youngs_modulus, side**2, side**4 / 12
        exact = length**3 / (3 * E * inertia) + length / (5 / 6 * area * soft.shear_modulus)
        end = np.unique(mesh.facets[Surface.LOADED])
        error = percent(float(result.displacement[end, 0].mean()), exact)
        # The limit is the error of beam theory: the shear factor for ν = 0, the effect of the clamped end.
        yield result.row(("slenderness, p2", "L/h", slenderness), error, 1.0)


RING_BORE, RING_PRESSURE = 20.0, 1.0  # mm, MPa


def ring() -> Iterator[ExtremeRow]:
    """A ring with a wall down to 1 mm, bent by a pressure q cos 2θ in its bore: its peak and error bar.

    The element size does not change, so that the thinnest walls are one element thick or less.
    """

    def traction(places: Floats, _normals: Floats | None = None) -> Floats:
        """The pressure outwards: q cos 2θ times the unit radius."""
        x, y, _ = places.T
        share = RING_PRESSURE * (x**2 - y**2) / np.hypot(x, y) ** 3
        return np.stack([share * x, share * y, 0 * x], axis=1)

    for order in (1, 2):
        for wall in (20.0, 10.0, 5.0, 2.0, 1.0):
            section = Prism(quarter_ring(RING_BORE, RING_BORE + wall), (0.0, 6.0), top=Surface.ROLLER)
            mesh = mesh_body(section, 3.0, order=order)
            forces = traction_forces(mesh, Surface.INNER, traction)
            pressed = {Surface.INNER: nodal_traction(mesh, Surface.INNER, traction)}
            known, fixed = (Surface.INNER, Surface.OUTER), held(mesh, {Surface.ROLLER: (2,)})
            result = solved(LoadedBody(mesh, STEEL, forces, fixed, known, pressed))
            yield result.peak_row((f"wall of a ring, p{order}", "mm", wall), ring_peak(wall))


def ring_peak(wall: float) -> float:
    """Largest von Mises stress in plane strain, which has the same stress in the plane, MPa."""
    a, b = RING_BORE, RING_BORE + wall
    factors = RING_PRESSURE * pressed(a, b, 2)
    r, angle = np.meshgrid(np.linspace(a, b, 401), np.linspace(0, math.pi / 2, 181))
    s_r, s_t, s_rt = (waves @ factors for waves in stresses(r, 2))
    s_r, s_t, s_rt = np.cos(2 * angle) * s_r, np.cos(2 * angle) * s_t, np.sin(2 * angle) * s_rt
    s_z = STEEL.poissons_ratio * (s_r + s_t)
    square = ((s_r - s_t) ** 2 + (s_t - s_z) ** 2 + (s_z - s_r) ** 2) / 2 + 3 * s_rt**2
    return float(np.sqrt(square.max()))


BALL, BALL_SIZE = 40.0, 10.0  # outer radius and largest element, mm


def grading() -> Iterator[ExtremeRow]:
    """Elements that grow a thousandfold away from a tiny cavity: Lamé's hollow sphere."""
    load = 100.0
    for ratio in (1.0, 10.0, 100.0, 1000.0):
        mesh, inside = graded_sphere(ratio), _cavity(ratio)
        forces = traction_forces(mesh, Surface.INNER, pressure(load))
        pressed = {Surface.INNER: nodal_traction(mesh, Surface.INNER, lambda p, r=inside: load * p / r)}  # type: ignore[misc]
        known = (Surface.INNER, Surface.OUTER)
        result = solved(LoadedBody(mesh, STEEL, forces, held(mesh, {}), known, pressed))
        # Radial −p, tangential p (2 a³ + b³) / (2 (b³ − a³)): Timoshenko & Goodier 1970, §136.
        exact = 1.5 * load * BALL**3 / (BALL**3 - inside**3)
        yield result.peak_row(("mesh grading, p2", "ratio", ratio), exact)


def graded_sphere(ratio: float) -> TetMesh:
    """Mesh an octant; the radius of the cavity is proportional to the smallest size."""
    inside = _cavity(ratio)
    fine = {Surface.INNER: Fine(BALL_SIZE / ratio, inside)} if ratio > 1 else {}
    return mesh_body(eighth_ball(inside, BALL), BALL_SIZE, fine=fine)


def _cavity(ratio: float) -> float:
    """Radius, mm, for six of the smallest elements along a quarter."""
    return min(6 * BALL_SIZE / ratio / (math.pi / 2), BALL / 2)


_DEPTH, _WIDTH, _LENGTH, _BENDING = 4.0, 6.0, 20.0, 100.0  # mm, MPa


def bending() -> Iterator[ExtremeRow]:
    """A beam on coarser and coarser meshes: the worse error of largest stress and compliance.

    σ_zz = M x / I is the exact solution everywhere. Second-order elements contain it; first-order elements
    are far too stiff.
    """
    # ∫ σ²/E dV over the quarter.
    exact = _BENDING**2 / STEEL.youngs_modulus * _DEPTH / 3 * _WIDTH / 2 * _LENGTH / 2
    for order in (1, 2):
        for layers in (4.0, 2.0, 1.0, 0.5):
            mesh = beam(_DEPTH / layers, order)
            result = _bent(mesh)
            work = float((_end_forces(mesh) * result.displacement).sum())
            peak = result.peak
            error = max(percent(peak.value, _BENDING), percent(work, exact))
            setting = (f"bending, p{order}", "layers", layers)
            yield result.row(setting, error, CONVERGED_PERCENT, unconverged(peak))


def beam(size: float, order: int) -> TetMesh:
    """Mesh a quarter: cut at mid length and along the plane of bending."""
    half, names = _DEPTH / 2, (Surface.SYMMETRY_Y, Surface.FREE, Surface.FREE, Surface.FREE)
    section = rectangle((-half, half), (0.0, _WIDTH / 2), names)
    return mesh_body(Prism(section, (0.0, _LENGTH / 2), top=Surface.LOADED), size, order=order)


def _end_traction(places: Floats, _normals: Floats | None = None) -> Floats:
    return np.asarray(places[:, :1] * [0.0, 0.0, _BENDING / (_DEPTH / 2)])


def _end_forces(mesh: TetMesh) -> Floats:
    return traction_forces(mesh, Surface.LOADED, _end_traction)


def _bent(mesh: TetMesh) -> CheckedSolution:
    """Solve under the traction of the exact solution on the end."""
    fixed = held(mesh, {})
    both = np.flatnonzero(fixed[:, 1] & fixed[:, 2])
    fixed[both[np.abs(mesh.points[both, 0]).argmin()], 0] = True
    traction = {Surface.LOADED: nodal_traction(mesh, Surface.LOADED, _end_traction)}
    return solved(LoadedBody(mesh, STEEL, _end_forces(mesh), fixed, (Surface.LOADED, Surface.FREE), traction))


def slivers() -> Iterator[ExtremeRow]:
    """An inner vertex is moved until an element is almost flat; the parameter is the smallest mean ratio.

    The problem is the beam in pure bending, whose solution second-order elements contain, even slivers: the
    error consists of rounding, amplified by the flat element.
    """
    whole = beam(1.0, order=2)
    for least in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
        mesh = with_sliver(whole, least)
        result = _bent(mesh)
        peak = result.peak
        flat = check("flattest_element", 1 / measure(mesh).least_shape)
        noticed = (*(() if flat.passed else ("flattest_element",)), *unconverged(peak))
        yield result.row(("sliver, p2", "shape", least), percent(peak.value, _BENDING), 1e-2, noticed)


def with_sliver(mesh: TetMesh, least: float) -> TetMesh:
    """Move an inner vertex towards the opposite face of an element, until its mean ratio is `least`.

    The edges of the mesh are straight; no other element may become worse or inverted.
    """
    surface = np.unique(np.concatenate([facets.ravel() for facets in mesh.facets.values()]))
    vertices = mesh.tets[:, :4]
    inner = np.setdiff1d(vertices, surface)
    for tet in vertices[np.isin(vertices, inner).any(axis=1)]:
        vertex = tet[np.isin(tet, inner)][0]
        a, b, c = mesh.points[tet[tet != vertex]]
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        height = (mesh.points[vertex] - a) @ normal * normal
        moved = _flattened(mesh, int(vertex), height, least)
        if abs(shape(moved).min() / least - 1) < 1e-3:
            return moved
    raise AssertionError("a mesh with inner vertices has one that can be moved")


def _flattened(mesh: TetMesh, vertex: int, height: Floats, least: float) -> TetMesh:
    """Move a vertex along a height of its element, by bisection of the remaining height."""
    low, high = 1e-12, 1.0
    for _ in range(60):
        left = float(np.sqrt(low * high))
        if shape(_moved(mesh, vertex, (left - 1) * height)).min() < least:
            low = left
        else:
            high = left
    return _moved(mesh, vertex, (high - 1) * height)


def _moved(mesh: TetMesh, vertex: int, by: Floats) -> TetMesh:
    points = mesh.points.copy()
    points[vertex] += by
    around = mesh.tets[(mesh.tets[:, :4] == vertex).any(axis=1)]
    for middle, (a, b) in enumerate(EDGES, start=4):
        points[around[:, middle]] = points[around[:, [a, b]]].mean(axis=1)
    return replace(mesh, points=points)
