"""A rod from a CAD file: read, placed, cut at its mirror planes, and named as one drawn from dimensions."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import vector
from geometry.assembly import Assembly, BoltAxis
from geometry.cad.bolts import Fastener, bolts_in, removed
from geometry.cad.bores import SAME_DIAMETER, CadHole, HalfOpenError, Pair, find_bores, through_holes
from geometry.cad.classify import cad_solid, in_one_piece, named_parts
from geometry.cad.formats import declared_unit, linked_files, read_solids
from geometry.cad.joint import Joint, assumed_cap, bolt_holes, joint_of, spot_faced
from geometry.cad.mirror_planes import cut_to, smallest_cell
from geometry.cad.pieces import TOUCHING, overlap, touch, without_copies
from geometry.cad.shapes import (
    ROUND,
    Interior,
    concave_rounds,
    has_mismeasured,
    recognised,
    recognised_faces,
    triangulated_mass,
)
from geometry.errors import GeometryError
from geometry.faces import Bore, Feature, FeatureKind, face_of, surfaces
from geometry.holes import EQUAL_BORES, carried_rods, place_text, rod_frame
from geometry.imports import (
    CAP_ASSUMED,
    DECLARED,
    FORMATS,
    UNITS,
    BoreLocation,
    CadFormat,
    CadSolid,
    ImportReport,
    MissingCap,
    RodFile,
    Role,
    is_usual,
    not_a_length,
    plausible_unit,
    usual_units,
)
from geometry.kernel import SOLID
from geometry.mass import MassProperties, joined
from geometry.parts import CAP, ROD, PartInterface, joined_groups, remove_all, seat_disks, with_seats
from geometry.solid import Part, Solid, reflected, whole_mass, with_contacts
from geometry.surfaces import Mirror, Surface


def placed(volumes: Sequence[int], big: CadHole, small: CadHole) -> tuple[Bore, Bore]:
    """Move the solid so that the big-end bore is the origin, x leads to the small end, z along the pins."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 - only imported solids need it

    frame, length = rod_frame(big.direction, small.center - big.center)
    turn = Rotation.from_matrix(frame).as_rotvec()
    angle = float(np.linalg.norm(turn))
    solids = [(kernel.SOLID, tag) for tag in volumes]
    with kernel.attempt("place the solid in the rod's frame"):
        gmsh.model.occ.translate(solids, *(-big.center))
        if angle > 1e-12:
            gmsh.model.occ.rotate(solids, 0, 0, 0, *(turn / angle), angle)
        gmsh.model.occ.synchronize()
    return (
        Bore(0.0, big.radius, big.mean_width, slack=_slack(big)),
        Bore(length, small.radius, small.mean_width, small.taper(frame[0]), slack=_slack(small)),
    )


def _slack(hole: CadHole) -> float:
    """Largest distance of the faces of a bore from its cylinder, mm; 0 where all are the same cylinder."""
    exact = hole.deviation < 1e-6 * hole.radius and not hole.fitted
    return 0.0 if exact else 2 * (hole.deviation + ROUND * hole.radius)


def parts_of(cells: Sequence[Sequence[int]], names: Sequence[str], mirror: Mirror) -> tuple[Part, ...]:
    """Name the volumes of each part and compute its mass properties."""
    distinct = [
        name if names.count(name) == 1 else f"{name} {names[:place].count(name) + 1}"
        for place, name in enumerate(names)
    ]
    return tuple(
        Part(name, tuple(cell), joined([_mass(tag, mirror) for tag in cell]))
        for name, cell in zip(distinct, cells, strict=True)
    )


def _mass(tag: int, mirror: Mirror) -> MassProperties:
    return reflected(triangulated_mass(tag), mirror) if has_mismeasured(tag) else whole_mass(tag, mirror)


Entity = tuple[int, int]


def sharing(
    cells: Sequence[Sequence[int]], names: Sequence[str], borders: Sequence[Entity] = ()
) -> list[list[int]]:
    """Let touching solids share their faces; return the volumes that each became.

    `cells` are the volume tags of each solid. `borders` are faces whose edges become edges of the solids'
    faces; they are used up. Raises `GeometryError`: solids overlap, or one touches no other.
    """
    volumes = [list(cell) for cell in cells]
    if sum(map(len, volumes)) > 1 or borders:
        every = [(kernel.SOLID, tag) for cell in volumes for tag in cell]
        with kernel.attempt("join the parts at their common faces"):
            _, pieces = gmsh.model.occ.fragment(every, list(borders))
        of_solids = zip(every, pieces[: len(every)], strict=True)
        became = {tag: [piece for _, piece in made] for (_, tag), made in of_solids}
        volumes = [[piece for tag in cell for piece in became[tag]] for cell in volumes]
        every_piece = [piece for cell in volumes for piece in cell]
        if len(set(every_piece)) < len(every_piece):
            raise GeometryError(
                f"the solids {', '.join(names)} overlap; they may only touch. Correct them in the CAD "
                "program, or keep only some of them with rod.solids"
            )
        remove_all({piece for made in pieces[len(every) :] for piece in made})
    gmsh.model.occ.synchronize()
    group = joined_groups(volumes)
    if group.any():
        gap, loose, joined = min(
            (gmsh.model.occ.getDistance(kernel.SOLID, a, kernel.SOLID, b)[0], loose, joined)
            for loose in np.flatnonzero(group).tolist()
            for joined in np.flatnonzero(group == 0).tolist()
            for a in volumes[loose]
            for b in volumes[joined]
        )
        raise GeometryError(
            f"the solids {names[loose]} and {names[joined]} do not touch (gap {gap:.3g} mm), so they cannot "
            "be bonded to each other. Close the gap in the CAD program, or keep only solids that touch with "
            "rod.solids"
        )
    return volumes


# Thickness of the ring at the joint over the bore's radius, at most.
_RING = 0.35
_LISTED = 3  # solids that are left out, by name
# Bolts and nuts reach this many radii of the bore from its centre.
_NEAR = 3.5


def import_cad(
    file: RodFile, tell: Callable[[str], None] = lambda _stage: None, assembly: Assembly | None = None
) -> Solid:
    """Read the rod of a file into a new model of the open session and place it in the rod's frame.

    Solids that are kept are parts, by their names in the file or, in an assembly, of `geometry.parts`;
    touching parts share their faces, and without an assembly are bonded. The smallest symmetry cell is kept.
    Raises `GeometryError`: no rod, no bores, a mirror plane that the solid lacks, or no assembly;
    `InvalidValue`: the assembly does not fit the file; `OSError`: the file cannot be read.
    """
    declared = declared_unit(file.path)
    unit = file.unit or declared
    read = _read(file, unit, tell, apart=assembly is not None)
    if file.unit is None and (better := plausible_unit(read.length, unit)) != unit:
        unit, read = better, _read(file, better, tell, apart=assembly is not None)
    if why := not_a_length(read.length, unit):
        raise GeometryError(f"{file.path.name}: {why}")
    solids, holes = read.solids, read.bores[::-1] if file.swap_ends else read.bores
    locations = [BoreLocation(2 * hole.radius, vector(hole.center), hole.mean_width) for hole in holes]
    capped = any(solid.role in (Role.CAP, Role.ASSUMED_CAP) and solid.kept for solid in solids)
    identified = capped or file.swap_ends or file.big_end_bore
    equal = not identified and holes[0].same_radius(holes[1].radius, SAME_DIAMETER)
    notes = [*read.notes, *([EQUAL_BORES] if equal else [])]
    notes += _assumed(file, declared, unit, read, bonded=assembly is None)
    tags = [solid.tag for solid in solids if solid.kept]
    carried = carried_rods(holes, through_holes(Interior(tags), recognised_faces(tags)))
    listing: tuple[str, ...] = ()
    if assembly is None:
        drawn = _bonded(solids, holes, tell)
    else:
        drawn, listing, more = _assembled(solids, holes, assembly, tell)
        notes += more
    bores = locations[0], locations[1]
    report = ImportReport(unit, tuple(solids), bores, tuple(notes), listing, read.doubts, carried)
    return replace(drawn, imported=report)


class _Read(NamedTuple):
    """Solids of a file in the open model, their bores, and notes on the solids."""

    solids: list[CadSolid]
    bores: Pair
    doubts: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def length(self) -> float:
        """Distance of the bores, mm."""
        return self.bores[0].apart(self.bores[1])


def _read(file: RodFile, unit: str, tell: Callable[[str], None], *, apart: bool) -> _Read:
    tell(f"reading {file.path.name}")
    named = read_solids(file.path, unit)
    if isinstance(file.cap, Path):
        named += read_solids(file.cap, _cap_unit(file.cap, file, unit), beside=True)
    if len(named) > 1:
        tell(f"looking for the rod among {len(named)} solids")
    named, copies = without_copies(named)
    solids, pieces = in_one_piece(named, file.solids, file.diameters, apart=apart)
    tags = [solid.tag for solid in solids if solid.kept]
    tell("looking for the bores")
    try:
        bores = find_bores(tags, recognised_faces(tags), file.diameters)
    except HalfOpenError as missing:
        if file.cap is not MissingCap.ASSUMED:
            raise _unclosed(file, missing) from None
        cap = cad_solid(assumed_cap(recognised_faces(tags), missing.wall), "assumed cap", Role.ASSUMED_CAP)
        tags.append(cap.tag)
        return _Read([*solids, cap], find_bores(tags, recognised_faces(tags), file.diameters))
    except GeometryError as error:
        if linked := linked_files(file.path):
            raise GeometryError(
                f"{error}. Parts of {file.path.name} are links to other files, whose shapes it does not hold "
                f"({', '.join(linked)}): read the file of the rod, or export the assembly as STEP"
            ) from error
        raise
    caps = [solid.tag for solid in solids if solid.role is Role.CAP and solid.kept]
    if caps and not any(file.diameters):
        middle = np.mean([gmsh.model.occ.getCenterOfMass(3, tag) for tag in caps], axis=0)
        big, small = (np.linalg.norm(middle - bore.center) for bore in bores)
        bores = bores[::-1] if small < big else bores
    notes = []
    if copies:
        notes.append(f"{copies} of the solids of {file.path.name} are drawn twice at one place: counted once")
    if pieces:
        notes.append(f"{pieces} solids of {file.path.name} are pieces of one rod: joined where they were cut")
    return _Read(solids, bores, tuple(_left_touching(solids, file, bonded=not apart)), tuple(notes))


def _cap_unit(cap: Path, file: RodFile, unit: str) -> str:
    """Unit of the file of a cap: its own, if the rod was read in the one that it declares; else `unit`."""
    declares = FORMATS.get(cap.suffix.lower()) in (CadFormat.STEP, CadFormat.IGES)
    return declared_unit(cap) if declares and file.unit is None and unit == declared_unit(file.path) else unit


def _unclosed(file: RodFile, missing: HalfOpenError) -> GeometryError:
    """Error of a bore that is half open, with or without the file of a cap."""
    if not isinstance(file.cap, Path):
        return missing
    return GeometryError(
        f"{file.cap.name} does not close the largest bore of {file.path.name}, {missing.wall.text()}. Draw "
        "both where they are in the rod, in the units that the files declare, or give the unit of both with "
        "--unit (rod.unit)"
    )


def _left_touching(solids: Sequence[CadSolid], file: RodFile, *, bonded: bool) -> Iterator[str]:
    """Solids left out though they touch what is analysed. Raises `GeometryError`: one overlaps it."""
    kept = [solid for solid in solids if solid.kept]
    slack = TOUCHING * max(float(np.max(solid.size)) for solid in kept)
    touching = []
    for left in solids:
        if left.kept or not (bonded or left.role is not Role.BOLT):
            continue
        near = [solid for solid in kept if touch(solid.tag, left.tag, slack)]
        if left.role in (Role.OTHER, Role.OTHER_ROD) and not file.solids:
            within = next((solid for solid in near if overlap(solid.tag, left.tag)), None)
            if within is not None:
                raise GeometryError(
                    f"the solids {within.name} and {left.name} of {file.path.name} overlap, and it is not "
                    "clear whether both belong to the rod. Join them in the CAD program (Boolean union), "
                    "or name those to keep in rod.solids"
                )
        touching += [left] if near else []
    if touching:
        yield f"{_listed(touching)}: left out, though touching the rod; what belongs to it goes in rod.solids"


def _listed(solids: Sequence[CadSolid]) -> str:
    more = f" and {len(solids) - _LISTED} more solids" if len(solids) > _LISTED else ""
    return ", ".join(solid.text() for solid in solids[:_LISTED]) + more


def _assumed(file: RodFile, declared: str, unit: str, read: _Read, *, bonded: bool) -> list[str]:
    """Notes on the unit of length, and on the solids that are bonded, assumed or left out."""
    notes, length = [], read.length
    if file.unit not in (None, declared):
        meant = length / UNITS[unit] * DECLARED[declared]
        notes.append(
            f'{file.path.name}: rod.unit = "{unit}" is taken, though the file declares {declared}, in which '
            f"the bores would be {meant:.4g} mm apart, not {length:.4g} mm"
        )
    if file.unit is None and unit != declared:
        notes.append(
            f"{file.path.name}: the unit of length is taken to be {unit}, because in {declared}, which the "
            "file declares, the rod would have an unusual length (rod.unit)"
        )
    elif file.unit is None and not is_usual(length):
        number = length / DECLARED[unit]
        notes += [
            f"{file.path.name}: the bores are {length:.4g} mm apart, which is unusual for a rod; with "
            f'rod.unit = "{other}" they would be {number * UNITS[other]:.4g} mm apart'
            for other in list(usual_units(number))[:1]
        ]
    if any(solid.role is Role.ASSUMED_CAP for solid in read.solids):
        notes.append(CAP_ASSUMED)
    kept = [solid.text() for solid in read.solids if solid.kept]
    if len(kept) > 1 and bonded:
        notes.append(f"{', '.join(kept)}: bonded to each other where they touch")
    left = [each for each in read.solids if not each.kept and (bonded or each.role is not Role.BOLT)]
    if left and not file.solids:
        notes.append(f"left out of {file.path.name}: {_listed(left)} (rod.solids)")
    return notes


def _bonded(solids: Sequence[CadSolid], holes: Pair, tell: Callable[[str], None]) -> Solid:
    kept = [solid for solid in solids if solid.kept]
    _remove([solid.tag for solid in solids if not solid.kept])
    tags, names = [solid.tag for solid in kept], [solid.name for solid in kept] if len(kept) > 1 else [ROD]
    tell("looking for mirror planes")
    bores = placed(tags, *holes)
    mirror = smallest_cell(tags, bores[1].x)
    pieces = sharing(cut_to(tags, mirror, bores[1].x), names)
    return _solid(mirror, bores, parts_of(pieces, names, mirror))


def _assembled(
    solids: Sequence[CadSolid], holes: Pair, assembly: Assembly, tell: Callable[[str], None]
) -> tuple[Solid, tuple[str, ...], list[str]]:
    kept = [solid for solid in solids if solid.kept]
    loose = [solid for solid in solids if not solid.kept and solid.role in (Role.BOLT, Role.OTHER)]
    loose = [solid for solid in loose if max(solid.size) < _NEAR * holes[0].radius]
    _remove([solid.tag for solid in solids if not solid.kept and solid not in loose])
    bores = placed([solid.tag for solid in (*kept, *loose)], *holes)
    fasteners = removed([solid.tag for solid in loose])
    tell("dividing the assembly into its parts")
    volumes = named_parts(kept, bores, assembly)
    names = list(volumes)
    cells = dict(zip(names, sharing(list(volumes.values()), names), strict=True))
    joint = joint_of(cells[ROD], cells[CAP], bores[0].radius) if CAP in cells else None
    bolts, assumed = _bolts(cells, joint, fasteners, assembly, bores[0].radius)
    every = [tag for cell in cells.values() for tag in cell]
    mirror = smallest_cell(every, bores[1].x)
    cut = iter(cut_to(every, mirror, bores[1].x))
    pieces = [[tag for _ in cell for tag in next(cut)] for cell in cells.values()]
    disks = [(2, disk) for bolt in bolts for disk in seat_disks(bolt)]
    parts = parts_of(sharing(pieces, names, disks), names, mirror)
    solid = with_contacts(
        _solid(mirror, bores, parts, bolts), assembly, lambda touching: _walls(joint, touching, bores)
    )
    return solid, tuple(_listing(solid, joint)), assumed


def _listing(solid: Solid, joint: Joint | None) -> Iterator[str]:
    """Describe the joint, interfaces and bolts of an assembly."""
    if joint is not None:
        yield joint.text()
    for interface in solid.interfaces:
        first, second = (solid.parts[number].name for number in interface.parts)
        area = solid.mirror.copies * sum(gmsh.model.occ.getMass(2, face) for face in interface.faces)
        yield f"{first} and {second} touch over {area:.4g} mm²"
    for bolt in solid.bolts:
        end = (
            f"thread engaged over {bolt.engaged:.4g} mm in a hole of {2 * bolt.thread_radius:.4g} mm"
            if bolt.engaged
            else f"nut on {2 * bolt.nut_radius:.4g} mm"
        )
        yield (
            f"bolt through the joint at {place_text(np.array(bolt.point))} mm from the crank pin: hole of "
            f"{2 * bolt.hole_radius:.4g} mm, head on {2 * bolt.head_radius:.4g} mm, "
            f"grip {bolt.grip:.4g} mm, {end}"
        )


def _remove(volumes: Sequence[int]) -> None:
    """Remove volumes with what only they have: solids first, as the kernel seeks users of each entity."""
    gone, every = [(SOLID, tag) for tag in volumes], list[Entity]()
    while gone:
        every, above = every + gone, {tag for _, tag in gone}
        bounding = gmsh.model.getBoundary(gone, combined=False, oriented=False)
        gone = [
            each for each in dict.fromkeys(bounding) if above.issuperset(gmsh.model.getAdjacencies(*each)[0])
        ]
    gmsh.model.occ.remove(every)
    gmsh.model.occ.synchronize()


def _solid(
    mirror: Mirror, bores: tuple[Bore, Bore], parts: tuple[Part, ...], bolts: tuple[BoltAxis, ...] = ()
) -> Solid:
    volumes = [tag for part in parts for tag in part.volumes]
    faces = recognised_faces(volumes)
    named = with_seats(surfaces(bores, mirror, faces), faces, bolts)
    ends = (Surface.BIG_END_BORE, bores[0]), (Surface.SMALL_END_BORE, bores[1])
    features = [Feature(FeatureKind.BORE, named[at], bore.radius, 2 * math.pi) for at, bore in ends]
    features += concave_rounds([face for face in faces if face.tag in named[Surface.FREE]], bores[1].x)
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
    joint: Joint | None, touching: Sequence[PartInterface], bores: tuple[Bore, Bore]
) -> dict[Surface, float]:
    """Thickness of the ring at the joint, and of bushing and shells by their seats, mm."""
    walls = {}
    if joint is not None:
        walls[Surface.JOINT] = min(joint.area / (2 * bores[0].width), _RING * bores[0].radius)
    for surface, bore in ((Surface.SHELL_SEAT, bores[0]), (Surface.BUSHING_SEAT, bores[1])):
        faces = [face for interface in touching if interface.sides[0] is surface for face in interface.faces]
        shapes = [recognised(face_of(face)) for face in faces]
        radii = [face.values[6] for face in shapes if face.shape == "Cylinder"]
        if faces:
            walls[surface] = max(max(radii, default=1.05 * bore.radius) - bore.radius, 0.01 * bore.radius)
    return walls
