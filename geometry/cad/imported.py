"""A rod from a CAD file, placed and cut in the same way as one drawn from dimensions."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats
from geometry.assembly import Assembly, BoltAxis
from geometry.cad.bolt_holes import Fastener, bolt_holes, removed, spot_faced
from geometry.cad.bolts import found_bolts
from geometry.cad.bores import HalfOpenError, find_bores
from geometry.cad.classify import member, members, named_parts
from geometry.cad.cylinders import recognised
from geometry.cad.formats import declared_unit, read_solids
from geometry.cad.freecad import linked_files
from geometry.cad.holes import Hole, Interior
from geometry.cad.joint import Joint, assumed_cap, joint_of
from geometry.cad.placing import cut_to, joined_parts, parts_of, placed, sharing, smallest_cell
from geometry.cad.rounds import concave_rounds
from geometry.errors import GeometryError
from geometry.faces import Bore, Face, Feature, FeatureKind, face_of, faces_of, surfaces
from geometry.imports import (
    DECLARED,
    UNITS,
    BoreLocation,
    CadFile,
    CadSolid,
    ImportReport,
    MissingCap,
    Role,
    is_usual,
    plausible_unit,
    usual_units,
)
from geometry.mass import joined
from geometry.parts import CAP, ROD, Interface, contact_features, interfaces, seat_disks, with_seats
from geometry.solid import Solid
from geometry.surfaces import Mirror, Surface


def text_of(solid: Solid, joint: Joint | None) -> tuple[str, ...]:
    """Say where the parts touch and where the bolts are."""
    said = [] if joint is None else [joint.text()]
    for one in solid.interfaces:
        first, second = (solid.parts[number].name for number in one.parts)
        area = solid.mirror.copies * sum(gmsh.model.occ.getMass(2, face) for face in one.faces)
        said.append(f"{first} and {second} touch over {area:.4g} mm²")
    return (*said, *map(_bolt, solid.bolts))


def _bolt(bolt: BoltAxis) -> str:
    x, y, z = bolt.point
    end = (
        f"thread engaged over {bolt.engaged:.4g} mm in a hole of {2 * bolt.thread_radius:.4g} mm"
        if bolt.engaged
        else f"nut on {2 * bolt.nut_radius:.4g} mm"
    )
    return (
        f"bolt through the joint at ({x:.4g}, {y:.4g}, {z:.4g}) mm from the crank pin: hole of "
        f"{2 * bolt.hole_radius:.4g} mm, head on {2 * bolt.head_radius:.4g} mm, "
        f"grip {bolt.grip:.4g} mm, {end}"
    )


# Thickness of the ring at the joint over the bore's radius, at most.
_RING = 0.35
# Bolts and nuts reach this many radii of the bore from its centre.
_NEAR = 3.5


def assembled(
    file: CadFile,
    found: Sequence[CadSolid],
    holes: tuple[Hole, Hole],
    assembly: Assembly,
    *,
    mirror: Mirror | None,
    tell: Callable[[str], None],
) -> tuple[Solid, tuple[str, ...], tuple[str, ...]]:
    """Place the solids of a file, take out the bolts, and let the other parts touch.

    Parameters
    ----------
    file, mirror, tell
        As for `geometry.cad.imported.import_cad`.
    found
        Its solids.
    holes
        The bores of the big and the small end.
    assembly
        What is separate. The file's own cap, shells, bushing and bolts are taken where it has them.

    Returns
    -------
    Solid, tuple of str, tuple of str
        The solid; what was found and what was assumed of the assembly, in words.

    Raises
    ------
    InvalidValue
        What the assembly says does not fit the file.
    GeometryError
        The solids do not make an assembled rod.
    """
    kept = [one for one in found if one.kept]
    small = [one for one in found if not one.kept and one.role in (Role.BOLT, Role.OTHER)]
    small = [one for one in small if max(one.size) < _NEAR * holes[0].radius]
    gone = [one.tag for one in found if not one.kept and one not in small]
    if gone:
        gmsh.model.occ.remove([(kernel.SOLID, tag) for tag in gone], recursive=True)
        gmsh.model.occ.synchronize()
    bores = placed([one.tag for one in (*kept, *small)], *holes)
    fasteners = removed([one.tag for one in small])
    tell("dividing the assembly into its parts")
    volumes = named_parts(kept, bores, assembly)
    names = list(volumes)
    cells = dict(zip(names, sharing(list(volumes.values()), names), strict=True))
    joint = joint_of(cells[ROD], cells[CAP], bores[0].radius) if CAP in cells else None
    bolts, assumed = _bolts(cells, joint, fasteners, assembly, bores[0].radius)
    mirror = _mirror(file, [tag for cell in cells.values() for tag in cell], mirror, bores[1].x)
    every = [tag for cell in cells.values() for tag in cell]
    cut = iter(cut_to(every, mirror, bores[1].x))
    pieces = [[tag for _ in cell for tag in next(cut)] for cell in cells.values()]
    disks = [(2, disk) for bolt in bolts for disk in seat_disks(bolt)]
    parts = parts_of(sharing(pieces, names, disks), names, mirror)
    solid = Solid(mirror, bores, parts, {}, (), joined([part.mass for part in parts]), bolts=bolts)
    solid = _named_faces(solid, assembly, joint)
    return solid, text_of(solid, joint), assumed


def _faces(volumes: Sequence[int]) -> list[Face]:
    return [recognised(face) for face in faces_of(volumes)]


def _bolts(
    cells: dict[str, list[int]],
    joint: Joint | None,
    fasteners: Sequence[Fastener],
    assembly: Assembly,
    bore: float,
) -> tuple[tuple[BoltAxis, ...], tuple[str, ...]]:
    if joint is None:
        return (), ()
    faces = _faces(cells[ROD]), _faces(cells[CAP])
    holes = bolt_holes(cells[ROD], cells[CAP], faces, joint, bore)
    said = []
    if any(hole.head is None for hole in holes):
        given = 0.0 if assembly.bolt is None else assembly.bolt.head_diameter
        cells[CAP][0], faced = spot_faced(cells[CAP][0], holes, given / 2 or None)
        depth = max(hole.cap_end - new.cap_end for hole, new in zip(holes, faced, strict=True))
        said = [f"the cap has no plane seats for the bolts' heads: they are cut, up to {depth:.3g} mm deep"]
        holes = faced
    bolts, assumed = found_bolts(holes, fasteners, assembly.bolt)
    return bolts, (*said, *assumed)


def _mirror(file: CadFile, volumes: Sequence[int], asked: Mirror | None, length: float) -> Mirror:
    smallest = smallest_cell(volumes, length)
    if asked is not None and len(asked.planes) > len(smallest.planes):
        raise GeometryError(
            f"{file.path.name}: the solids do not have {asked} symmetry. "
            f'Use symmetry = "{smallest}" or "auto"'
        )
    return smallest if asked is None else asked


def _named_faces(solid: Solid, assembly: Assembly, joint: Joint | None) -> Solid:
    """Find surfaces, interfaces and features."""
    parts, bores = solid.parts, solid.bores
    volumes = [tag for part in parts for tag in part.volumes]
    faces = _faces(volumes)
    touching = interfaces([part.name for part in parts], [part.volumes for part in parts], assembly)
    named = with_seats(surfaces(bores, solid.mirror, faces), faces, solid.bolts)
    features = [
        Feature(FeatureKind.BORE, named[surface], bore.radius, 2 * math.pi)
        for surface, bore in zip((Surface.BIG_END_BORE, Surface.SMALL_END_BORE), bores, strict=True)
    ]
    free = [face for face in faces if face.tag in named[Surface.FREE]]
    rounds = concave_rounds(free, Interior(volumes), bores[1].x)
    ring = _RING * bores[0].radius
    across = {} if joint is None else {Surface.JOINT: min(joint.area / (2 * bores[0].width), ring)}
    small = contact_features(touching, named, solid.bolts, across | _walls(touching, bores))
    return replace(solid, faces=named, features=(*features, *rounds, *small), interfaces=touching)


def _walls(touching: Sequence[Interface], bores: tuple[Bore, Bore]) -> dict[Surface, float]:
    """Thickness of bushing and shells by their seats, mm."""
    found = {}
    for surface, bore in ((Surface.SHELL_SEAT, bores[0]), (Surface.BUSHING_SEAT, bores[1])):
        every = [face for one in touching if one.sides[0] is surface for face in one.faces]
        shapes = [recognised(face_of(face)) for face in every]
        radii = [face.values[6] for face in shapes if face.shape == "Cylinder"]
        if every:
            found[surface] = max(max(radii, default=1.05 * bore.radius) - bore.radius, 0.01 * bore.radius)
    return found


def import_cad(
    file: CadFile,
    mirror: Mirror | None = None,
    tell: Callable[[str], None] = lambda _stage: None,
    assembly: Assembly | None = None,
) -> Solid:
    """Read the rod of a file into a new model of the open session and place it in the rod's frame.

    Parameters
    ----------
    file
        The file, and what the user says of it.
    mirror
        The cell to keep; None for the smallest that the solid's symmetry allows.
    tell
        Told what is being done.
    assembly
        What is separate; None for solids that are bonded to each other where they touch.

    Returns
    -------
    Solid
        One part per solid that is kept, under its name in the file or, in an assembly, under those of
        `geometry.parts`; touching parts share their faces.

    Raises
    ------
    GeometryError
        No rod in the file, bores that cannot be identified, a mirror plane that the solid lacks, or solids
        that do not make an assembly.
    InvalidValue
        What the assembly says does not fit the file.
    OSError
        The file cannot be read.
    """
    declared = declared_unit(file.path)
    unit = file.unit or declared
    found, holes = _found(file, unit, tell)
    if file.unit is None and (better := plausible_unit(holes[0].apart(holes[1]), unit)) != unit:
        unit = better
        found, holes = _found(file, unit, tell)
    bores = tuple(BoreLocation(2 * hole.radius, _vector(hole.center), hole.mean_width) for hole in holes)
    said = _assumed(file, declared, unit, found, holes[0].apart(holes[1]), bonded=assembly is None)
    if assembly is None:
        solid = _cut(file, found, holes, mirror, tell)
        return replace(solid, imported=ImportReport(unit, tuple(found), (bores[0], bores[1]), tuple(said)))
    solid, text, more = assembled(file, found, holes, assembly, mirror=mirror, tell=tell)
    return replace(
        solid, imported=ImportReport(unit, tuple(found), (bores[0], bores[1]), (*said, *more), text)
    )


def _found(file: CadFile, unit: str, tell: Callable[[str], None]) -> tuple[list[CadSolid], tuple[Hole, Hole]]:
    """Read the file, its numbers in a unit; return its solids and the bores."""
    tell(f"reading {file.path.name}")
    solids = read_solids(file.path, unit)
    if len(solids) > 1:
        tell(f"looking for the rod among {len(solids)} solids")
    named = (file.big_end_bore, file.small_end_bore)
    found = members(solids, file.solids, named)
    tags = [one.tag for one in found if one.kept]
    tell("looking for the bores")
    try:
        bores = find_bores(tags, _faces(tags), named)
        return found, bores if any(named) else _capped_first(bores, found)
    except HalfOpenError as missing:
        if file.cap is not MissingCap.ASSUMED:
            raise
        cap = member(assumed_cap(_faces(tags), missing.wall), "assumed cap", Role.ASSUMED_CAP)
        tags.append(cap.tag)
        return [*found, cap], find_bores(tags, _faces(tags), named)
    except GeometryError as error:
        if linked := linked_files(file.path):
            raise GeometryError(
                f"{error}. Parts of {file.path.name} are links to other files, whose shapes it does not hold "
                f"({', '.join(linked)}): read the file of the rod, or export the assembly as STEP"
            ) from error
        raise


def _capped_first(bores: tuple[Hole, Hole], found: Sequence[CadSolid]) -> tuple[Hole, Hole]:
    """Take the bore with the cap for the big end's, if it is the smaller one."""
    caps = [gmsh.model.occ.getCenterOfMass(3, one.tag) for one in found if one.role is Role.CAP and one.kept]
    if caps:
        middle = np.mean(caps, axis=0)
        big, small = (float(np.linalg.norm(middle - bore.center)) for bore in bores)
        if small < big:
            return bores[::-1]
    return bores


def _assumed(
    file: CadFile, declared: str, unit: str, found: Sequence[CadSolid], length: float, *, bonded: bool
) -> list[str]:
    """What the user must know was assumed."""
    said = []
    if file.unit is None and unit != declared:
        said.append(
            f"{file.path.name}: lengths are taken to be in {unit}, because in {declared}, as the file "
            "declares, the rod would be of no usual length (rod.unit)"
        )
    elif file.unit is None and not is_usual(length):
        number = length / DECLARED[unit]
        said += [
            f"{file.path.name}: the bores are {length:.4g} mm apart, which is unusual for a rod; with "
            f'rod.unit = "{other}" they would be {number * UNITS[other]:.4g} mm apart'
            for other in list(usual_units(number))[:1]
        ]
    if any(one.role is Role.ASSUMED_CAP for one in found):
        said.append(
            "the cap is missing: a ring of the section at the joint is assumed, without bolts (rod.cap)"
        )
    kept = [f"{one.name} ({one.role})" if one.name != one.role else one.name for one in found if one.kept]
    if len(kept) > 1 and bonded:
        said.append(f"{', '.join(kept)}: bonded to each other where they touch")
    left = [
        f"{one.name} ({one.role})" for one in found if not one.kept and (bonded or one.role is not Role.BOLT)
    ]
    if left and not file.solids:
        said.append(f"left out of {file.path.name}: {', '.join(left)} (rod.solids)")
    return said


def _cut(
    file: CadFile,
    found: Sequence[CadSolid],
    holes: tuple[Hole, Hole],
    mirror: Mirror | None,
    tell: Callable[[str], None],
) -> Solid:
    """Place and cut what is kept."""
    kept = [one for one in found if one.kept]
    left = [(kernel.SOLID, one.tag) for one in found if not one.kept]
    if left:
        gmsh.model.occ.remove(left, recursive=True)
        gmsh.model.occ.synchronize()
    volumes = [one.tag for one in kept]
    tell("looking for mirror planes")
    bores = placed(volumes, *holes)
    length = bores[1].x
    smallest = smallest_cell(volumes, length)
    mirror = smallest if mirror is None else mirror
    if len(mirror.planes) > len(smallest.planes):
        raise GeometryError(
            f"{file.path.name}: the solid does not have {mirror} symmetry. "
            f'Use symmetry = "{smallest}" or "auto"'
        )
    names = [one.name for one in kept] if len(kept) > 1 else ["rod"]
    parts = joined_parts(cut_to(volumes, mirror, length), names, mirror)
    volumes = [tag for part in parts for tag in part.volumes]
    faces = _faces(volumes)
    mass = joined([part.mass for part in parts])
    named = surfaces(bores, mirror, faces)
    features = [
        Feature(FeatureKind.BORE, named[surface], bore.radius, 2 * math.pi)
        for surface, bore in zip((Surface.BIG_END_BORE, Surface.SMALL_END_BORE), bores, strict=True)
    ]
    free = [face for face in faces if face.tag in named[Surface.FREE]]
    rounds = concave_rounds(free, Interior(volumes), length)
    return Solid(mirror, bores, parts, named, (*features, *rounds), mass)


def _vector(values: Floats) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
