#!/bin/bash
# FreeCAD 0.20.2 (Debian 12, freecad-python3 0.20.2+dfsg1-4) reading, MEDCoupling 9.15.0 writing, one MED file.
# Fem.read() looks in a MED file for a mesh that is called as the file, without its ending. If no mesh is, it returns
# an empty mesh and says nothing: a file of SALOME that is renamed, or copied under another name, has lost its mesh,
# and so has a file that FreeCAD wrote itself. In MED the name of a mesh has nothing to do with that of its file, and
# MEDCoupling reads both.
# Seen: the same bytes as rod.med 4 nodes and 1 volume, as renamed.med 0 and 0; the mesh in both is "rod".
set -eu
[ "$(dpkg-query -W -f '${Version}' freecad-python3)" = 0.20.2+dfsg1-4 ] || { echo "needs Debian 12's freecad-python3"; exit 2; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q medcoupling==9.15.0 numpy==2.4.6 2>/dev/null
cd "$folder"
venv/bin/python - <<'PYTHON'
import medcoupling as mc
import numpy as np

mesh = mc.MEDCouplingUMesh("rod", 3)
mesh.setCoords(mc.DataArrayDouble(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])))
mesh.allocateCells(1)
mesh.insertNextCell(mc.NORM_TETRA4, [0, 2, 1, 3])
mesh.finishInsertingCells()
file = mc.MEDFileUMesh()
file.setMeshAtLevel(0, mesh)
file.write40("rod.med", 2)
PYTHON
cp rod.med renamed.med
venv/bin/python -c 'import medcoupling as mc; print("MEDCoupling:", mc.GetMeshNames("renamed.med"))'
/usr/bin/python3 - <<'PYTHON'
import os
import sys

sys.path[:0] = ["/usr/lib/freecad-python3/lib", "/usr/lib/freecad/lib"]
import FreeCAD
import Fem

found = {}
for name in ("rod.med", "renamed.med"):
    mesh = Fem.read(name)
    found[name] = mesh.NodeCount, mesh.VolumeCount
    mesh.write("own.med")
    os.replace("own.med", "other.med")
    assert mesh.NodeCount == 0 or Fem.read("other.med").NodeCount == 0
print("FreeCAD", ".".join(FreeCAD.Version()[:3]), found)
assert found == {"rod.med": (4, 1), "renamed.med": (0, 0)}, "the name of the file no longer chooses the mesh"
PYTHON
