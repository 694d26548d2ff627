"""The sections that a rod has to resist buckling with."""

import numpy as np

from fea.case_loads import Bores
from geometry.rod import Rod
from geometry.section import HeightField, Section, least_section
from mesh import slices
from mesh.tetmesh import TetMesh

_STATIONS = 121


def shank(rod: Rod | None, mesh: TetMesh, bores: Bores) -> tuple[tuple[Section, ...], Section]:
    """Return sections from pin to pin, and the least between the bores.

    Parameters
    ----------
    rod
        Dimensions; None for a solid from a file, whose mesh is cut.
    mesh
        The whole rod.
    bores
        Where they are, and how large.
    """
    places = np.linspace(0.0, bores.rod_length, _STATIONS)
    if rod is None:
        least = slices.least_section(mesh, *bores.between)
        return slices.sections(mesh, places), least
    solid = HeightField(rod)
    return tuple(solid.section(float(x)) for x in places), least_section(rod)
