# requires: medcoupling==9.15.0
"""MEDCoupling, the library of SALOME and Code_Aster: reads our MED files, writes ours."""

import json
from pathlib import Path

import medcoupling as mc
import numpy as np
from rows import CLOSE, Item, judge, of_mesh, of_names, of_stress, row, volumes

# Between MED's order of the nodes of a tetrahedron, which is turned, and VTK's: either way.
TURN = {4: [0, 2, 1, 3], 10: [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]}
KINDS = {4: mc.NORM_TETRA4, 10: mc.NORM_TETRA10}


def reads(folder: Path, known: dict):
    crossing, file = "run.med → MEDCoupling", str(folder / "run.med")
    mesh = mc.MEDFileUMesh(file)
    solid = mesh.getMeshAtLevel(0)
    points = mesh.getCoords().toNumPyArray()
    cells = solid.getNodalConnectivity().toNumPyArray().reshape(-1, 11)[:, 1:]
    yield from of_mesh(crossing, known, points, cells[:, TURN[10]])
    own = solid.getMeasureField(False).getArray()  # sides are straight here: near the volume, with its sign
    yield row(crossing, "its own volume, straight sides, mm³", own.accumulate()[0], known["volume_mm3"], "turned", 0.01)
    fields = mc.MEDFileFieldMultiTS(file, "tension_stress")
    order = [word.partition(" ")[0] for word in fields.getInfo()]
    stress = fields[0].getFieldAtLevel(mc.ON_NODES, 0).getArray().toNumPyArray()
    columns = [order.index(name) for name in ("XX", "YY", "ZZ", "XY", "YZ", "XZ")]
    yield from of_stress(crossing, known, points, stress[:, columns])
    names = set(mesh.getGroupsNames()) - {"rod"}
    yield from of_names(
        crossing, known, {name: mesh.getGroupArr(-1, name).getNumberOfTuples() for name in names}
    )


def writes(folder: Path, spoil: bool):
    run = json.loads((folder.parents[1] / "known.json").read_text())
    source = mc.MEDFileUMesh(str(folder.parents[1] / "run.med"))
    points = source.getCoords().toNumPyArray()
    tens = source.getMeshAtLevel(0).getNodalConnectivity().toNumPyArray().reshape(-1, 11)[:, 1:]
    for nodes in (4, 10):
        used, local = np.unique(tens[:, :nodes], return_inverse=True)
        local = local.reshape(-1, nodes)
        volume = volumes(points[used], local[:, TURN[nodes]]).sum()
        assert nodes == 4 or abs(volume / run["volume_mm3"] - 1) < CLOSE
        mesh = mc.MEDCouplingUMesh("rod", 3)
        mesh.setCoords(mc.DataArrayDouble(points[used] * (1.01 if spoil else 1.0)))
        mesh.allocateCells(len(local))
        for cell in local:
            mesh.insertNextCell(KINDS[nodes], cell.tolist())
        mesh.finishInsertingCells()
        file = mc.MEDFileUMesh()
        file.setMeshAtLevel(0, mesh)
        for version in ("30", "33", "40"):
            name = f"tetra{nodes}-{version}.med"
            getattr(file, f"write{version}")(str(folder / name), 2)
            tried = f"{nodes}-node tetrahedra, MED {version[0]}.{version[1]}"
            yield Item(name, tried, "scaled", {"volume_mm3": volume, "length_mm": 141.0}, 1e-4)


judge(mc.MEDCouplingVersionStr(), reads, writes)
