"""The sections of the shank, for buckling."""

import numpy as np

from fea.rod.meshed_rod import Bores
from geometry.rod import Rod
from geometry.section import HeightField, Section, least_section
from mesh import slices
from mesh.tetmesh import TetMesh

_STATIONS = 121


def shank(rod: Rod | None, mesh: TetMesh, bores: Bores) -> tuple[tuple[Section, ...], Section]:
    """Return sections from pin to pin, and the smallest section between the bores.

    `rod`: dimensions; None for an imported solid, for which the mesh is cut.
    """
    places = np.linspace(0.0, bores.rod_length, _STATIONS)
    if rod is None:
        least = slices.least_section(mesh, *bores.between)
        return slices.sections(mesh, places), least
    solid = HeightField(rod)
    return tuple(solid.section(float(x)) for x in places), least_section(rod)


def part_at(mesh: TetMesh, station: float) -> int:
    """Number of the part that fills most of the cross-section at x = `station`, mm."""
    if mesh.part is None:
        return 0
    corners = mesh.points[mesh.tets[:, :4]]
    cut = (corners[..., 0].min(axis=1) <= station) & (station <= corners[..., 0].max(axis=1))
    volumes = np.abs(np.linalg.det(corners[cut, 1:] - corners[cut, :1]))
    return int(np.bincount(mesh.part[cut], volumes).argmax())
