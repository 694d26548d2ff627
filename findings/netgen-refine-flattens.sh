#!/bin/bash
# NGSolve and Netgen 6.2.2608 reading a second-order mesh of gmsh 4.15.2 (format 2.2).
# ReadGmsh keeps the curved elements (the volume is that of gmsh's ten-node tetrahedra), although GetCurveOrder() says 1.
# One Refine() drops every mid-side node: the refined mesh is that of the plane-faced tetrahedra, with no message.
# Refinement to converge on a curved body then converges to another body. The mid-side nodes also stay vertices of
# the mesh: a first-order space on it holds 171 unused unknowns of 236.
# Seen: ball of radius 1: 4.18337 as read and in gmsh, 3.77584 after Refine(), 3.77584 of the corners alone.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q ngsolve==6.2.2608 gmsh==4.15.2 numpy==2.4.6 2>/dev/null
cd "$folder"
venv/bin/python - <<'PYTHON'
import gmsh
import numpy as np

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.addSphere(0, 0, 0, 1)
gmsh.model.occ.synchronize()
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.6)
gmsh.option.setNumber("Mesh.MeshSizeMin", 0.6)
gmsh.model.addPhysicalGroup(3, [1], 1, "ball")
gmsh.model.addPhysicalGroup(2, [1], 2, "skin")
gmsh.model.mesh.generate(3)
gmsh.model.mesh.setOrder(2)
gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
gmsh.write("ball.msh")
points, weights = gmsh.model.mesh.getIntegrationPoints(11, "Gauss6")
determinants = np.array(gmsh.model.mesh.getJacobians(11, points)[1]).reshape(-1, len(weights))
curved = (determinants * weights).sum()
tags, coordinates, _ = gmsh.model.mesh.getNodes()
place = dict(zip(tags, np.reshape(coordinates, (-1, 3))))
elements = np.reshape(gmsh.model.mesh.getElements(3)[2][0], (-1, 10))
corners = np.array([[place[node] for node in element[:4]] for element in elements])
flat = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 6
gmsh.finalize()

from netgen.read_gmsh import ReadGmsh
from ngsolve import CF, Integrate, Mesh

mesh = Mesh(ReadGmsh("ball.msh"))
read, order, vertices = Integrate(CF(1), mesh, order=6), mesh.GetCurveOrder(), mesh.nv
mesh.Refine()
refined = Integrate(CF(1), mesh, order=6)
print(f"gmsh {curved:.5f} (corners alone {flat:.5f}); read {read:.5f}, order {order}, {vertices} vertices; refined {refined:.5f}")
assert abs(read / curved - 1) < 1e-6 and order == 1
assert abs(refined / flat - 1) < 1e-6 and refined < 0.92 * read, "Refine() keeps the curvature"
PYTHON
