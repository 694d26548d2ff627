"""SfePy: second-order field on the same mesh with straight edges, SuperLU, stress at the Gauss points.

It has no curved tetrahedra; so its answer is compared with ours on the straight mesh. As with NGSolve, the
six degrees of freedom stand on springs that carry nothing.
"""

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree
from sfepy.base.base import output
from sfepy.discrete import Equation, Equations, FieldVariable, Integral, Integrals, Material, Problem
from sfepy.discrete.common.mappings import get_physical_qps
from sfepy.discrete.conditions import Conditions
from sfepy.discrete.fem import FEDomain, Field, Mesh
from sfepy.mechanics.matcoefs import stiffness_from_youngpoisson
from sfepy.solvers.ls import ScipyDirect
from sfepy.terms import Term
from worker import Run, von_mises

TENSOR = [0, 3, 4, 3, 1, 5, 4, 5, 2]  # from its order XX YY ZZ XY XZ YZ


def main() -> None:
    output.set_output(quiet=True)
    run = Run()
    with np.load(run.case) as data:
        case = dict(data)
    points, tets = case["straight"], case["tets"]
    vertices = np.unique(tets[:, :4])
    cells = np.searchsorted(vertices, tets[:, :4])
    groups = np.zeros(len(vertices), dtype=np.int32)
    mesh = Mesh.from_data(
        "rod",
        points[vertices],
        groups,
        [cells.astype(np.int32)],
        [np.zeros(len(cells), dtype=np.int32)],
        ["3_4"],
    )
    stiffness = stiffness_from_youngpoisson(3, float(case["young"]), float(case["poisson"]))
    material = Material("steel", D=stiffness)
    integral = Integral("i", order=2)
    run.start()
    with run.stage("assembly"):
        omega = FEDomain("rod", mesh).create_region("Omega", "all")
        field = Field.from_args("displacement", np.float64, "vector", omega, approx_order=2)
        u = FieldVariable("u", "unknown", field)
        v = FieldVariable("v", "test", field, primary_var_name="u")
        term = Term.new("dw_lin_elastic(steel.D, v, u)", integral, omega, steel=material, v=v, u=u)
        problem = Problem("rod", equations=Equations([Equation("balance", term)]))
        problem.set_bcs(ebcs=Conditions([]))
        problem.time_update()
        problem.update_materials()
        equations = problem.equations
        K = problem.mtx_a
        K = equations.evaluate(mode="weak", dw_mode="matrix", asm_obj=K)
    distance, node = cKDTree(points).query(field.get_coor())
    if distance.max() > 1e-9:
        raise SystemExit("its nodes are not at the same places")
    springs = np.where(case["fixed"][node].ravel(), K.diagonal(), 0.0)
    with run.stage("factor"):  # factors, and solves
        solver = ScipyDirect({"method": "superlu", "use_presolve": True})
        solver.presolve(K + sparse.diags_array(springs))
    with run.stage("solve"):
        found = solver.solve(case["forces"][node].ravel())
    with run.stage("stress"):
        u.set_data(found)
        sampled = problem.evaluate(
            "ev_cauchy_stress.i.Omega(steel.D, u)",
            mode="qp",
            integrals=Integrals([integral]),
            copy_materials=False,
        )
    displacement = np.empty_like(points)
    displacement[node] = found.reshape(-1, 3)
    places = get_physical_qps(omega, integral)
    tensors = sampled.reshape(len(tets), -1, 6)[..., TENSOR].reshape(len(tets), -1, 3, 3)
    run.finish(
        displacement=displacement, gauss=von_mises(tensors), places=places.values.reshape(len(tets), -1, 3)
    )


if __name__ == "__main__":
    main()
