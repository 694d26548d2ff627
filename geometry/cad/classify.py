"""Which solids of a file are the rod and what belongs to it, and which are left out."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import vector
from geometry.assembly import Assembly
from geometry.cad.bores import SAME_DIAMETER, CadHole, CylindricalFaces, Pair, cylindrical_faces
from geometry.cad.formats import NamedSolid
from geometry.cad.pieces import cuts_between, fused, one_rod
from geometry.cad.shapes import has_mismeasured, recognised_faces, triangulated_mass
from geometry.errors import GeometryError, InvalidValue, require
from geometry.faces import Bore, solid_points
from geometry.holes import CLOSED, UNKNOWN, Diameters, off_the_rod, rod_frame
from geometry.imports import CadSolid, Role
from geometry.parts import BUSHING, CAP, LOWER_SHELL, NAMES, ROD, UPPER_SHELL, divided

# A rod's distance of the bores is at least this part of its length, and its width along the pins and its
# breadth at most these: 0.6 to 0.8, 0.1 to 0.4 and 0.3 to 0.6 on rods.
_REACH, _WIDTH, _BREADTH = 0.4, 0.8, 1.1
# Two bores, or two rods, of the same size differ by less, relatively.
_ALIKE = 0.02
# As many walls are tried for the small end if no solid is a rod, because holes in the shank may be larger.
_TRIED = 3
# What the user may say that a solid is.
ROLES = {
    "rod": Role.ROD,
    "cap": Role.CAP,
    "bushing": Role.BUSHING,
    "shell": Role.BUSHING,
    "bolt": Role.BOLT,
    "nut": Role.BOLT,
}
# A bushing or shell is at most this much longer than the bore, and its hole has at least this part of the
# bore's diameter (0.8 to 0.95); a pin is longer, or its hole smaller (0.3 to 0.65).
_OVERHANG, _THIN = 1.25, 0.75
# Places along each edge from which the extents of a solid of splines are taken: 1e-5 of a circle's diameter.
_FINE = np.linspace(0.0, 1.0, 513)


def cad_solid(tag: int, name: str, role: Role, *, kept: bool = True) -> CadSolid:
    """Measure a solid of the open model."""
    if has_mismeasured(tag):  # the kernel's box is that of the control points
        points, volume = solid_points(tag, _FINE), triangulated_mass(tag).mass
    else:
        points = np.reshape(gmsh.model.getBoundingBox(3, tag), (2, 3))
        volume = float(gmsh.model.occ.getMass(3, tag))
    return CadSolid(tag, name, role, kept, volume, vector(np.ptp(points, axis=0)))


def classified(
    solids: Sequence[NamedSolid], chosen: Sequence[str] = (), diameters: Diameters = UNKNOWN
) -> list[CadSolid]:
    """Classify the solids of a file, which are in the open model.

    `chosen` are the names of those to keep, with a role of `ROLES` before them where it cannot be recognised
    (``"cap: Deckel"``). Without it, the rod and what belongs to it are kept, or all solids if none is a rod.
    Raises `GeometryError`: several different rods, or an unknown name.
    """
    if len(solids) == 1:
        return [cad_solid(solids[0].tag, "rod", Role.ROD)]
    given = [solid.name or "part" for solid in solids]
    names = {
        solid.tag: name if solid.name and given.count(name) == 1 else f"{name} {place}"
        for place, (solid, name) in enumerate(zip(solids, given, strict=True), 1)
    }
    aliases = {solid.tag: {solid.name, names[solid.tag]} for solid in solids}
    every = set().union(*aliases.values())
    roles = dict(_name_and_role(text, every) for text in chosen)
    if unknown := [name for name in roles if name not in every]:
        listed = ", ".join(names.values())
        raise GeometryError(f"rod.solids names {unknown[0]!r}, but the solids of the file are: {listed}")
    keep = {name for name, role in roles.items() if role is not Role.BOLT}
    wanted = {tag for tag, both in aliases.items() if not both.isdisjoint(keep)}
    result = []
    for solid in _by_shape(names, wanted, diameters):
        role = next((roles[name] for name in aliases[solid.tag] if name in roles), None)
        result.append(solid if role is None else replace(solid, role=role, kept=role is not Role.BOLT))
    return result


# What is a part of its own, whatever it touches.
_APART = (Role.PIN, Role.BOLT, Role.BUSHING)


def in_one_piece(
    solids: Sequence[NamedSolid], chosen: Sequence[str], diameters: Diameters, *, apart: bool
) -> tuple[list[CadSolid], int]:
    """Classify the solids of a file as `classified` does, and join the pieces of a rod that was divided.

    Also returned is how many solids are joined. A rod and its cap stay parts; in an assembly (`apart`) a cap
    is never joined. Raises `GeometryError`: as `classified`, or pieces do not become one solid.
    """
    count = len(solids)
    if count == 1 or chosen:
        return classified(solids, chosen, diameters), 0
    cuts = cuts_between([solid.tag for solid in solids])
    walls = {solid.tag: cylindrical_faces(solid.tag) for solid in solids}
    if halves := one_rod(cuts, _rods(walls, diameters)):
        solids = fused(solids, halves)
        cuts = cuts_between([solid.tag for solid in solids])
    error: GeometryError | None = None
    result: list[CadSolid] = []
    try:
        result = classified(solids, (), diameters)
    except GeometryError as refused:
        error = refused
    roles = {solid.tag: solid.role for solid in result}
    kept = {solid.tag for solid in result if solid.kept}
    others = {tag for tag, role in roles.items() if role is Role.OTHER_ROD}
    beside = others | {tag for cut in cuts if others & {*cut.pair} for tag in cut.pair if tag not in kept}
    separate = {*_APART, *((Role.CAP,) if apart else ())}
    cuts = [
        cut
        for cut in cuts
        if beside.isdisjoint(cut.pair) and not any(roles.get(tag) in separate for tag in cut.pair)
    ]
    if cuts and (error is not None or any(len(kept & {*cut.pair}) == 1 for cut in cuts)):
        solids = fused(solids, cuts)
        result, error = classified(solids, (), diameters), None
    if error is not None:
        raise error
    return result, count - len(solids) + (len(solids) < count)


def _name_and_role(text: str, known: set[str]) -> tuple[str, Role | None]:
    """Name of a solid, and its role where that stands before it."""
    role, colon, name = text.partition(":")
    if text in known or not colon or role.strip().lower() not in ROLES:
        return text, None
    return name.strip(), ROLES[role.strip().lower()]


def _by_shape(names: Mapping[int, str], wanted: set[int], diameters: Diameters) -> list[CadSolid]:
    """Classify solids by their shapes; empty `wanted`: keep the rod and what belongs to it."""
    walls = {tag: cylindrical_faces(tag) for tag in names}
    alike = _rods(walls, diameters) or _rods(walls) or _rods(walls, tried=_TRIED)
    rods = {tag: bores for tag, bores in alike.items() if not wanted or tag in wanted}
    if not rods:
        kept = wanted or set(names)
        return [cad_solid(tag, name, Role.OTHER, kept=tag in kept) for tag, name in names.items()]
    volume_of = gmsh.model.occ.getMass
    measures = [(a.radius, b.radius, a.apart(b), volume_of(3, tag)) for tag, (a, b) in rods.items()]
    sizes = np.array(measures)
    if (np.abs(sizes / sizes[0] - 1) > _ALIKE).any():
        listed = "; ".join(
            f"{names[tag]} (bores of {2 * big:.4g} and {2 * small:.4g} mm, {apart:.4g} mm apart, "
            f"{volume:.4g} mm³)"
            for tag, (big, small, apart, volume) in zip(rods, sizes.tolist(), strict=True)
        )
        raise GeometryError(f"several solids of the file could be the rod: {listed}. Choose with rod.solids")
    rod = next(iter(rods))
    roles = {tag: _role(tag, walls[tag], rods[rod]) for tag in names}
    # Of a rod that is divided lengthwise, each half has the shape of a rod.
    roles |= {tag: Role.OTHER_ROD for tag in alike if roles[tag] is not Role.CAP} | {rod: Role.ROD}
    kept = wanted or {tag for tag, role in roles.items() if role in (Role.ROD, Role.CAP, Role.BUSHING)}
    return [cad_solid(tag, name, roles[tag], kept=tag in kept) for tag, name in names.items()]


def _rods(
    walls: Mapping[int, CylindricalFaces], diameters: Diameters = UNKNOWN, tried: int = 1
) -> dict[int, Pair]:
    """Bores of the solids of a rod's shape: the largest hollow wall, and one of the next parallel to it."""
    radii = [None if diameter is None else diameter / 2 for diameter in diameters]
    rods: dict[int, Pair] = {}
    for tag, of_solid in walls.items():
        big = next((wall for wall in of_solid.hollow() if wall.same_radius(radii[0], SAME_DIAMETER)), None)
        if big is None:
            continue
        apart = (
            wall
            for wall in of_solid.hollow()
            if big.parallel(wall)
            and big.apart(wall) > big.radius + wall.radius
            and wall.same_radius(radii[1], SAME_DIAMETER)
        )
        small = next((wall for wall in islice(apart, tried) if _is_rod(tag, big, wall)), None)
        if small is not None:
            rods[tag] = big, small
    return rods


def _is_rod(volume: int, big: CadHole, small: CadHole) -> bool:
    frame, distance = rod_frame(big.direction, small.center - big.center)
    length, breadth, width = np.ptp(solid_points(volume) @ frame.T, axis=0)
    middle = np.array(gmsh.model.occ.getCenterOfMass(3, volume))
    return bool(
        distance >= _REACH * length
        and width <= _WIDTH * distance
        and breadth <= _BREADTH * length
        and not off_the_rod((big, small), middle)
    )


def _role(volume: int, walls: CylindricalFaces, bores: Pair) -> Role:
    points = solid_points(volume)
    for bore in bores:
        height, radius = bore.along(points), bore.beside(points)
        coaxial = [wall.radius / bore.radius for wall in walls.about(bore, _ALIKE)]
        beside = abs(height.min() + height.max()) < bore.width  # else it belongs to another rod
        if radius.max() <= (1 + _ALIKE) * bore.radius and np.abs(height).min() <= bore.width / 2:
            if not coaxial or min(coaxial) < _THIN or np.ptp(height) > _OVERHANG * bore.width:
                return Role.PIN
            return Role.BUSHING if beside else Role.OTHER
        alike = any(abs(share - 1) < _ALIKE for share in coaxial)
        if bore.turn <= CLOSED and alike:
            return Role.CAP if beside else Role.OTHER
    size, reach = np.ptp(points, axis=0).max(), bores[0].apart(bores[1])
    near = np.linalg.norm(points.mean(axis=0) - bores[0].center) < 2.5 * bores[0].radius
    moments = np.linalg.eigvalsh(np.reshape(gmsh.model.occ.getMatrixOfInertia(3, volume), (3, 3)))
    slender = moments[-1] > 3 * moments[0]
    return Role.BOLT if near and size < 0.8 * reach and slender else Role.OTHER


def named_parts(
    kept: Sequence[CadSolid], bores: tuple[Bore, Bore], assembly: Assembly
) -> dict[str, list[int]]:
    """Volumes by the names of the parts; a rod in one piece is split, and shells are cut out of its ring."""
    volumes: dict[str, list[int]] = {}
    for solid in kept:
        volumes.setdefault(_name(solid, bores), []).append(solid.tag)
    if ROD not in volumes:
        listed = ", ".join(f"{solid.name} ({solid.role})" for solid in kept)
        raise GeometryError(f"no solid of the file is a rod: {listed}. Name rod and cap in rod.solids")
    shells = [name for name in (UPPER_SHELL, LOWER_SHELL) if name in volumes]
    if shells:
        rule = f"the file has bearing shells of its own ({', '.join(shells)})"
        shell = volumes[shells[0]]
        radii = [face.values[6] for face in recognised_faces(shell) if face.shape == "Cylinder"]
        thick = max(radii, default=0.0) - min(radii, default=0.0)
        fits = not assembly.shell or math.isclose(assembly.shell, thick, rel_tol=0.02)
        remedy = f"Leave it out, or give their thickness, {thick:.4g} mm."
        require(fits, "assembly.shell_thickness_mm", assembly.shell, rule, remedy)
    if BUSHING not in volumes and assembly.bushing:
        rule = "needs a bushing in the small end, but the file has none"
        raise InvalidValue("assembly.bushing_interference_mm", None, rule, "Add the bushing to the file.")
    if shells and CAP not in volumes:
        raise GeometryError("the file has bearing shells, but no cap. Add the cap to the file")
    normal = assembly.normal if CAP not in volumes and assembly.split is not None else None
    radius = bores[0].radius + assembly.shell if assembly.shell and not shells else None
    if normal is None and radius is None:
        return {name: volumes[name] for name in NAMES if name in volumes}
    if CAP in volumes:
        rule = "the shells are not among the solids of the file, whose cap is a part of its own"
        remedy = "Add them to the file, or leave it out."
        raise InvalidValue("assembly.shell_thickness_mm", assembly.shell, rule, remedy)
    bodies = {name: volumes[name][0] for name in (ROD, BUSHING) if name in volumes}
    bodies = divided(bodies, normal, radius, far=3 * (bores[1].x + 2 * bores[0].radius))
    gmsh.model.occ.synchronize()
    return {name: [tag] for name, tag in bodies.items()}


def _name(solid: CadSolid, bores: tuple[Bore, Bore]) -> str:
    if solid.role in (Role.ROD, Role.CAP, Role.ASSUMED_CAP):
        return ROD if solid.role is Role.ROD else CAP
    x, _, _ = gmsh.model.occ.getCenterOfMass(kernel.SOLID, solid.tag)
    if solid.role is Role.BUSHING:
        return BUSHING if abs(x - bores[1].x) < bores[1].x / 2 else UPPER_SHELL if x > 0 else LOWER_SHELL
    raise GeometryError(
        f"it is not clear what {solid.name} is in the assembly (taken for: {solid.role}). Say it in "
        'rod.solids, as "cap: NAME" (rod, cap, bushing, shell, bolt or nut), or keep other solids'
    )
