#!/bin/bash
# FreeCAD 0.20.2 (Debian 12, freecad-python3 0.20.2+dfsg1-4) between VTK 9.7.2 and Abaqus decks.
# FreeCAD keeps tetrahedra in the order of SMESH, which counts the vertices the other way round from Abaqus, Nastran and
# VTK. It turns them when it reads and writes Abaqus' decks, but not for VTK's files, in either direction. A mesh that
# goes through FreeCAD from one to the other is inside out, without a word. From deck to deck it is as it was.
# Seen: a tetrahedron of 166.67 mm³ is -166.67 mm³ in the deck that FreeCAD writes of its .vtu, and in the .vtu that it
# writes of its deck.
set -eu
[ "$(dpkg-query -W -f '${Version}' freecad-python3)" = 0.20.2+dfsg1-4 ] || { echo "needs Debian 12's freecad-python3"; exit 2; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q vtk==9.7.2 numpy==2.4.6 2>/dev/null
cd "$folder"
venv/bin/python - <<'PYTHON'
from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkUnstructuredGrid
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

points, nodes, grid = vtkPoints(), vtkIdList(), vtkUnstructuredGrid()
rows = [(0, 0, 0), (10, 0, 0), (0, 10, 0), (0, 0, 10)]
for number, place in enumerate(rows):
    points.InsertNextPoint(place)
    nodes.InsertNextId(number)
grid.SetPoints(points)
grid.InsertNextCell(VTK_TETRA, nodes)
writer = vtkXMLUnstructuredGridWriter()
writer.SetFileName("one.vtu")
writer.SetInputData(grid)
writer.Write()
lines = [f"{number}, {x}, {y}, {z}" for number, (x, y, z) in enumerate(rows, start=1)]
with open("one.inp", "w") as deck:
    deck.write("\n".join(["*NODE", *lines, "*ELEMENT, TYPE=C3D4, ELSET=EALL", "1, 1, 2, 3, 4", ""]))
PYTHON
/usr/bin/python3 - <<'PYTHON'
import sys

sys.path[:0] = ["/usr/lib/freecad-python3/lib", "/usr/lib/freecad/lib", "/usr/lib/freecad/Mod/Fem"]
import FreeCAD
import Fem

for source in ("vtu", "inp"):
    mesh = Fem.read(f"one.{source}")
    print("FreeCAD", ".".join(FreeCAD.Version()[:3]), f"one.{source}: {mesh.VolumeCount} volume")
    for target in ("vtu", "inp"):
        mesh.write(f"{source}-{target}.{target}")
PYTHON
venv/bin/python - <<'PYTHON'
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


def of_deck(path):
    lines = [line.split(",") for line in open(path) if line[:1].isdigit()]
    points = {int(words[0]): np.array(words[1:4], float) for words in lines[:4]}
    return np.array([points[int(word)] for word in lines[4][1:5]])


def of_vtu(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    cells = reader.GetOutput().GetCells().GetConnectivityArray()
    return vtk_to_numpy(reader.GetOutput().GetPoints().GetData())[vtk_to_numpy(cells)]


for source, target, sign in (("vtu", "inp", -1), ("inp", "vtu", -1), ("inp", "inp", 1), ("vtu", "vtu", 1)):
    corners = (of_deck if target == "inp" else of_vtu)(f"{source}-{target}.{target}")
    volume = np.linalg.det(corners[1:] - corners[0]) / 6
    print(f"{source} -> FreeCAD -> {target}: {volume:.2f} mm³")
    assert abs(volume - sign * 1000 / 6) < 1e-3, "FreeCAD no longer leaves VTK's order as it is"
PYTHON
