#!/bin/bash
# meshio 5.3.5 writing, VTK 9.7.2 reading, XDMF 3 (inline XML data).
# A symmetric tensor of six components in the order that VTK itself uses (XX YY ZZ XY YZ XZ) is written by meshio as
# an attribute of type Tensor6. VTK reads it as the upper triangle row by row (XX XY XZ YY YZ ZZ) and expands it to nine
# components, without a word: the file's YY comes out as XY, and its XZ as ZZ. The way out is to write nine components.
# Seen: written XX YY ZZ XY YZ XZ = 1 2 3 4 5 6; read as [1 2 3 / 2 4 5 / 3 5 6] instead of [1 4 6 / 4 2 5 / 6 5 3].
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q meshio==5.3.5 vtk==9.7.2 h5py==3.16.0 numpy==2.4.6 2>/dev/null
cd "$folder"
venv/bin/python - <<'PYTHON'
import meshio
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
stress = np.tile(np.arange(1.0, 7.0), (4, 1))  # XX YY ZZ XY YZ XZ
mesh = meshio.Mesh(points, [("tetra", [[0, 1, 2, 3]])], point_data={"stress": stress})
meshio.write("body.xdmf", mesh, data_format="XML")
print("attribute type:", "Tensor6" if "Tensor6" in open("body.xdmf").read() else "other")
reader = vtkXdmfReader()
reader.SetFileName("body.xdmf")
reader.Update()
read = vtk_to_numpy(reader.GetOutputDataObject(0).GetPointData().GetArray("stress"))[0]
print("read:", read.reshape(-1, 3).tolist())
right = [[1, 4, 6], [4, 2, 5], [6, 5, 3]]
assert read.reshape(3, 3).tolist() == [[1, 2, 3], [2, 4, 5], [3, 5, 6]] != right
PYTHON
