"""What presses on the rod, as a VTU file of the surfaces alone.

Each surface has nodes of its own, so that where two of them meet each keeps its pressure: its integral over
the surface is the force of the pin, of the bolt, or that clamps the joint.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from fea.judge.case_result import CaseResult
from fea.output.vtu import write_cells
from geometry.surfaces import INTERFACES

# Surfaces on which the same presses as on those opposite to them.
_OPPOSITE = {second for _, second in INTERFACES}


def write_seats(path: Path, cases: Mapping[str, CaseResult]) -> None:
    """Write the pressed surfaces, one side of every interface.

    For each load case, `pressure_CASE`, MPa, and `traction_CASE`: force over area on the part that the
    surface bounds, MPa. Pressures are linear over a facet. Of the elements, an array by the name of each
    surface is 1 on it.

    Raises
    ------
    StorageError
        The file could not be written.
    """
    first = next(iter(cases.values()))
    surfaces = [surface for surface in first.seats if surface not in _OPPOSITE]
    facets = [first.mesh.facets[surface] for surface in surfaces]
    nodes = [first.seats[surface].nodes for surface in surfaces]
    starts = np.cumsum([0, *map(len, nodes)])
    cells = [
        start + np.searchsorted(here, own) for start, here, own in zip(starts, nodes, facets, strict=False)
    ]
    arrays = {}
    for name, case in cases.items():
        seats = [case.seats[surface] for surface in surfaces]
        arrays[f"pressure_{name}"] = np.concatenate([seat.pressure for seat in seats])
        arrays[f"traction_{name}"] = np.concatenate([seat.traction for seat in seats])
    number = np.repeat(np.arange(len(surfaces)), [len(own) for own in facets])
    masks = {surface.value: (number == k).astype(np.uint8) for k, surface in enumerate(surfaces)}
    write_cells(path, first.mesh.points[np.concatenate(nodes)], np.concatenate(cells), arrays, masks)
