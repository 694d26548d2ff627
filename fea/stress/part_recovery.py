"""Nodal stress of a rod with several parts: separate for each part, as stress jumps between materials."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fea.material import Material
from fea.solid.parity import Parity
from fea.stress.recovery import Recovery
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from mesh.parts import submesh
from mesh.tetmesh import TetMesh


@dataclass(frozen=True)
class _Piece:
    nodes: Ints
    surfaces: tuple[Surface, ...]
    recovery: Recovery


class PartRecovery:
    """Recovers the stress of each part from its own elements.

    Parameters
    ----------
    mesh, planes, surfaces
        As for `Recovery`; the interface of two parts is not a surface of known traction.
    """

    def __init__(self, mesh: TetMesh, planes: tuple[Surface, ...], surfaces: tuple[Surface, ...]) -> None:
        self._n_points = len(mesh.points)
        self._pieces = [_piece(mesh, number, planes, surfaces) for number in _numbers(mesh)]

    @property
    def nodes(self) -> list[Ints]:
        """Nodes (n,) of each part."""
        return [piece.nodes for piece in self._pieces]

    def nodal_stress(
        self,
        displacement: Floats,
        materials: Sequence[Material],
        parity: Parity = Parity.SYMMETRIC,
        traction: Mapping[Surface, Floats] | None = None,
        pressure: Mapping[int, Floats] | None = None,
    ) -> list[Floats]:
        """Recover the stress of each part.

        Parameters
        ----------
        displacement, parity, traction
            As for `Recovery.nodal_stress`.
        materials
            One per part.
        pressure
            By the number of each part that has a pressure, (n_points, n_cases), MPa.

        Returns
        -------
        list of ndarray
            Per part (n_points, 6, n_cases), MPa; NaN at nodes outside the part.
        """
        found = []
        for piece, stress in zip(
            self._pieces, self.part_stress(displacement, materials, parity, traction, pressure), strict=True
        ):
            if len(piece.nodes) < self._n_points:
                every = np.full((self._n_points, *stress.shape[1:]), np.nan)
                every[piece.nodes] = stress
                found.append(every)
            else:
                found.append(stress)
        return found

    def part_stress(
        self,
        displacement: Floats,
        materials: Sequence[Material],
        parity: Parity,
        traction: Mapping[Surface, Floats] | None = None,
        pressure: Mapping[int, Floats] | None = None,
    ) -> Iterator[Floats]:
        """Stress (n, 6, n_cases) at the `nodes` of each part; parameters as for `nodal_stress`."""
        for number, (piece, material) in enumerate(zip(self._pieces, materials, strict=True)):
            nodes = piece.nodes
            own = {
                surface: values[nodes]
                for surface, values in (traction or {}).items()
                if surface in piece.surfaces
            }
            p = pressure[number][nodes] if pressure and number in pressure else None
            yield piece.recovery.nodal_stress(displacement[nodes], material, parity, own, p)


def _numbers(mesh: TetMesh) -> list[int]:
    return [0] if mesh.part is None else np.unique(mesh.part).tolist()


def _piece(mesh: TetMesh, number: int, planes: tuple[Surface, ...], surfaces: tuple[Surface, ...]) -> _Piece:
    own, nodes = (mesh, np.arange(len(mesh.points))) if mesh.part is None else submesh(mesh, number)
    known = tuple(surface for surface in surfaces if surface in own.facets)
    cuts = tuple(plane for plane in planes if plane in own.facets)
    return _Piece(nodes, known, Recovery(own, cuts, known))
