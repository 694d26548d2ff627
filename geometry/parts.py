"""The solid of a rod divided into the parts that it is assembled from, with the seats of its bolts."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import gmsh
import numpy as np

from geometry import kernel
from geometry.assembly import Assembly, BoltAxis
from geometry.cad.cylinders import edge_points
from geometry.errors import GeometryError
from geometry.faces import Face, Feature, FeatureKind
from geometry.rod import Rod
from geometry.surfaces import Surface

Entity = tuple[int, int]
ROD, CAP, BUSHING, UPPER_SHELL, LOWER_SHELL = "rod", "cap", "bushing", "upper shell", "lower shell"


def parted(rod: Rod, bodies: dict[str, int], assembly: Assembly, bolts: Sequence[BoltAxis]) -> dict[str, int]:
    """Divide the drawn bodies of a rod given by dimensions, or of a cell of it.

    Parameters
    ----------
    rod
        Its dimensions.
    bodies
        Volume tags of ``"rod"`` and, if there is one, ``"bushing"``; they are used up.
    assembly
        What is separate.
    bolts
        Of the whole rod; the borders of their seats become edges of the faces that they press on.

    Returns
    -------
    dict
        Volume tags by the names of the parts, which share the faces where they touch.

    Raises
    ------
    GeometryError
        The kernel failed, or a part would fall into pieces.
    """
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

    Parameters
    ----------
    bodies
        As for `parted`, which says what is returned and raised.
    normal
        Of the joint plane (x, y), towards the rod; None without one.
    radius
        Of the shells' backs, mm; None without shells.
    far
        A length beyond the rod, mm.
    borders
        Faces whose edges become edges of the bodies' faces; they are used up.
    """
    if normal is None and radius is None and not borders:
        return bodies
    tools: dict[str, Entity] = {}
    if normal is not None:
        tools[CAP] = _half_space(normal, far)
    if radius is not None:
        tools[UPPER_SHELL] = _core(radius, far, normal or (1.0, 0.0))
    solids = [(kernel.SOLID, tag) for tag in bodies.values()]
    with kernel.attempt("divide the rod into its parts"):
        _, pieces = gmsh.model.occ.fragment(solids, [*tools.values(), *((2, border) for border in borders)])
    became = dict(zip([*bodies, *tools], pieces, strict=False))
    parts = _sorted(became)
    kept = {(kernel.SOLID, tag) for tag in parts.values()}
    remove_all({piece for made in pieces for piece in made} - kept)
    return parts


def remove_all(entities: Collection[Entity]) -> None:
    """Remove volumes and faces with what bounds them, as far as nothing else needs it."""
    occ = gmsh.model.occ
    occ.remove([entity for entity in sorted(entities) if entity[0] == kernel.SOLID], recursive=True)
    left = set(occ.getEntities(2))  # faces of the volumes are gone with them
    occ.remove(sorted(left.intersection(entities)), recursive=True)


def seat_disks(bolt: BoltAxis) -> list[int]:
    """Draw disks whose borders are those of what a bolt presses on."""
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


def _half_space(normal: tuple[float, float], far: float) -> Entity:
    """Draw all that lies on the cap's side of the joint plane."""
    box = gmsh.model.occ.addBox(-far, -far, -far, far, 2 * far, 2 * far)
    gmsh.model.occ.rotate([(kernel.SOLID, box)], 0, 0, 0, 0, 0, 1, math.atan2(normal[1], normal[0]))
    return kernel.SOLID, box


def _core(radius: float, far: float, normal: tuple[float, float]) -> Entity:
    """Draw the cylinder inside the backs of the shells, with its seam in the joint plane."""
    core = gmsh.model.occ.addCylinder(0, 0, -far / 2, 0, 0, far, radius)
    turn = math.atan2(normal[1], normal[0]) + math.pi / 2
    gmsh.model.occ.rotate([(kernel.SOLID, core)], 0, 0, 0, 0, 0, 1, turn)
    return kernel.SOLID, core


def _sorted(became: dict[str, list[Entity]]) -> dict[str, int]:
    """Name the pieces of the rod by the tools that they lie in."""
    lower, core = (set(became.get(tool, ())) for tool in (CAP, UPPER_SHELL))
    found: dict[str, list[int]] = {}
    for piece in became[ROD]:
        shell = piece in core
        below = LOWER_SHELL if shell else CAP
        above = UPPER_SHELL if shell else ROD
        found.setdefault(below if piece in lower else above, []).append(piece[1])
    if BUSHING in became:
        found[BUSHING] = [tag for _, tag in became[BUSHING]]
    for name, tags in found.items():
        if len(tags) != 1:
            raise GeometryError(
                f"the {name} would consist of {len(tags)} pieces. Change the split or the rod's dimensions"
            )
    order = [name for name in (ROD, CAP, BUSHING, UPPER_SHELL, LOWER_SHELL) if name in found]
    return {name: found[name][0] for name in order}


_ABOVE, _SHELLS = (ROD, UPPER_SHELL), (UPPER_SHELL, LOWER_SHELL)
# Of the hole's radius: planes and cylinders of CAD programs are not exact.
_SLACK = 1e-4


@dataclass(frozen=True)
class Interface:
    """Where two parts touch without being joined.

    Attributes
    ----------
    parts
        Numbers of the two.
    sides
        The surfaces that the first's side and the second's are.
    faces
        gmsh's tags of the faces that they share.
    """

    parts: tuple[int, int]
    sides: tuple[Surface, Surface]
    faces: tuple[int, ...]


def interfaces(
    names: Sequence[str], volumes: Sequence[Sequence[int]], assembly: Assembly
) -> tuple[Interface, ...]:
    """Find them from the names and volumes of the parts; a bonded bushing has none."""
    touching = {
        frozenset(pair): sides
        for pair in _pairs(names)
        if (sides := _sides(names[pair[0]], names[pair[1]])) is not None
    }
    bonded = {} if assembly.bushing else {BUSHING}
    owner = {volume: number for number, part in enumerate(volumes) for volume in part}
    shared: dict[frozenset[int], list[int]] = {}
    for _, face in gmsh.model.getEntities(2):
        owners = frozenset(owner[int(tag)] for tag in gmsh.model.getAdjacencies(2, face)[0])
        if len(owners) == 2 and not any(names[number] in bonded for number in owners):
            shared.setdefault(owners, []).append(face)
    return tuple(
        Interface((one, other), touching[frozenset((one, other))], tuple(shared[frozenset((one, other))]))
        for one, other in _pairs(names)
        if frozenset((one, other)) in shared and frozenset((one, other)) in touching
    )


def bodies(volumes: Sequence[Sequence[int]], found: Sequence[Interface]) -> list[list[int]]:
    """Volumes of the parts that are joined to each other; empty if all are.

    Parts that share faces are joined, unless an interface lies between them.
    """
    if not found:
        return []
    apart = {frozenset(interface.parts) for interface in found}
    faces = [
        set(gmsh.model.getBoundary([(3, tag) for tag in part], combined=False, oriented=False))
        for part in volumes
    ]
    groups: list[set[int]] = []
    for number, own in enumerate(faces):
        joined = [
            group
            for group in groups
            if any(own & faces[other] and frozenset((number, other)) not in apart for other in group)
        ]
        groups = [group for group in groups if group not in joined] + [{number}.union(*joined)]
    return [[tag for number in sorted(group) for tag in volumes[number]] for group in groups]


def _pairs(names: Sequence[str]) -> list[tuple[int, int]]:
    """Numbers of two parts each, that of the surface named first in an interface first."""
    rank = {ROD: 0, CAP: 1, BUSHING: 2, UPPER_SHELL: 3, LOWER_SHELL: 4}
    order = sorted(range(len(names)), key=lambda number: rank.get(names[number], len(rank)))
    return [(one, other) for place, one in enumerate(order) for other in order[place + 1 :]]


def _sides(one: str, other: str) -> tuple[Surface, Surface] | None:
    """Surfaces of two parts, in the order of `_pairs`, that touch."""
    if other == BUSHING:
        return Surface.BUSHING_SEAT, Surface.BUSHING_BACK
    if other in _SHELLS and one not in _SHELLS:
        return Surface.SHELL_SEAT, Surface.SHELL_BACK
    joint = (one in _ABOVE) != (other in _ABOVE)
    return (Surface.JOINT, Surface.JOINT_CAP) if joint else None


def with_seats(
    named: Mapping[Surface, tuple[int, ...]], faces: Iterable[Face], bolts: Sequence[BoltAxis]
) -> dict[Surface, tuple[int, ...]]:
    """Name the faces that bolts press on, which are free so far."""
    free = set(named.get(Surface.FREE, ()))
    found: dict[int, Surface] = {}
    for face in faces:
        if face.tag in free:
            seats = (_seat(face, bolt) for bolt in bolts)
            if (surface := next(filter(None, seats), None)) is not None:
                found[face.tag] = surface
    tags = {surface: tuple(tag for tag in found if found[tag] is surface) for surface in set(found.values())}
    rest = {surface: tuple(tag for tag in every if tag not in found) for surface, every in named.items()}
    return rest | {surface: tags[surface] for surface in Surface if surface in tags}


def _seat(face: Face, bolt: BoltAxis) -> Surface | None:
    """What of a bolt presses on a face."""
    slack = _SLACK * bolt.hole_radius
    away = edge_points(face.tag) - np.array(bolt.point)
    along = away @ np.array(bolt.direction)
    beside = np.linalg.norm(away - along[:, None] * np.array(bolt.direction), axis=1)
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
    found: Sequence[Interface],
    named: Mapping[Surface, tuple[int, ...]],
    bolts: Sequence[BoltAxis],
    thickness: Mapping[Surface, float],
) -> tuple[Feature, ...]:
    """Return the faces between parts and under bolts, which need small elements.

    Parameters
    ----------
    found, named, bolts
        Interfaces, faces by their surfaces, and bolts.
    thickness
        By the first surface of an interface, mm: of the ring at the joint, of the bushing, of the shells.
    """
    made = [_feature(interface, thickness[interface.sides[0]]) for interface in found]
    seats = {
        Surface.BOLT_HEAD: [bolt.head_radius for bolt in bolts],
        Surface.BOLT_THREAD: [bolt.nut_radius or bolt.thread_radius for bolt in bolts],
    }
    for surface, radii in seats.items():
        if named.get(surface):
            made.append(Feature(FeatureKind.BOLT_SEAT, named[surface], min(radii), 2 * math.pi))
    return tuple(made)


def _feature(interface: Interface, thickness: float) -> Feature:
    if interface.sides[0] is Surface.JOINT:
        return Feature(FeatureKind.JOINT, interface.faces, thickness=thickness)
    radius = gmsh.model.getEntityProperties(2, interface.faces[0])[1][6]
    return Feature(FeatureKind.FIT, interface.faces, float(radius), 2 * math.pi, thickness)
