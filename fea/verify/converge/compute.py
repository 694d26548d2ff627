"""The computations of the work-precision comparison, each to be run in a separate process."""

import dataclasses
import os
import subprocess
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import numpy.typing as npt

from fea.base.choices import Element, Symmetry
from fea.base.material import Material
from fea.machine.clock import Clock
from fea.machine.threads import threads
from fea.output.inp import read_frd, write_inp
from fea.run.adapt import adapt_mesh
from fea.run.prepare import prepare
from fea.run.speed import SpeedResult, solve_speed
from fea.solid.supports import clamped, determinate_restraints
from fea.stress.stress import von_mises
from fea.study.option_tables import MeshTable
from fea.study.study import Study
from fea.verify.cases import goodier, lame
from fea.verify.converge.rod_reference import first_case
from fea.verify.converge.row import Computation, Measured
from geometry.arrays import Floats
from geometry.surfaces import Surface
from geometry.system import peak_memory
from mesh.tetmesh import TetMesh

_BODIES = {"lame": (lame.loaded, lame.worst_hoop), "goodier": (goodier.loaded, goodier.worst_equator)}
# Element size of the warm-up on Lamé's cylinder, mm.
_TINY = 8.0


def compute(computation: Computation, study: Study) -> Measured:
    """Run a computation; `study` is that of the rod."""
    _warm_up(computation)
    if computation.tool == "CalculiX":
        calculix = _calculix_rod if computation.problem == "rod" else _calculix_body
        return calculix(computation, study)
    start = time.perf_counter()
    size, dofs, value = (_rod if computation.problem == "rod" else _body)(computation, study)
    return Measured(size, dofs, time.perf_counter() - start, peak_memory(), value)


def _warm_up(computation: Computation) -> None:
    """Import and start every library with a small model: this time is not part of the comparison."""
    loaded, quantity = _BODIES["lame"]
    solved = loaded(_TINY, computation.order).solved()
    quantity(solved.mesh, solved.stress)


def _body(computation: Computation, _: Study) -> tuple[float, int, float]:
    loaded, quantity = _BODIES[computation.problem]
    solved = loaded(computation.size, computation.order).solved()
    if computation.tool == "fea, mean":
        solved = dataclasses.replace(solved, known=(), traction=None)
    return computation.size, solved.dofs, quantity(solved.mesh, solved.stress)


def _rod(computation: Computation, study: Study) -> tuple[float, int, float]:
    speed, clock = study.speeds()[0], Clock()
    if computation.adaptive:
        options = dataclasses.replace(study.analysis, tolerance_percent=computation.size)
        table = MeshTable(size_mm=computation.first_size)
        found = adapt_mesh(dataclasses.replace(study, mesh=table, analysis=options), (speed,), clock)
        return found.rod.mesh.meshing.size, *_peak(found.at(speed))
    rod = prepare(_meshed(computation, study), clock, known_traction=computation.tool != "fea, mean")
    return computation.size, *_peak(solve_speed(rod, speed))


def _meshed(computation: Computation, study: Study) -> Study:
    symmetry = Symmetry.NONE if computation.tool in ("fea, whole", "CalculiX") else study.analysis.symmetry
    options = dataclasses.replace(study.analysis, symmetry=symmetry, tolerance_percent=None, cycle=False)
    table = MeshTable(size_mm=computation.size, element=Element(computation.element))
    return dataclasses.replace(study, mesh=table, analysis=options)


def _peak(result: SpeedResult) -> tuple[int, float]:
    """Degrees of freedom and the largest von Mises stress of the first case."""
    case = first_case(result)
    return case.mesh.points.size, case.max_von_mises


def _calculix_body(computation: Computation, _: Study) -> Measured:
    start = time.perf_counter()
    loaded, quantity = _BODIES[computation.problem]
    body = loaded(computation.size, computation.order)
    stress = _calculix(body.mesh, body.material, body.forces, body.fixed)
    value = quantity(body.mesh, stress)
    return _measured(computation, body.mesh, time.perf_counter() - start, value)


def _calculix_rod(computation: Computation, study: Study) -> Measured:
    clock = Clock()
    asked = _meshed(computation, study)
    rod = prepare(asked, clock)
    mesh = rod.mesh.cell
    loads = rod.loading.at(rod.mass, study.speeds()[0])
    (response, *_) = rod.prescribed.respond(loads.cases)
    forces = response.forces.symmetric
    held = asked.analysis.support == "clamped"
    fixed = clamped(mesh, Surface.BIG_END_BORE) if held else determinate_restraints(mesh)
    # Geometry, mesh and loads are made by fea for both programs; the time of fea's assembly is not counted
    # here.
    before = sum(clock.seconds[stage] for stage in ("geometry", "mesh", "loads"))
    start = time.perf_counter()
    stress = _calculix(mesh, rod.materials[0], forces, fixed)
    seconds = before + time.perf_counter() - start
    return _measured(computation, mesh, seconds, float(np.nanmax(von_mises(stress))))


def _measured(computation: Computation, mesh: TetMesh, seconds: float, value: float) -> Measured:
    return Measured(computation.size, mesh.points.size, seconds, peak_memory(of_children=True), value)


def _calculix(mesh: TetMesh, material: Material, forces: Floats, fixed: npt.NDArray[np.bool_]) -> Floats:
    """Nodal stress (n_nodes, 6) computed by CalculiX on a mesh."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        write_inp(folder / "job.inp", mesh, material, forces, fixed)
        # CalculiX uses one thread by default.
        environment = os.environ | {"OMP_NUM_THREADS": str(threads())}
        command = ["ccx", "-i", "job"]
        subprocess.run(command, cwd=folder, capture_output=True, check=True, env=environment)  # noqa: S603
        return read_frd(folder / "job.frd", "STRESS", len(mesh.points))
