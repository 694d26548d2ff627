"""Mating faces: where two separate parts touch.

Both sides have matching facets, so that the pressures at the vertices of one side act on both, and their
moments are those of the gap between the sides. Friction acts along two tangents of the face.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse

from fea.contact.multipliers import Direction, Multipliers
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import FACET_TURN, TetMesh


@dataclass(frozen=True)
class MatingFaces:
    """The two sides of an interface on the cell.

    The unknowns are the pressures at the vertices, then, with friction, the shear stresses along the first
    tangent and along the second one. Positive, they push the first side along the direction and the second
    side against it.

    Attributes
    ----------
    name
        Of the interface.
    pressing
        The pressures on the first side.
    opposite
        The surface of the second side, and (n_facets, n_facet_nodes) its facets in the order of the first.
    tangents
        Directions of friction: the second one reverses under reflection about y = 0, the first one does not.
    along, around
        (m,) vertices with shear stress along either tangent; none without friction.
    interference
        By how much the parts overlap before they are put together, normal to the face, mm.
    """

    name: str
    pressing: Multipliers
    opposite: tuple[Surface, Ints]
    tangents: tuple[Direction, Direction]
    along: Ints
    around: Ints
    interference: float = 0.0

    @classmethod
    def of(
        cls,
        mesh: TetMesh,
        sides: tuple[Surface, Surface],
        direction: Direction,
        *,
        interference: float = 0.0,
        friction: bool = True,
    ) -> "MatingFaces":
        """Set up the faces of an interface of a cell, whose tangents are z and the one square to it.

        Parameters
        ----------
        mesh
            The cell, with both sides as `mesh.separate.separated` leaves them.
        sides
            Their surfaces.
        direction
            In which a pressure pushes the first side; square to z.
        interference
            mm.
        friction
            Whether there is any.
        """
        first, second = sides
        pressing = Multipliers.of(mesh, first, direction)
        every = np.arange(pressing.size) if friction else np.zeros(0, dtype=np.int64)
        # The shear stress along z of a field that is symmetric about z = 0 vanishes there.
        free = ~np.isin(pressing.nodes, mesh.facets.get(Surface.SYMMETRY_Z, ()))
        facets = mesh.facets[second]
        return cls(
            name=str(first),
            pressing=pressing,
            opposite=(second, facets[:, FACET_TURN[facets.shape[1]]]),
            tangents=(_along_z, _square_to(direction)),
            along=every[free[every]],
            around=every,
            interference=interference,
        )

    @property
    def size(self) -> int:
        """Number of unknowns on the cell."""
        return self.pressing.size + len(self.along) + len(self.around)

    @property
    def on_y(self) -> Mask:
        """Which unknowns (size,) are at places on y = 0."""
        own = self.pressing.on_y
        return np.concatenate([own, own[self.along], own[self.around]])

    @property
    def across(self) -> Mask:
        """Which unknowns (size,) reverse under reflection about y = 0 where they lie on it."""
        return np.arange(self.size) >= self.pressing.size + len(self.along)

    @property
    def tangential(self) -> tuple[Ints, Ints]:
        """Per vertex (m,) the numbers of its shear stresses among the unknowns; −1 where it has none."""
        found = []
        start = self.pressing.size
        for own in (self.along, self.around):
            number = np.full(self.pressing.size, -1)
            number[own] = start + np.arange(len(own))
            found.append(number)
            start += len(own)
        return found[0], found[1]

    @cached_property
    def _sides(self) -> tuple[tuple[Multipliers, Ints | None], ...]:
        """Multipliers of each kind of unknown, and the vertices that have it."""
        along, around = (replace(self.pressing, direction=tangent) for tangent in self.tangents)
        return (self.pressing, None), (along, self.along), (around, self.around)

    @cached_property
    def _second(self) -> Multipliers:
        """Multipliers of the pressure on the second side."""
        return replace(self.pressing, facets=self.opposite[1])

    def forces(self, n_nodes: int) -> sparse.csr_array:
        """Nodal forces (3 n_nodes, size) of unit stresses, N."""
        columns = []
        for own, vertices in self._sides:
            first = own.forces(n_nodes)
            both = first - replace(own, facets=self.opposite[1]).forces(n_nodes)
            columns.append(both if vertices is None else both[:, vertices])
        return sparse.csr_array(sparse.hstack(columns))

    def initial(self) -> Floats:
        """Moments (size,) of the gap between the parts as made."""
        found = np.zeros(self.size)
        found[: self.pressing.size] = -self.interference * self.pressing.weights
        return found

    def traction(self, values: Floats, points: Floats) -> dict[Surface, Floats]:
        """Traction (n_nodes, 3, k) on each side of stresses (size, k), MPa."""
        kinds = []
        for (_, vertices), direction in zip(
            self._sides, (self.pressing.direction, *self.tangents), strict=True
        ):
            count = self.pressing.size if vertices is None else len(vertices)
            own, values = values[:count], values[count:]
            every = np.zeros((self.pressing.size, own.shape[1]))
            every[slice(None) if vertices is None else vertices] = own
            kinds.append((every, direction))
        found = {}
        for surface, side, sign in (
            (self.pressing.surface, self.pressing, 1.0),
            (self.opposite[0], self._second, -1.0),
        ):
            traction = np.zeros((len(points), 3, values.shape[1]))
            for every, direction in kinds:
                nodes, stress = side.at_nodes(every)
                traction[nodes] += sign * stress[:, None] * direction(points[nodes])[..., None]
            found[surface] = traction
        return found


def _along_z(places: Floats) -> Floats:
    return np.broadcast_to([0.0, 0.0, 1.0], places.shape)


def _square_to(direction: Direction) -> Direction:
    """Direction square to z and to another one."""

    def around(places: Floats) -> Floats:
        return np.cross([0.0, 0.0, 1.0], direction(places))

    return around
