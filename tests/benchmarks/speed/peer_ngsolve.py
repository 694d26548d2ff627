"""NGSolve on the same curved mesh: assembly, sparse Cholesky, solve, stress at the Gauss points.

Its fastest way known to us: H1 of order 2 with three components a dof (3×3 blocks: the vector-valued space
takes a third longer), symmetric storage, `sparsecholesky`, everything under its task manager. Ten-node
tetrahedra keep their curved geometry. Blocks cannot be held component by component; so the six degrees of
freedom stand on springs instead, which carry nothing because the load is in balance.
"""

import ngsolve as ng
import numpy as np
from netgen.meshing import Mesh
from worker import THREADS, Run, von_mises

EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
NETGEN = [0, 1, 2, 3, 4, 6, 7, 5, 8, 9]  # its edges: (0,1), (0,2), (0,3), (1,2), (1,3), (2,3)
RULE = ng.IntegrationRule(ng.TET, 2)
BUBBLE = -0.125  # an edge's shape function in the middle of the edge


def netgen_mesh(points: np.ndarray, tets: np.ndarray) -> tuple[ng.Mesh, np.ndarray, np.ndarray]:
    """The mesh; our node of each of its dofs; the two vertices of each of its edges."""
    vertices = np.unique(tets[:, :4])
    order = np.concatenate([vertices, np.setdiff1d(np.arange(len(points)), vertices)])
    place = np.empty_like(order)
    place[order] = np.arange(order.size)
    mesh = Mesh(dim=3)
    mesh.AddPoints(np.ascontiguousarray(points[order]))
    elements = np.ascontiguousarray(place[tets][:, NETGEN], dtype=np.int32)
    mesh.AddElements(dim=3, index=1, data=elements, base=0)
    whole = ng.Mesh(mesh)
    ends = np.array([sorted(vertex.nr for vertex in edge.vertices) for edge in whole.edges])
    ours = np.concatenate([np.sort(place[tets[:, pair]], axis=1) for pair in EDGES])
    middles = np.concatenate([tets[:, 4 + k] for k in range(6)])
    keys, first = np.unique(ours[:, 0] * len(points) + ours[:, 1], return_index=True)
    middle = middles[first][np.searchsorted(keys, ends[:, 0] * len(points) + ends[:, 1])]
    return whole, np.concatenate([vertices, middle]), ends


def main() -> None:
    run = Run()
    with np.load(run.case) as data:
        case = dict(data)
    E, nu = float(case["young"]), float(case["poisson"])
    mu, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    points = case["straight" if "straight" in run.arguments else "points"]
    mesh, node, ends = netgen_mesh(points, case["tets"])
    n_vertices = mesh.nv
    # Nodal forces in its hierarchical basis: a vertex function is ours and half of its edges'.
    load = case["forces"][node]
    for side in (0, 1):
        np.add.at(load, ends[:, side], case["forces"][node[n_vertices:]] / 2)
    load[n_vertices:] *= BUBBLE
    held = case["fixed"][node]
    ng.SetNumThreads(THREADS)

    def stress(gradient: ng.CoefficientFunction) -> ng.CoefficientFunction:
        return 2 * mu * ng.Sym(gradient) + lam * ng.Trace(gradient) * ng.Id(3)

    with ng.TaskManager():
        run.start()
        with run.stage("assembly"):
            space = ng.H1(mesh, order=2, dim=3)
            u, v = space.TnT()
            K = ng.BilinearForm(space, symmetric=True)
            K += ng.InnerProduct(stress(ng.Grad(u)), ng.Sym(ng.Grad(v))) * ng.dx
            K.Assemble()
            blocks = K.mat.AsVector().FV().NumPy().reshape(-1, 3, 3)
            starts = np.asarray(K.mat.CSR()[2])[:-1]  # the diagonal comes first in a row
            for dof, axis in zip(*np.nonzero(held), strict=True):
                blocks[starts[dof], axis, axis] *= 2
        with run.stage("factor"):
            inverse = K.mat.Inverse(inverse="sparsecholesky")
        solution = ng.GridFunction(space)
        with run.stage("solve"):
            f = solution.vec.CreateVector()
            f.FV().NumPy()[:] = load.ravel()
            solution.vec.data = inverse * f
        with run.stage("stress"):
            places = mesh.MapToAllElements({ng.TET: RULE}, ng.VOL)
            sampled = stress(ng.Grad(solution))(places)

    values = solution.vec.FV().NumPy().reshape(-1, 3)
    displacement = np.empty_like(values)
    displacement[node[:n_vertices]] = values[:n_vertices]
    middle = (values[ends[:, 0]] + values[ends[:, 1]]) / 2 + BUBBLE * values[n_vertices:]
    displacement[node[n_vertices:]] = middle
    gauss = von_mises(sampled.reshape(-1, 4, 3, 3))
    spots = np.stack([axis(places) for axis in (ng.x, ng.y, ng.z)], axis=-1)
    run.finish(displacement=displacement, gauss=gauss, places=spots.reshape(-1, 4, 3))


if __name__ == "__main__":
    main()
