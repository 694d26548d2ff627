"""Extreme materials: stiffness contrast, near-incompressibility, other units."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fea.base.material import Materials
from fea.solid.recovery import Recovery
from fea.solid.traction import traction_forces
from fea.verify.body import STEEL, LoadedBody, held, pressure, quarter_ring, rectangle, uniform
from fea.verify.cases.elasticity import HOOP, lame_body, lame_exact
from fea.verify.cases.nafems import COOK_INCOMPRESSIBLE, NEARLY_INCOMPRESSIBLE, cook_body, cook_mesh, cook_tip
from fea.verify.stability.outcome import CheckedSolution, ExtremeRow, beyond, percent, solved, solved_by
from geometry.arrays import Floats
from geometry.bodies import Prism, SideBySide
from geometry.surfaces import Surface
from mesh.generate import mesh_body
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
