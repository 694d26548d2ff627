"""Which solids of a file are the rod and what belongs to it, and which are left out."""

from collections.abc import Collection, Mapping, Sequence

import gmsh
import numpy as np

from geometry.arrays import Floats
from geometry.cad.cylinders import recognised
from geometry.cad.edges import solid_points
from geometry.cad.formats import NamedSolid
from geometry.cad.holes import CLOSED, Hole, hollow_walls
from geometry.cad.interior import Interior
from geometry.errors import GeometryError
from geometry.faces import faces_of
from geometry.intake import Member, Role

# A rod's distance of the bores is at least this part of its length, and its width along the pins and its
# breadth at most these: 0.6 to 0.8, 0.1 to 0.4 and 0.3 to 0.6 on rods.
_REACH, _WIDTH, _BREADTH = 0.4, 0.8, 1.1
# Its centre of gravity lies beside the line between the bores by less than this part of their distance.
_ASIDE = 0.2
# Two bores, or two rods, of the same size differ by less, relatively.
_ALIKE = 0.02
# A bushing or shell is at most this much longer than the bore; a pin is longer.
_OVERHANG = 1.25


def member(tag: int, name: str, role: Role, *, kept: bool = True) -> Member:
    """Measure a solid of the open model."""
    box = np.reshape(gmsh.model.getBoundingBox(3, tag), (2, 3))
    x, y, z = np.ptp(box, axis=0).tolist()
    return Member(tag, name, role, kept, float(gmsh.model.occ.getMass(3, tag)), (x, y, z))


def members(solids: Sequence[NamedSolid], chosen: Sequence[str] = ()) -> list[Member]:
    """Tell the solids of a file apart.

    Parameters
    ----------
    solids
        Of the open model.
    chosen
        Names of those to keep; empty: the rod and what belongs to it, or all of them if none is a rod.

    Raises
    ------
    GeometryError
        Several different rods, or a name that the file does not have.
    """
    if len(solids) == 1:
        return [member(solids[0].tag, "rod", Role.ROD)]
    names = {solid.tag: solid.name or f"part {number}" for number, solid in enumerate(solids, 1)}
    walls = {tag: _walls(tag) for tag in names}
    rods = {tag: bores for tag in names if (bores := _rod_bores(tag, walls[tag])) is not None}
    if chosen:
        _require_known(chosen, names.values())
        rods = {tag: bores for tag, bores in rods.items() if names[tag] in chosen}
    if not rods:
        return [
            member(tag, name, Role.OTHER, kept=not chosen or name in chosen) for tag, name in names.items()
        ]
    rod = _only_rod(rods, names)
    roles = {tag: Role.ROD if tag == rod else _role(tag, walls[tag], rods[rod]) for tag in names}
    kept = {tag for tag, role in roles.items() if role in (Role.ROD, Role.CAP, Role.BUSHING)}
    if chosen:
        kept = {tag for tag, name in names.items() if name in chosen}
    return [member(tag, name, roles[tag], kept=tag in kept) for tag, name in names.items()]


def _require_known(chosen: Sequence[str], names: Collection[str]) -> None:
    for name in chosen:
        if name not in names:
            listed = ", ".join(dict.fromkeys(names))
            raise GeometryError(f"rod.solids names {name!r}, but the solids of the file are: {listed}")


def _walls(volume: int) -> list[Hole]:
    return hollow_walls(Interior((volume,)), [recognised(face) for face in faces_of((volume,))])


def _rod_bores(volume: int, walls: Sequence[Hole]) -> tuple[Hole, Hole] | None:
    """The bores of a solid of a rod's shape: its largest hollow wall, and the next one parallel to it."""
    for small in walls[1:]:
        big = walls[0]
        if big.parallel(small) and big.apart(small) > big.radius + small.radius:
            return (big, small) if _is_rod(volume, big, small) else None
    return None


def _is_rod(volume: int, big: Hole, small: Hole) -> bool:
    """Whether the proportions are those of a rod."""
    distance, frame = big.apart(small), _frame(big, small)
    length, breadth, width = np.ptp(solid_points(volume) @ frame.T, axis=0)
    middle = np.array(gmsh.model.occ.getCenterOfMass(3, volume)) - big.center
    along, aside, _ = frame @ middle
    return bool(
        distance >= _REACH * length
        and width <= _WIDTH * distance
        and breadth <= _BREADTH * length
        and -_ASIDE * distance <= along <= (1 + _ASIDE) * distance
        and abs(aside) <= _ASIDE * distance
    )


def _frame(big: Hole, small: Hole) -> Floats:
    """Unit vectors (3, 3) along the rod, across it and along its pins, as rows."""
    z = big.direction
    between = small.center - big.center
    x = between - (between @ z) * z
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])


def _only_rod(rods: Mapping[int, tuple[Hole, Hole]], names: Mapping[int, str]) -> int:
    """The first of the rods, if all have bores of the same size."""
    sizes = np.array([(big.radius, small.radius, big.apart(small)) for big, small in rods.values()])
    if (np.abs(sizes / sizes[0] - 1) > _ALIKE).any():
        listed = "; ".join(
            f"{names[tag]} (bores of {2 * big.radius:.4g} and {2 * small.radius:.4g} mm, "
            f"{big.apart(small):.4g} mm apart)"
            for tag, (big, small) in rods.items()
        )
        raise GeometryError(f"several solids of the file could be the rod: {listed}. Choose with rod.solids")
    return next(iter(rods))


def _role(volume: int, walls: Sequence[Hole], bores: tuple[Hole, Hole]) -> Role:
    """What a solid is beside a rod with these bores."""
    points = solid_points(volume)
    for bore in bores:
        away = points - bore.center
        height = away @ bore.direction
        radius = np.linalg.norm(away - height[:, None] * bore.direction, axis=1)
        coaxial = [wall for wall in walls if wall.parallel(bore) and wall.apart(bore) < _ALIKE * bore.radius]
        if radius.max() <= (1 + _ALIKE) * bore.radius and np.abs(height).min() <= bore.width / 2:
            return Role.BUSHING if coaxial and np.ptp(height) <= _OVERHANG * bore.width else Role.PIN
        alike = any(abs(wall.radius / bore.radius - 1) < _ALIKE for wall in coaxial)
        if bore.turn <= CLOSED and alike:
            return Role.CAP
    size, reach = np.ptp(points, axis=0).max(), bores[0].apart(bores[1])
    near = np.linalg.norm(points.mean(axis=0) - bores[0].center) < 2.5 * bores[0].radius
    return Role.BOLT if near and size < 0.8 * reach and _is_slender(volume) else Role.OTHER


def _is_slender(volume: int) -> bool:
    """Whether the largest moment of inertia is more than three times the least."""
    moments = np.linalg.eigvalsh(np.reshape(gmsh.model.occ.getMatrixOfInertia(3, volume), (3, 3)))
    return bool(moments[-1] > 3 * moments[0])
