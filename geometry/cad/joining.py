"""Imported solids that touch, made to share the faces where they do."""

from collections.abc import Sequence

import gmsh

from geometry import kernel
from geometry.errors import GeometryError
from geometry.mass import joined
from geometry.parting import remove_all
from geometry.solid import Part, whole_mass
from geometry.surfaces import Mirror

Entity = tuple[int, int]


def joined_parts(cells: Sequence[Sequence[int]], names: Sequence[str], mirror: Mirror) -> tuple[Part, ...]:
    """Let touching solids share their faces, and compute the mass properties of each.

    Parameters
    ----------
    cells
        Volume tags that each solid became in the mirror cell.
    names
        Of the solids.
    mirror
        The cell.

    Raises
    ------
    GeometryError
        Solids overlap, or one touches no other.
    """
    return parts_of(sharing(cells, names), names, mirror)


def parts_of(cells: Sequence[Sequence[int]], names: Sequence[str], mirror: Mirror) -> tuple[Part, ...]:
    """Name the volumes of each part and compute its mass properties."""
    return tuple(
        Part(name, tuple(cell), joined([whole_mass(tag, mirror) for tag in cell]))
        for name, cell in zip(_distinct(names), cells, strict=True)
    )


def sharing(
    cells: Sequence[Sequence[int]], names: Sequence[str], borders: Sequence[Entity] = ()
) -> list[list[int]]:
    """Let touching solids share their faces; return the volumes that each became.

    Parameters
    ----------
    cells, names
        As for `joined_parts`, which says what is raised.
    borders
        Faces whose edges become edges of the solids' faces; they are used up.
    """
    volumes = [list(cell) for cell in cells]
    if sum(map(len, volumes)) > 1 or borders:
        every = [(kernel.SOLID, tag) for cell in volumes for tag in cell]
        with kernel.attempt("join the parts at their common faces"):
            _, pieces = gmsh.model.occ.fragment(every, list(borders))
        own = pieces[: len(every)]
        became = {entity[1]: [tag for _, tag in made] for entity, made in zip(every, own, strict=True)}
        volumes = [[piece for tag in cell for piece in became[tag]] for cell in volumes]
        every_piece = [piece for cell in volumes for piece in cell]
        if len(set(every_piece)) < len(every_piece):
            raise GeometryError(
                f"the solids {', '.join(names)} overlap; they may only touch. Correct them in the CAD "
                "program, or keep only some of them with rod.solids"
            )
        remove_all({piece for made in pieces[len(every) :] for piece in made})
    gmsh.model.occ.synchronize()
    _require_joined(volumes, names)
    return volumes


def _require_joined(cells: Sequence[Sequence[int]], names: Sequence[str]) -> None:
    """Refuse parts that share no face with the others: they would be loose."""
    faces = [
        set(gmsh.model.getBoundary([(kernel.SOLID, tag) for tag in cell], combined=False, oriented=False))
        for cell in cells
    ]
    joined, loose = [0], list(range(1, len(cells)))
    while touching := [one for one in loose if any(faces[one] & faces[other] for other in joined)]:
        joined += touching
        loose = [one for one in loose if one not in touching]
    if loose:
        gap, one, other = min(
            (gmsh.model.occ.getDistance(kernel.SOLID, a, kernel.SOLID, b)[0], one, other)
            for one in loose
            for other in joined
            for a in cells[one]
            for b in cells[other]
        )
        raise GeometryError(
            f"the solids {names[one]} and {names[other]} do not touch (gap {gap:.3g} mm), so they cannot be "
            "bonded to each other. Close the gap in the CAD program, or keep only solids that touch with "
            "rod.solids"
        )


def _distinct(names: Sequence[str]) -> list[str]:
    """Number the names that occur more than once."""
    return [
        name if names.count(name) == 1 else f"{name} {names[:place].count(name) + 1}"
        for place, name in enumerate(names)
    ]
