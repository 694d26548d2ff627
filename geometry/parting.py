"""The solid of a rod divided into the parts that it is assembled from, with the seats of its bolts."""

import math
from collections.abc import Collection, Sequence

import gmsh

from geometry import kernel
from geometry.assembly import Assembly, BoltAxis
from geometry.errors import GeometryError
from geometry.rod import Rod

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
