#!/bin/bash
# scikit-fem 12.0.2 (quadratic tetrahedra, ElementTetP2) on unstructured meshes of gmsh 4.15.2.
# The four Gauss points of a ten-node tetrahedron, where solvers print and extrapolate stress, are not superconvergent:
# the gradient there converges with h^2 as everywhere (Barlow's points of hexahedra would give h^3), and the error is
# about 0.7 of that at random points. The centroid is better than any of the four, a corner three times as bad.
# Seen: Poisson's equation with a smooth solution, sizes 0.25 and 0.125, root mean square error of the gradient: Gauss
# points 0.0374, 0.0100 (rate 1.90); random points 0.0540, 0.0140 (1.95); centroid 0.0236, 0.0061 (1.95); corners 0.112, 0.030.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q scikit-fem==12.0.2 gmsh==4.15.2 numpy==2.4.6 scipy==1.17.1 2>/dev/null
cd "$folder"
venv/bin/python - <<'PYTHON'
import gmsh
import numpy as np
import skfem
from skfem.helpers import dot, grad


def unit_cube(size):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.model.mesh.generate(3)
    tags, points, _ = gmsh.model.mesh.getNodes()
    number = {tag: n for n, tag in enumerate(tags)}
    cells = np.vectorize(number.get)(np.reshape(gmsh.model.mesh.getElements(3)[2][0], (-1, 4)))
    gmsh.finalize()
    return skfem.MeshTet(np.reshape(points, (-1, 3)).T.copy(), cells.T.copy())


def exact(x):
    return np.sin(2 * x[0] + 0.3) * np.exp(x[1]) * np.cos(1.5 * x[2])


def exact_gradient(x):
    e = np.exp(x[1])
    s, c = np.sin(2 * x[0] + 0.3), np.cos(2 * x[0] + 0.3)
    return np.array([2 * c * e * np.cos(1.5 * x[2]), exact(x), -1.5 * s * e * np.sin(1.5 * x[2])])


a, b = (5 - 5**0.5) / 20, (5 + 3 * 5**0.5) / 20
places = {
    "Gauss points": np.array([[a, a, a], [b, a, a], [a, b, a], [a, a, b]]).T,
    "random points": np.random.default_rng(1).dirichlet(np.ones(4), 4)[:, :3].T,
    "centroid": np.full((3, 1), 0.25),
    "corners": np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]).T,
}
errors = {place: [] for place in places}
for size in (0.25, 0.125):
    mesh = unit_cube(size)
    basis = skfem.Basis(mesh, skfem.ElementTetP2())
    stiffness = skfem.BilinearForm(lambda u, v, w: dot(grad(u), grad(v))).assemble(basis)
    load = skfem.LinearForm(lambda v, w: (4 - 1 + 1.5**2) * exact(w.x) * v).assemble(basis)
    fixed = basis.get_dofs().flatten()
    x = basis.zeros()
    x[fixed] = exact(basis.doflocs[:, fixed])
    x = skfem.solve(*skfem.condense(stiffness, load, x=x, D=fixed))
    for place, points in places.items():
        weights = np.ones(points.shape[1]) / points.shape[1]
        there = skfem.Basis(mesh, skfem.ElementTetP2(), quadrature=(points, weights))
        difference = there.interpolate(x).grad - exact_gradient(mesh.mapping().F(points))
        errors[place].append(float(np.sqrt((difference**2).sum(axis=0).mean())))
for place, (coarse, fine) in errors.items():
    print(f"{place}: {coarse:.4f} {fine:.4f}, rate {np.log2(coarse / fine):.2f}")
    assert 1.7 < np.log2(coarse / fine) < 2.2, "superconvergent"
gauss, other = errors["Gauss points"][1], errors["random points"][1]
assert 0.6 < gauss / other < 0.85 and errors["centroid"][1] < gauss < errors["corners"][1] / 2.5
PYTHON
