"""The cylindrical walls of a solid, told to be hollow only as far as it matters."""

from collections.abc import Iterator
from dataclasses import dataclass

from geometry.cad.cylinders import recognised
from geometry.cad.holes import Hole, hollow_wall, wall_groups
from geometry.cad.interior import Interior
from geometry.faces import faces_of


@dataclass(frozen=True)
class Walls:
    """Cylindrical walls of a solid.

    Of a solid with a thousand faces, the kernel takes a minute to tell which are hollow.

    Attributes
    ----------
    interior
        Of the solid.
    groups
        Walls with the same axis, those with the largest radius first.
    """

    interior: Interior
    groups: tuple[tuple[Hole, ...], ...]

    def hollow(self) -> Iterator[Hole]:
        """Find the hollow walls, one per axis, the largest radius first."""
        found: list[Hole] = []
        for group in self.groups:
            least = max(wall.radius for wall in group)
            while found and found[0].radius >= least:
                yield found.pop(0)
            wall = hollow_wall(self.interior, group)
            found = sorted([*found, *([] if wall is None else [wall])], key=lambda wall: -wall.radius)
        yield from found

    def about(self, bore: Hole, slack: float) -> Iterator[Hole]:
        """Find the hollow wall on the axis of a bore, up to a distance relative to the bore's radius."""
        for group in self.groups:
            if group[0].parallel(bore) and group[0].apart(bore) < slack * bore.radius:
                wall = hollow_wall(self.interior, group)
                yield from () if wall is None else (wall,)


def walls_of(volume: int) -> Walls:
    """Return the walls of a volume of the open model."""
    groups = wall_groups([recognised(face) for face in faces_of((volume,))])
    groups.sort(key=lambda group: -max(wall.radius for wall in group))
    return Walls(Interior((volume,)), tuple(map(tuple, groups)))
