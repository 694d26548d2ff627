# requires: medcoupling==9.15.0
"""MEDCoupling, the library of SALOME and Code_Aster, reads our MED file, and writes three versions of it."""

from importlib.metadata import version as version_of

import medcoupling as mc
import numpy as np
from rows import TURN, judge, mesh, of_mesh, of_names, of_stress, row, volumes

KINDS = {4: mc.NORM_TETRA4, 10: mc.NORM_TETRA10}


def arrays(file):
    """Points and tetrahedra, their nodes in MED's order."""
    solid = file.getMeshAtLevel(0)
    cells = solid.getNodalConnectivity().toNumPyArray().reshape(-1, 11)[:, 1:]
    return file.getCoords().toNumPyArray(), cells


def reads(folder, known):
    crossing, path = "run.med → MEDCoupling", str(folder / "run.med")
    file = mc.MEDFileUMesh(path)
    points, cells = arrays(file)
    yield from of_mesh(crossing, known, points, cells[:, TURN[10]])
    straight = file.getMeshAtLevel(0).getMeasureField(isAbs=False).getArray().accumulate()[0]
    said = "its own volume, with straight sides, mm³"
    yield row(crossing, said, straight, known["volume_mm3"], "turned", allowed=0.01)
    fields = mc.MEDFileFieldMultiTS(path, "tension_stress")
    order = [word.partition(" ")[0] for word in fields.getInfo()]
    stress = fields[0].getFieldAtLevel(mc.ON_NODES, 0).getArray().toNumPyArray()
    columns = [order.index(name) for name in ("XX", "YY", "ZZ", "XY", "YZ", "XZ")]
    yield of_stress(crossing, known, points, stress[:, columns])
    names = set(file.getGroupsNames()) - {"rod"}
    triangles = {name: file.getGroupArr(-1, name).getNumberOfTuples() for name in names}
    yield of_names(crossing, known, triangles)


def writes(folder, size):
    points, tens = arrays(mc.MEDFileUMesh(str(folder.parents[1] / "run.med")))
    for nodes, kind in KINDS.items():
        used, local = np.unique(tens[:, :nodes], return_inverse=True)
        local = local.reshape(-1, nodes)
        volume = volumes(points[used], local[:, TURN[nodes]]).sum()
        made = mc.MEDCouplingUMesh("rod", 3)
        made.setCoords(mc.DataArrayDouble(points[used] * size))
        made.allocateCells(len(local))
        for cell in local:
            made.insertNextCell(kind, cell.tolist())
        made.finishInsertingCells()
        file = mc.MEDFileUMesh()
        file.setMeshAtLevel(0, made)
        for version, write in (
            ("3.0", file.write30),
            ("3.3", file.write33),
            ("4.0", file.write40),
            ("4.2", file.write),
        ):
            name = f"tetra{nodes}-{version}.med"
            write(str(folder / name), 2)
            yield mesh(name, f"{nodes}-node tetrahedra, MED {version}", volume)


judge(version_of("medcoupling"), reads, writes)
