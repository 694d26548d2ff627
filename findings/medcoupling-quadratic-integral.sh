#!/bin/bash
# MEDCoupling 9.15.0 (the MED library of SALOME), a field on the nodes of a ten-node tetrahedron (NORM_TETRA10).
# integral() takes the volume times the plain mean of the ten nodal values. That is right for a linear field, so a
# patch test passes; the integral of a quadratic field needs the weights -1/20 (corners) and 1/5 (mid-side nodes).
# getValueOn() raises an error on such an element; integral() answers without a word.
# Seen: integral of x over the unit tetrahedron 0.0416667 (exact 1/24); of x squared 0.0291667 (exact 1/60: 75 % too much).
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q medcoupling==9.15.0 numpy==2.4.6 2>/dev/null
cd "$folder"
venv/bin/python - <<'PYTHON'
import medcoupling as mc
import numpy as np

corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
edges = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
points = np.vstack([corners, [(corners[i] + corners[j]) / 2 for i, j in edges]])
mesh = mc.MEDCouplingUMesh("tetrahedron", 3)
mesh.setCoords(mc.DataArrayDouble(points))
mesh.allocateCells(1)
mesh.insertNextCell(mc.NORM_TETRA10, [0, 2, 1, 3, 6, 5, 4, 7, 9, 8])  # MED's orientation
mesh.finishInsertingCells()


def integral(values):
    field = mc.MEDCouplingFieldDouble(mc.ON_NODES, mc.ONE_TIME)
    field.setMesh(mesh)
    field.setName("u")
    field.setTime(0.0, 0, 0)
    field.setArray(mc.DataArrayDouble(values.copy()))
    field.checkConsistencyLight()
    return field, field.integral(0, True)


x = points[:, 0]
_, linear = integral(x)
field, quadratic = integral(x**2)
consistent = ((x**2)[:4].sum() * -1 / 20 + (x**2)[4:].sum() / 5) / 6
try:
    field.getValueOn([0.25, 0.25, 0.25])
    raises = False
except mc.InterpKernelException:
    raises = True
print(f"x: {linear:.7f} (1/24); x squared: {quadratic:.7f}, by the element's shape functions {consistent:.7f} (1/60)")
assert mesh.getMeasureField(False).getArray().getValues()[0] > 0 and raises
assert abs(linear - 1 / 24) < 1e-12 and abs(consistent - 1 / 60) < 1e-12
assert abs(quadratic - 0.175 / 6) < 1e-12, "the integral is no longer the plain mean of the nodes"
PYTHON
