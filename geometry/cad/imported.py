"""A rod from a CAD file, placed and cut in the same way as one drawn from dimensions."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Floats
from geometry.assembly import Assembly
from geometry.cad.assembled import assembled
from geometry.cad.bores import HalfOpenError, find_bores
from geometry.cad.cylinders import recognised
from geometry.cad.file import CadFile, MissingCap
from geometry.cad.formats import declared_unit, read_solids
from geometry.cad.freecad import linked_files
from geometry.cad.holes import Hole, Interior
from geometry.cad.joining import joined_parts
from geometry.cad.joint import assumed_cap
from geometry.cad.members import member, members
from geometry.cad.rounds import concave_rounds
from geometry.cad.symmetry import cut_to, placed, smallest_cell
from geometry.errors import GeometryError
from geometry.faces import Face, Feature, FeatureKind, faces_of, surfaces
from geometry.intake import (
    DECLARED,
    UNITS,
    FoundBore,
    Intake,
    Member,
    Role,
    is_usual,
    plausible_unit,
    usual_units,
)
from geometry.mass import joined
from geometry.solid import Solid
from geometry.surfaces import Mirror, Surface


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
        `geometry.parting`; touching parts share their faces.

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
    bores = tuple(FoundBore(2 * hole.radius, _vector(hole.center), hole.mean_width) for hole in holes)
    said = _assumed(file, declared, unit, found, holes[0].apart(holes[1]), bonded=assembly is None)
    if assembly is None:
        solid = _cut(file, found, holes, mirror, tell)
        return replace(solid, intake=Intake(unit, tuple(found), (bores[0], bores[1]), tuple(said)))
    solid, text, more = assembled(file, found, holes, assembly, mirror=mirror, tell=tell)
    return replace(solid, intake=Intake(unit, tuple(found), (bores[0], bores[1]), (*said, *more), text))


def _found(file: CadFile, unit: str, tell: Callable[[str], None]) -> tuple[list[Member], tuple[Hole, Hole]]:
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


def _capped_first(bores: tuple[Hole, Hole], found: Sequence[Member]) -> tuple[Hole, Hole]:
    """Take the bore with the cap for the big end's, if it is the smaller one."""
    caps = [gmsh.model.occ.getCenterOfMass(3, one.tag) for one in found if one.role is Role.CAP and one.kept]
    if caps:
        middle = np.mean(caps, axis=0)
        big, small = (float(np.linalg.norm(middle - bore.center)) for bore in bores)
        if small < big:
            return bores[::-1]
    return bores


def _faces(volumes: Sequence[int]) -> list[Face]:
    return [recognised(face) for face in faces_of(volumes)]


def _assumed(
    file: CadFile, declared: str, unit: str, found: Sequence[Member], length: float, *, bonded: bool
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
    found: Sequence[Member],
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
