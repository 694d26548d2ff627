"""The parts that a rod is assembled from: dividing its solid, where they touch, and where its bolts press."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import gmsh
import numpy as np

from geometry import kernel
from geometry.arrays import Ints, linked_groups
from geometry.assembly import Assembly, BoltAxis
from geometry.errors import GeometryError
from geometry.faces import Face, Feature, FeatureKind, edge_points
from geometry.holes import Axis
from geometry.kernel import SOLID
from geometry.rod import Rod
from geometry.surfaces import Surface

Entity = tuple[int, int]
# In this order: of two that touch, the one named first has the first surface of their interface.
NAMES = ROD, CAP, BUSHING, UPPER_SHELL, LOWER_SHELL = "rod", "cap", "bushing", "upper shell", "lower shell"
_ABOVE, _SHELLS = (ROD, UPPER_SHELL), (UPPER_SHELL, LOWER_SHELL)


def parted(rod: Rod, bodies: dict[str, int], assembly: Assembly, bolts: Sequence[BoltAxis]) -> dict[str, int]:
    """Divide the bodies of a rod or its cell; borders of the seats of all `bolts` become edges."""
    normal = None if assembly.split is None else assembly.normal
    radius = rod.big_end_bore / 2 + assembly.shell if assembly.shell else None
    borders = [disk for bolt in bolts for disk in seat_disks(bolt)]
    return divided(bodies, normal, radius, 3 * (rod.length + rod.big_end_radius), borders)


def divided(
    bodies: dict[str, int],
    normal: tuple[float, float] | None,
    radius: float | None,
    far: float,
    borders: Sequence[int] = (),
) -> dict[str, int]:
    """Divide bodies at a joint plane through the big end's centre and at the backs of bearing shells.

    Returned are volume tags by part; parts share the faces where they touch. `normal` (x, y) of the plane
    leads to the rod, `radius`, mm, is that of the shells' backs, `far` a length beyond the rod. The edges of
    the faces `borders` become edges of the bodies' faces. Bodies and borders are used up. Raises
    `GeometryError`: the kernel failed, or a part would fall into pieces.
    """
    if normal is None and radius is None and not borders:
        return bodies
    tools: dict[str, Entity] = {}
    if normal is not None:
        box = gmsh.model.occ.addBox(-far, -far, -far, far, 2 * far, 2 * far)
        gmsh.model.occ.rotate([(SOLID, box)], 0, 0, 0, 0, 0, 1, math.atan2(normal[1], normal[0]))
        tools[CAP] = SOLID, box
    if radius is not None:
        # Its seam lies in the joint plane.
        core, (nx, ny) = gmsh.model.occ.addCylinder(0, 0, -far / 2, 0, 0, far, radius), normal or (1.0, 0.0)
        gmsh.model.occ.rotate([(SOLID, core)], 0, 0, 0, 0, 0, 1, math.atan2(ny, nx) + math.pi / 2)
        tools[UPPER_SHELL] = SOLID, core  # what is inside the backs of the shells
    solids = [(SOLID, tag) for tag in bodies.values()]
    with kernel.attempt("divide the rod into its parts"):
        _, pieces = gmsh.model.occ.fragment(solids, [*tools.values(), *((2, border) for border in borders)])
    parts = _named_pieces(dict(zip([*bodies, *tools], pieces, strict=False)))
    kept = {(SOLID, tag) for tag in parts.values()}
    remove_all({entity for piece in pieces for entity in piece} - kept)
    return parts


def remove_all(entities: Collection[Entity]) -> None:
    """Remove volumes and faces with what bounds them, as far as nothing else needs it."""
    occ = gmsh.model.occ
    occ.remove([entity for entity in sorted(entities) if entity[0] == SOLID], recursive=True)
    left = set(occ.getEntities(2))  # faces of the volumes are gone with them
    occ.remove(sorted(left.intersection(entities)), recursive=True)


def seat_disks(bolt: BoltAxis) -> list[int]:
    """Draw disks whose borders are those of the seats of a bolt."""
    levels = [(bolt.head, bolt.head_radius)]
    if bolt.engaged:
        levels += [(end, bolt.thread_radius) for end in (bolt.grip_end, bolt.thread_end)]
    else:
        levels += [(bolt.grip_end, bolt.nut_radius)]
    across = -bolt.direction[1], bolt.direction[0], 0.0  # the circles begin on the plane z = 0
    return [
        gmsh.model.occ.addDisk(*bolt.at(level), radius, radius, -1, list(bolt.direction), list(across))
        for level, radius in levels
    ]


def _named_pieces(became: dict[str, list[Entity]]) -> dict[str, int]:
    lower, core = (set(became.get(tool, ())) for tool in (CAP, UPPER_SHELL))
    pieces: dict[str, list[int]] = {}
    for piece in became[ROD]:
        below, above = (LOWER_SHELL, UPPER_SHELL) if piece in core else (CAP, ROD)
        pieces.setdefault(below if piece in lower else above, []).append(piece[1])
    if BUSHING in became:
        pieces[BUSHING] = [tag for _, tag in became[BUSHING]]
    for name, tags in pieces.items():
        if len(tags) != 1:
            what = f"the {name} would consist of {len(tags)} pieces"
            raise GeometryError(f"{what}. Change the split or the rod's dimensions")
    return {name: pieces[name][0] for name in NAMES if name in pieces}


@dataclass(frozen=True)
class PartInterface:
    """Faces at which two parts, given by their numbers, touch without being joined."""

    parts: tuple[int, int]
    sides: tuple[Surface, Surface]  #: the surfaces that the first's side and the second's are
    faces: tuple[int, ...]  #: gmsh's tags of the faces that they share


def interfaces(
    names: Sequence[str], volumes: Sequence[Sequence[int]], assembly: Assembly
) -> tuple[PartInterface, ...]:
    """Find the interfaces from the names and volumes of the parts; a bonded bushing has none."""
    bonded = set() if assembly.bushing else {BUSHING}
    owner = {volume: number for number, part in enumerate(volumes) for volume in part}
    shared: dict[frozenset[int], list[int]] = {}
    for _, face in gmsh.model.getEntities(2):
        owners = frozenset(owner[int(tag)] for tag in gmsh.model.getAdjacencies(2, face)[0])
        if len(owners) == 2 and not any(names[number] in bonded for number in owners):
            shared.setdefault(owners, []).append(face)
    rank = {name: place for place, name in enumerate(NAMES)}
    order = sorted(range(len(names)), key=lambda part: rank.get(names[part], len(rank)))
    touching = ((pair, _sides(*(names[part] for part in pair))) for pair in combinations(order, 2))
    return tuple(
        PartInterface(pair, sides, tuple(shared[frozenset(pair)]))
        for pair, sides in touching
        if sides is not None and frozenset(pair) in shared
    )


def _sides(first: str, second: str) -> tuple[Surface, Surface] | None:
    if second == BUSHING:
        return Surface.BUSHING_SEAT, Surface.BUSHING_BACK
    if second in _SHELLS and first not in _SHELLS:
        return Surface.SHELL_SEAT, Surface.SHELL_BACK
    joint = (first in _ABOVE) != (second in _ABOVE)
    return (Surface.JOINT, Surface.JOINT_CAP) if joint else None


def boundary(volumes: Iterable[int]) -> set[int]:
    """Tags of the faces of each volume, also of those between them."""
    entities = [(SOLID, tag) for tag in volumes]
    return {tag for _, tag in gmsh.model.getBoundary(entities, combined=False, oriented=False)}


def joined_groups(volumes: Sequence[Sequence[int]], apart: Sequence[PartInterface] = ()) -> Ints:
    """Number (n_parts,) of the group of each part that shares faces with the others, but for interfaces."""
    separate = {frozenset(interface.parts) for interface in apart}
    faces = [boundary(part) for part in volumes]
    joined = [
        pair
        for pair in combinations(range(len(volumes)), 2)
        if faces[pair[0]] & faces[pair[1]] and frozenset(pair) not in separate
    ]
    return linked_groups(len(volumes), *np.reshape(joined, (-1, 2)).astype(np.int64).T)


def bodies(volumes: Sequence[Sequence[int]], apart: Sequence[PartInterface]) -> list[list[int]]:
    """Volumes of joined parts; empty if all are. Those that share faces are joined, but for interfaces."""
    if not apart:
        return []
    body = joined_groups(volumes, apart)
    members = [np.flatnonzero(body == number).tolist() for number in range(body.max() + 1)]
    members.sort(key=max)
    return [[tag for number in parts for tag in volumes[number]] for parts in members]


# Of the hole's radius: planes and cylinders of CAD programs are not exact.
_SLACK = 1e-4


def with_seats(
    named: Mapping[Surface, tuple[int, ...]], faces: Iterable[Face], bolts: Sequence[BoltAxis]
) -> dict[Surface, tuple[int, ...]]:
    """Name the faces that bolts press on, which are free so far."""
    free = set(named.get(Surface.FREE, ()))
    surface_of: dict[int, Surface] = {}
    for face in faces:
        if face.tag in free:
            seats = (_seat(face, bolt) for bolt in bolts)
            if (surface := next(filter(None, seats), None)) is not None:
                surface_of[face.tag] = surface
    rest = {surface: tuple(tag for tag in tags if tag not in surface_of) for surface, tags in named.items()}
    seated = set(surface_of.values())
    return rest | {
        surface: tuple(tag for tag, seated_on in surface_of.items() if seated_on is surface)
        for surface in Surface
        if surface in seated
    }


def _seat(face: Face, bolt: BoltAxis) -> Surface | None:
    slack = _SLACK * bolt.hole_radius
    axis = Axis(center=np.array(bolt.point), direction=np.array(bolt.direction))
    points = edge_points(face.tag)
    along, beside = axis.along(points), axis.beside(points)
    if face.shape == "Plane":
        seats = [(Surface.BOLT_HEAD, bolt.head, bolt.head_radius)]
        seats += [(Surface.BOLT_THREAD, bolt.grip_end, bolt.nut_radius)]
        for surface, level, radius in seats:
            if np.abs(along - level).max() < slack and beside.max() < radius + slack:
                return surface
    elif bolt.engaged and face.shape == "Cylinder" and beside.max() < bolt.thread_radius + slack:
        inside = bolt.thread_end - slack < along.min() and along.max() < bolt.grip_end + slack
        return Surface.BOLT_THREAD if inside else None
    return None


def contact_features(
    touching: Sequence[PartInterface],
    named: Mapping[Surface, tuple[int, ...]],
    bolts: Sequence[BoltAxis],
    thickness: Mapping[Surface, float],
) -> tuple[Feature, ...]:
    """Return the faces between parts and under bolts, which need small elements.

    `thickness`, mm, is by the first surface of an interface: of the ring at the joint, of bushing and shells.
    """
    features = []
    for side, faces in ((interface.sides[0], interface.faces) for interface in touching):
        if side is Surface.JOINT:
            features.append(Feature(FeatureKind.JOINT, faces, thickness=thickness[side]))
        else:
            radius = float(gmsh.model.getEntityProperties(2, faces[0])[1][6])
            features.append(Feature(FeatureKind.FIT, faces, radius, 2 * math.pi, thickness[side]))
    seats = {
        Surface.BOLT_HEAD: [bolt.head_radius for bolt in bolts],
        Surface.BOLT_THREAD: [bolt.nut_radius or bolt.thread_radius for bolt in bolts],
    }
    for surface, radii in seats.items():
        if named.get(surface):
            features.append(Feature(FeatureKind.BOLT_SEAT, named[surface], min(radii), 2 * math.pi))
    return tuple(features)
