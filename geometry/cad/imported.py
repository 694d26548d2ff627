"""A rod from a CAD file, placed and cut in the same way as one drawn from dimensions."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import gmsh
import numpy as np

from geometry.arrays import vector
from geometry.assembly import Assembly, BoltAxis
from geometry.cad.bolts import Fastener, bolts_in, removed
from geometry.cad.bores import HalfOpenError, Pair, find_bores
from geometry.cad.classify import cad_solid, classified, named_parts
from geometry.cad.formats import declared_unit, linked_files, read_solids
from geometry.cad.joint import Joint, assumed_cap, bolt_holes, joint_of, spot_faced
from geometry.cad.placing import cut_to, parts_of, placed, sharing, smallest_cell
from geometry.cad.shapes import concave_rounds, recognised, recognised_faces
from geometry.errors import GeometryError
from geometry.faces import Bore, Feature, FeatureKind, face_of, surfaces
from geometry.holes import EQUAL_BORES
from geometry.imports import (
    DECLARED,
    UNITS,
    BoreLocation,
    CadSolid,
    ImportReport,
    MissingCap,
    RodFile,
    Role,
    is_usual,
    plausible_unit,
    usual_units,
)
from geometry.kernel import SOLID
from geometry.mass import joined
from geometry.parts import CAP, ROD, Interface, seat_disks, with_seats
from geometry.solid import Part, Solid, with_contacts
from geometry.surfaces import Mirror, Surface

# Thickness of the ring at the joint over the bore's radius, at most.
_RING = 0.35
_LISTED = 3  # solids that are left out, by name
# Bolts and nuts reach this many radii of the bore from its centre.
_NEAR = 3.5


def import_cad(
    file: RodFile,
    mirror: Mirror | None = None,
    tell: Callable[[str], None] = lambda _stage: None,
    assembly: Assembly | None = None,
) -> Solid:
    """Read the rod of a file into a new model of the open session and place it in the rod's frame.

    Each solid that is kept is a part, under its name in the file or, in an assembly, under those of
    `geometry.parts`; touching parts share their faces. Without an assembly they are bonded to each other;
    else the file's own cap, shells, bushing and bolts are taken where it has them. Without `mirror`, the
    smallest symmetry cell is kept. Raises `GeometryError`: no rod in the file, bores that cannot be
    identified, a mirror plane that the solid lacks, or solids that do not make an assembly; `InvalidValue`:
    what the assembly says does not fit the file; `OSError`: the file cannot be read.
    """
    declared = declared_unit(file.path)
    unit = file.unit or declared
    solids, holes = _read(file, unit, tell)
    if file.unit is None and (better := plausible_unit(holes[0].apart(holes[1]), unit)) != unit:
        unit = better
        solids, holes = _read(file, unit, tell)
    if file.swap_ends:
        holes = holes[::-1]
    big, small = (BoreLocation(2 * hole.radius, vector(hole.center), hole.mean_width) for hole in holes)
    capped = any(one.role in (Role.CAP, Role.ASSUMED_CAP) and one.kept for one in solids)
    told = capped or file.swap_ends or file.big_end_bore or not holes[0].same_radius(holes[1].radius, 1e-3)
    assumed = [] if told else [EQUAL_BORES]
    assumed += _assumed(file, declared, unit, solids, holes[0].apart(holes[1]), bonded=assembly is None)
    listing: tuple[str, ...] = ()
    if assembly is None:
        solid = _bonded(file, solids, holes, mirror, tell)
    else:
        solid, listing, more = _assembled(file, solids, holes, assembly, mirror=mirror, tell=tell)
        assumed += more
    return replace(solid, imported=ImportReport(unit, tuple(solids), (big, small), tuple(assumed), listing))


def _read(file: RodFile, unit: str, tell: Callable[[str], None]) -> tuple[list[CadSolid], Pair]:
    tell(f"reading {file.path.name}")
    named = read_solids(file.path, unit)
    if isinstance(file.cap, Path):
        named += read_solids(file.cap, unit, beside=True)
    if len(named) > 1:
        tell(f"looking for the rod among {len(named)} solids")
    solids = classified(named, file.solids, file.diameters)
    tags = [one.tag for one in solids if one.kept]
    tell("looking for the bores")
    try:
        bores = find_bores(tags, recognised_faces(tags), file.diameters)
    except HalfOpenError as missing:
        if file.cap is not MissingCap.ASSUMED:
            raise
        cap = cad_solid(assumed_cap(recognised_faces(tags), missing.wall), "assumed cap", Role.ASSUMED_CAP)
        tags.append(cap.tag)
        return [*solids, cap], find_bores(tags, recognised_faces(tags), file.diameters)
    except GeometryError as error:
        if linked := linked_files(file.path):
            raise GeometryError(
                f"{error}. Parts of {file.path.name} are links to other files, whose shapes it does not hold "
                f"({', '.join(linked)}): read the file of the rod, or export the assembly as STEP"
            ) from error
        raise
    caps = [one.tag for one in solids if one.role is Role.CAP and one.kept]
    if caps and not any(file.diameters):
        middle = np.mean([gmsh.model.occ.getCenterOfMass(3, tag) for tag in caps], axis=0)
        big, small = (np.linalg.norm(middle - bore.center) for bore in bores)
        bores = bores[::-1] if small < big else bores
    return solids, bores


def _assumed(
    file: RodFile, declared: str, unit: str, solids: Sequence[CadSolid], length: float, *, bonded: bool
) -> list[str]:
    notes = []
    if file.unit not in (None, declared):
        meant = length / UNITS[unit] * DECLARED[declared]
        notes.append(
            f"{file.path.name}: lengths are read in {unit} (rod.unit), though the file declares {declared}, "
            f"in which the bores would be {meant:.4g} mm apart, not {length:.4g} mm"
        )
    if file.unit is None and unit != declared:
        notes.append(
            f"{file.path.name}: lengths are taken to be in {unit}, because in {declared}, as the file "
            "declares, the rod would be of no usual length (rod.unit)"
        )
    elif file.unit is None and not is_usual(length):
        number = length / DECLARED[unit]
        notes += [
            f"{file.path.name}: the bores are {length:.4g} mm apart, which is unusual for a rod; with "
            f'rod.unit = "{other}" they would be {number * UNITS[other]:.4g} mm apart'
            for other in list(usual_units(number))[:1]
        ]
    if any(one.role is Role.ASSUMED_CAP for one in solids):
        notes.append(
            "the cap is missing: a ring of the section at the joint is assumed, without bolts (rod.cap)"
        )
    kept = [f"{one.name} ({one.role})" if one.name != one.role else one.name for one in solids if one.kept]
    if len(kept) > 1 and bonded:
        notes.append(f"{', '.join(kept)}: bonded to each other where they touch")
    left = [one for one in solids if not one.kept and (bonded or one.role is not Role.BOLT)]
    if left and not file.solids:
        listed = ", ".join(f"{one.name} ({one.role})" for one in left[:_LISTED])
        more = f" and {len(left) - _LISTED} more solids" if len(left) > _LISTED else ""
        notes.append(f"left out of {file.path.name}: {listed}{more} (rod.solids)")
    return notes


def _bonded(
    file: RodFile,
    solids: Sequence[CadSolid],
    holes: Pair,
    mirror: Mirror | None,
    tell: Callable[[str], None],
) -> Solid:
    kept = [one for one in solids if one.kept]
    _remove([one.tag for one in solids if not one.kept])
    tags, names = [one.tag for one in kept], [one.name for one in kept] if len(kept) > 1 else ["rod"]
    tell("looking for mirror planes")
    bores = placed(tags, *holes)
    mirror = _cell(file, tags, mirror, bores[1].x, "the solid does not")
    pieces = sharing(cut_to(tags, mirror, bores[1].x), names)
    return _solid(mirror, bores, parts_of(pieces, names, mirror))


def _assembled(
    file: RodFile,
    solids: Sequence[CadSolid],
    holes: Pair,
    assembly: Assembly,
    *,
    mirror: Mirror | None,
    tell: Callable[[str], None],
) -> tuple[Solid, tuple[str, ...], list[str]]:
    """Take out the bolts and let the other parts touch; what was read and assumed is returned in words."""
    kept = [one for one in solids if one.kept]
    small = [one for one in solids if not one.kept and one.role in (Role.BOLT, Role.OTHER)]
    small = [one for one in small if max(one.size) < _NEAR * holes[0].radius]
    _remove([one.tag for one in solids if not one.kept and one not in small])
    bores = placed([one.tag for one in (*kept, *small)], *holes)
    fasteners = removed([one.tag for one in small])
    tell("dividing the assembly into its parts")
    volumes = named_parts(kept, bores, assembly)
    names = list(volumes)
    cells = dict(zip(names, sharing(list(volumes.values()), names), strict=True))
    joint = joint_of(cells[ROD], cells[CAP], bores[0].radius) if CAP in cells else None
    bolts, assumed = _bolts(cells, joint, fasteners, assembly, bores[0].radius)
    every = [tag for cell in cells.values() for tag in cell]
    mirror = _cell(file, every, mirror, bores[1].x, "the solids do not")
    cut = iter(cut_to(every, mirror, bores[1].x))
    pieces = [[tag for _ in cell for tag in next(cut)] for cell in cells.values()]
    disks = [(2, disk) for bolt in bolts for disk in seat_disks(bolt)]
    parts = parts_of(sharing(pieces, names, disks), names, mirror)
    solid = with_contacts(
        _solid(mirror, bores, parts, bolts), assembly, lambda touching: _walls(joint, touching, bores)
    )
    listing = [] if joint is None else [joint.text()]
    for one in solid.interfaces:
        first, second = (solid.parts[number].name for number in one.parts)
        area = solid.mirror.copies * sum(gmsh.model.occ.getMass(2, face) for face in one.faces)
        listing.append(f"{first} and {second} touch over {area:.4g} mm²")
    for bolt in solid.bolts:
        x, y, z = bolt.point
        end = (
            f"thread engaged over {bolt.engaged:.4g} mm in a hole of {2 * bolt.thread_radius:.4g} mm"
            if bolt.engaged
            else f"nut on {2 * bolt.nut_radius:.4g} mm"
        )
        listing.append(
            f"bolt through the joint at ({x:.4g}, {y:.4g}, {z:.4g}) mm from the crank pin: hole of "
            f"{2 * bolt.hole_radius:.4g} mm, head on {2 * bolt.head_radius:.4g} mm, "
            f"grip {bolt.grip:.4g} mm, {end}"
        )
    return solid, tuple(listing), assumed


def _remove(volumes: Sequence[int]) -> None:
    """Remove volumes with what only they have: solids first, as the kernel seeks users of each entity."""
    gone = [(SOLID, tag) for tag in volumes]
    while gone:
        bounding = gmsh.model.getBoundary(gone, combined=False, oriented=False)
        gmsh.model.occ.remove(gone)
        gmsh.model.occ.synchronize()
        gone = [
            entity for entity in dict.fromkeys(bounding) if not gmsh.model.getAdjacencies(*entity)[0].size
        ]


def _cell(file: RodFile, volumes: Sequence[int], asked: Mirror | None, length: float, lack: str) -> Mirror:
    smallest = smallest_cell(volumes, length)
    if asked is not None and len(asked.planes) > len(smallest.planes):
        raise GeometryError(
            f'{file.path.name}: {lack} have {asked} symmetry. Use symmetry = "{smallest}" or "auto"'
        )
    return smallest if asked is None else asked


def _solid(
    mirror: Mirror, bores: tuple[Bore, Bore], parts: tuple[Part, ...], bolts: tuple[BoltAxis, ...] = ()
) -> Solid:
    volumes = [tag for part in parts for tag in part.volumes]
    faces = recognised_faces(volumes)
    named = with_seats(surfaces(bores, mirror, faces), faces, bolts)
    features = [
        Feature(FeatureKind.BORE, named[surface], bore.radius, 2 * math.pi)
        for surface, bore in zip((Surface.BIG_END_BORE, Surface.SMALL_END_BORE), bores, strict=True)
    ]
    free = [face for face in faces if face.tag in named[Surface.FREE]]
    features += concave_rounds(free, bores[1].x)
    mass = joined([part.mass for part in parts])
    return Solid(mirror, bores, parts, named, tuple(features), mass, bolts=bolts)


def _bolts(
    cells: dict[str, list[int]],
    joint: Joint | None,
    fasteners: Sequence[Fastener],
    assembly: Assembly,
    bore: float,
) -> tuple[tuple[BoltAxis, ...], list[str]]:
    """The bolts, and what was assumed of them; where the cap has no seats for their heads, they are cut."""
    if joint is None:
        return (), []
    holes, notes = bolt_holes(cells[ROD], cells[CAP], joint, bore), []
    if any(hole.head is None for hole in holes):
        given = 0.0 if assembly.bolt is None else assembly.bolt.head_diameter
        cells[CAP][0], faced = spot_faced(cells[CAP][0], holes, given / 2 or None)
        depth = max(hole.cap_end - new.cap_end for hole, new in zip(holes, faced, strict=True))
        notes = [f"the cap has no plane seats for the bolts' heads: they are cut, up to {depth:.3g} mm deep"]
        holes = faced
    bolts, assumed = bolts_in(holes, fasteners, assembly.bolt)
    return bolts, [*notes, *assumed]


def _walls(
    joint: Joint | None, touching: Sequence[Interface], bores: tuple[Bore, Bore]
) -> dict[Surface, float]:
    """Thickness of the ring at the joint, and of bushing and shells by their seats, mm."""
    walls = {}
    if joint is not None:
        walls[Surface.JOINT] = min(joint.area / (2 * bores[0].width), _RING * bores[0].radius)
    for surface, bore in ((Surface.SHELL_SEAT, bores[0]), (Surface.BUSHING_SEAT, bores[1])):
        faces = [face for one in touching if one.sides[0] is surface for face in one.faces]
        shapes = [recognised(face_of(face)) for face in faces]
        radii = [face.values[6] for face in shapes if face.shape == "Cylinder"]
        if faces:
            walls[surface] = max(max(radii, default=1.05 * bore.radius) - bore.radius, 0.01 * bore.radius)
    return walls
