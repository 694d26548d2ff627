#!/bin/bash
# gmsh 4.15.2 reading, MEDCoupling 9.15.0 (the library of SALOME) writing: a stress field in a MED 4.0 file.
# MED and Code_Aster store a symmetric tensor as six named components. gmsh has views of one, three or nine and fills
# six up with three zeros at the end, without a word, whatever their names: XX YY ZZ XY XZ YZ become the first two rows
# of a matrix whose third is zero. Its colours are then the von Mises stress of a tensor that nobody computed.
# Seen (MPa): hydrostatic 100 drawn as 200 instead of 0; uniaxial 100 along x as 100, along y as 122.5; shear 100 as 122.5 (173.2).
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q medcoupling==9.15.0 gmsh==4.15.2 numpy==2.4.6 2>/dev/null
cd "$folder"
venv/bin/python - <<'PYTHON'
import medcoupling as mc
import numpy as np

STRESSES = {
    "hydrostatic": [100, 100, 100, 0, 0, 0],
    "along_x": [100, 0, 0, 0, 0, 0],
    "along_y": [0, 100, 0, 0, 0, 0],
    "shear_yz": [0, 0, 0, 0, 0, 100],
}
mesh = mc.MEDCouplingUMesh("rod", 3)
mesh.setCoords(mc.DataArrayDouble(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])))
mesh.allocateCells(1)
mesh.insertNextCell(mc.NORM_TETRA4, [0, 2, 1, 3])
mesh.finishInsertingCells()
file = mc.MEDFileUMesh()
file.setMeshAtLevel(0, mesh)
file.write40("stress.med", 2)
for name, stress in STRESSES.items():
    values = mc.DataArrayDouble(np.tile(np.array(stress, float), (4, 1)))
    values.setInfoOnComponents([f"{axes} [MPa]" for axes in ("XX", "YY", "ZZ", "XY", "XZ", "YZ")])
    field = mc.MEDCouplingFieldDouble(mc.ON_NODES, mc.ONE_TIME)
    field.setMesh(mesh)
    field.setName(name)
    field.setTime(0.0, 0, 0)
    field.setArray(values)
    one = mc.MEDFileField1TS()
    one.setFieldNoProfileSBT(field)
    one.write40("stress.med", 0)
PYTHON
venv/bin/python - <<'PYTHON'
import gmsh
import numpy as np

SEEN = {"hydrostatic": (200.0, 0.0), "along_x": (100.0, 100.0), "along_y": (122.474, 100.0), "shear_yz": (122.474, 173.205)}
gmsh.initialize(["", "-v", "1"], readConfigFiles=False)
gmsh.open("stress.med")
views = {gmsh.view.option.getString(tag, "Name"): tag for tag in gmsh.view.getTags()}
for name, (seen, exact) in SEEN.items():
    data = np.reshape(gmsh.view.getHomogeneousModelData(views[name], 0)[2], (4, -1))[0]
    drawn = gmsh.view.option.getNumber(views[name], "Max")
    print(f"{name}: {data.tolist()}, drawn {drawn:.3f} MPa, von Mises {exact} MPa")
    assert len(data) == 9 and not data[6:].any() and abs(drawn - seen) < 1e-3
PYTHON
