"""Extreme materials, shapes and meshes: stiffness contrast, incompressibility, thin walls, slivers."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fea.base.checks import check
from fea.base.choices import CONVERGED_PERCENT
from fea.base.material import Materials
from fea.solid.recovery import Recovery
from fea.solid.traction import nodal_traction, traction_forces
from fea.verify.body import (
    STEEL,
    LoadedBody,
    eighth_ball,
    held,
    pressure,
    quarter_ring,
    rectangle,
    straightened,
    uniform,
)
from fea.verify.cases.elasticity import HOOP, lame_body, lame_exact
from fea.verify.cases.nafems import COOK_INCOMPRESSIBLE, NEARLY_INCOMPRESSIBLE, cook_body, cook_mesh, cook_tip
from fea.verify.michell import pressed, stresses
from fea.verify.stability.outcome import (
    CheckedSolution,
    ExtremeRow,
    beyond,
    percent,
    solved,
    solved_by,
    unconverged,
)
from geometry.arrays import Floats
from geometry.bodies import Prism, SideBySide
from geometry.surfaces import Surface
from mesh.generate import LocalSize, mesh_body
from mesh.quality import measure, shape
from mesh.tetmesh import TetMesh

_CONTRASTS = (1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9)
METHODS = ("p1", "p2", "p2/p1")


def contrast() -> Iterator[ExtremeRow]:
    """Two materials in series: a bar in tension, whose parts elongate by F L / (E A) each.

    The far half is so many times as stiff as the near one; ν = 0, so that there is no lateral strain.
    """
    length, half = 20.0, 2.0
    section = rectangle((0.0, half), (0.0, half), (Surface.FREE,) * 4)
    bar = Prism(section, (0.0, length / 2, length), Surface.CLAMPED, Surface.LOADED)
    mesh = mesh_body(bar, half)
    far = (mesh.points[mesh.tets[:, :4], 2].mean(axis=1) > length / 2).astype(np.int64)
    soft = replace(STEEL, poissons_ratio=0.0)
    forces = traction_forces(mesh, Surface.LOADED, pressure(-1.0))
    body = LoadedBody(mesh, soft, forces, held(mesh, {Surface.CLAMPED: (0, 1, 2)}))
    end = np.unique(mesh.facets[Surface.LOADED])
    for ratio in _CONTRASTS:
        stiff = replace(soft, youngs_modulus=ratio * soft.youngs_modulus)
        result = solved(body, Materials((soft, stiff), far))
        exact = length / 2 / soft.youngs_modulus * (1 + 1 / ratio)
        error = max(percent(value, exact) for value in result.displacement[end, 2])
        # The field is linear in each part: only rounding errors remain, which grow with the contrast.
        yield result.row(("material contrast", "E₂/E₁", ratio), error, 1e-4)


BORE, INTERFACE, EYE, LINER_PRESSURE = 10.0, 12.0, 20.0, 100.0  # mm, MPa


def liner() -> Iterator[ExtremeRow]:
    """A liner in an eye: the worse error of the radial displacements of bore and interface."""
    quarters = (quarter_ring(*radii) for radii in ((BORE, INTERFACE), (INTERFACE, EYE)))
    both = SideBySide(tuple(Prism(each, (0.0, 2.0), top=Surface.ROLLER) for each in quarters))
    mesh = mesh_body(both, 1.3)
    radius = np.hypot(mesh.points[:, 0], mesh.points[:, 1])
    part = (radius[mesh.tets[:, :4]].mean(axis=1) < INTERFACE).astype(np.int64)
    forces = traction_forces(mesh, Surface.INNER, pressure(LINER_PRESSURE))
    body = LoadedBody(mesh, STEEL, forces, held(mesh, {Surface.ROLLER: (2,)}))
    for ratio in _CONTRASTS:
        other = replace(STEEL, youngs_modulus=ratio * STEEL.youngs_modulus)
        result = solved(body, Materials((STEEL, other), part))
        outward = (result.displacement[:, :2] * mesh.points[:, :2]).sum(axis=1) / radius
        error = max(
            percent(value, exact)
            for place, exact in zip((BORE, INTERFACE), liner_displacement(ratio), strict=True)
            for value in outward[np.abs(radius - place) < 1e-6]
        )
        yield result.row(("liner in an eye, p2", "E₂/E₁", ratio), error, 0.1)


def liner_displacement(ratio: float) -> tuple[float, float]:
    """Radial displacement at bore and interface, u = A r + B/r in each ring (Lamé, plane strain), mm.

    The interface pressure is computed first, from the radial displacements that it and the pressure in the
    bore cause in each ring; this avoids differences of large numbers at any contrast.
    """
    E, nu = STEEL.youngs_modulus, STEEL.poissons_ratio

    def widened(modulus: float, ring: tuple[float, float], pressures: tuple[float, float], r: float) -> float:
        (a, b), (inside, outside) = ring, pressures
        mean = (inside * a**2 - outside * b**2) / (b**2 - a**2)
        swing = (inside - outside) * a**2 * b**2 / (b**2 - a**2)
        return (1 + nu) / modulus * ((1 - 2 * nu) * mean * r + swing / r)

    inner, eye, soft = (BORE, INTERFACE), (INTERFACE, EYE), ratio * E
    free = widened(soft, inner, (LINER_PRESSURE, 0.0), INTERFACE)
    yielding = widened(E, eye, (1.0, 0.0), INTERFACE) - widened(soft, inner, (0.0, 1.0), INTERFACE)
    between = free / yielding
    return (widened(soft, inner, (LINER_PRESSURE, between), BORE), widened(E, eye, (between, 0.0), INTERFACE))


_RATIOS = (0.3, 0.4, 0.45, 0.49, 0.499, 0.4999, 0.49999, 0.499999)
# Element size, and the limits of the displacement at any node, relative to that of the bore, and of any
# stress component at any node, relative to the hoop stress of the bore, on these coarse meshes.
_LAME = {"p1": (1.5, (3.0, 20.0)), "p2": (2.0, (0.1, 2.0)), "p2/p1": (2.0, (0.1, 2.0))}


def incompressible() -> Iterator[ExtremeRow]:
    """Lamé's cylinder: displacement elements lock or have a meaningless mean stress.

    Compared are displacement elements of both orders, and Taylor–Hood elements with a separate pressure,
    which `fea run` uses above the limit of second-order displacement elements: first all displacements of a
    method, then all stresses.
    """
    for method in METHODS:
        size, tolerances = _LAME[method]
        body = lame_body(size, order=1 if method == "p1" else 2)
        rows: tuple[list[ExtremeRow], list[ExtremeRow]] = ([], [])
        for ratio in _RATIOS:
            material = replace(STEEL, poissons_ratio=ratio)
            result = solved_by(method, body, material)
            u, p = result.displacement, result.pressure
            recovery = Recovery(body.mesh, body.mesh.planes, body.known)
            stress = recovery.nodal_stress(u[:, :, None], material, traction=body.traction, pressure=p)
            exact_u, exact_stress = lame_exact(body.mesh.points, material)
            errors = (
                100 * float(np.abs(u - exact_u).max() / np.abs(exact_u).max()),
                100 * float(np.abs(stress[:, :, 0] - exact_stress).max() / HOOP),
            )
            for kind, what in enumerate(("displacement", "stress")):
                setting = (f"near-incompressible {what}, {method}", "ν", ratio)
                rows[kind].append(result.row(setting, errors[kind], tolerances[kind], beyond(method, ratio)))
        yield from rows[0] + rows[1]


MEMBRANE_SIZES = (12.0, 6.0, 3.0)  # of elements, mm


def membrane() -> Iterator[ExtremeRow]:
    """Cook's membrane with ν = 0.4999 on finer and finer meshes; its corners are singular."""
    target, tolerance = COOK_INCOMPRESSIBLE
    for method in METHODS:
        for size in MEMBRANE_SIZES:
            body = cook_body(cook_mesh(size, order=1 if method == "p1" else 2))
            result = solved_by(method, body, NEARLY_INCOMPRESSIBLE)
            error = percent(cook_tip(body.mesh, result.displacement), target)
            noticed = beyond(method, NEARLY_INCOMPRESSIBLE.poissons_ratio)
            setting = (f"Cook's membrane, ν = 0.4999, {method}", "mm", size)
            yield result.row(setting, error, tolerance, noticed)


def scaling() -> Iterator[ExtremeRow]:
    """The same block in other units and with other moduli: the dimensionless result must not change."""
    ends = (Surface.CLAMPED, Surface.LOADED, Surface.FREE, Surface.FREE)
    block = Prism(rectangle((0.0, 10.0), (0.0, 4.0), ends), (0.0, 3.0), top=Surface.FREE)
    mesh = mesh_body(block, 2.0)
    reference = _stretched(mesh, STEEL.youngs_modulus).displacement

    def off(shape: Floats) -> float:
        return 100 * float(np.abs(shape - reference).max() / np.abs(reference).max())

    for scale in (1e-3, 1e-1, 1e1, 1e3):
        result = _stretched(replace(mesh, points=scale * mesh.points), STEEL.youngs_modulus)
        yield result.row(("size of the body", "scale", scale), off(result.displacement / scale), 1e-8)
    for modulus in (1.0, 1e3, 1.2e6):  # MPa: rubber, a polymer, diamond
        result = _stretched(mesh, modulus)
        yield result.row(("stiffness of the body", "MPa", modulus), off(result.displacement), 1e-8)


def _stretched(mesh: TetMesh, modulus: float) -> CheckedSolution:
    """Solve under the same load per E A."""
    forces = traction_forces(mesh, Surface.LOADED, uniform(*np.array([1e-3, 2e-3, -1e-3]) * modulus))
    material = replace(STEEL, youngs_modulus=modulus)
    return solved(LoadedBody(mesh, material, forces, held(mesh, {Surface.CLAMPED: (0, 1, 2)})))


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
    fine = {Surface.INNER: LocalSize(BALL_SIZE / ratio, inside)} if ratio > 1 else {}
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
    return replace(mesh, points=straightened(points, mesh.tets[(mesh.tets[:, :4] == vertex).any(axis=1)]))
