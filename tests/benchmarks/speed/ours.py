"""`fea`'s own solution: assembly, factor, solve, nodal stress; of the whole rod or of a quarter of it.

    python ours.py CASE.npz OUT whole|quarter|multigrid|reference [straight]

`reference` is the answer that all others are compared with: the whole rod, and in place of `fea`'s
recovered stress the plain nodal mean of extrapolated Gauss values, which is what CalculiX forms.
"""

import numpy as np
from case import nodal_forces, read_case
from worker import Run

from fea.base.choices import SolverName, Support
from fea.machine.clock import Clock
from fea.solid.assembly import stiffness_degree, tabulate
from fea.solid.parity import Parity, ParityPair
from fea.solid.recovery import ElementStress, Recovery
from fea.solid.stress import von_mises
from fea.solvers.static import Model
from fea.study.study import load_study
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh, unmirrored

SURFACES = (Surface.FREE, Surface.BIG_END_BORE, Surface.SMALL_END_BORE)


def main() -> None:
    run = Run()
    what = run.arguments[0]
    case = read_case(run.case)
    material = load_study("leon-2001").material.material()
    warm_up(material)
    if what == "reference":
        reference(run, straight="straight" in run.arguments)
        return
    carrier = case.whole if what == "quarter" else unmirrored(case.whole.mesh)
    cell = case.cell if what == "quarter" else case.whole.mesh
    planes = (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z) if what == "quarter" else ()
    loads = nodal_forces(cell, case.bores)
    tractions = {
        parity: {surface: split.part(parity)[..., None] for surface, split in loads.traction.items()}
        for parity in Parity
    }
    run.start()
    clock = Clock()
    solver = SolverName.AMG if what == "multigrid" else SolverName.AUTO
    model = Model(cell, material, Support.INERTIA_RELIEF, solver, clock)
    solution = model.solve([loads.forces])
    with clock("stress"):
        recovery = Recovery(cell, planes, SURFACES)
        stress = {
            parity: recovery.nodal_stress(u, material, parity, tractions[parity])
            for parity, u in solution.displacement.items()
        }
        odd = Parity.ANTISYMMETRIC
        displacement = carrier.vector(
            solution.displacement[Parity.SYMMETRIC], solution.displacement.get(odd)
        )[..., 0]
        tensor = carrier.tensor(stress[Parity.SYMMETRIC], stress.get(odd))[..., 0]
        equivalent = von_mises(tensor)
    run.stages |= clock.seconds
    run.facts |= {"all": clock.total, "solver": model.solver}
    run.finish(displacement=displacement, recovered=equivalent, points=carrier.mesh.points)


def warm_up(material: object) -> None:
    """Let the libraries start their threads: one small tetrahedron."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    mesh = TetMesh(corners, np.array([[0, 1, 2, 3]]))
    Model(mesh, material, Support.INERTIA_RELIEF).solve([ParityPair(np.zeros((4, 3)), None)])


def reference(run: Run, *, straight: bool) -> None:
    case = read_case(run.case)
    mesh = case.whole.mesh
    if straight:
        with np.load(run.case) as data:
            mesh = TetMesh(data["straight"], mesh.tets, mesh.facets)
    material = load_study("leon-2001").material.material()
    run.start()
    solution = Model(mesh, material, Support.INERTIA_RELIEF).solve([ParityPair(case.forces, None)])
    u = solution.displacement[Parity.SYMMETRIC]
    sampled = ElementStress(mesh)(u, material)[..., 0]
    mean = Recovery(mesh).nodal_stress(u, material)[..., 0]
    values = tabulate(mesh.tets.shape[1], stiffness_degree(mesh.tets.shape[1])).values
    run.finish(
        displacement=u[..., 0],
        gauss=von_mises(sampled),
        places=values @ mesh.points[mesh.tets],
        mean=von_mises(mean),
        points=mesh.points,
    )


if __name__ == "__main__":
    main()
