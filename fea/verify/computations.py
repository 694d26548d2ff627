"""The computations of the comparison, each run in a separate process, and the rod's reference."""

import dataclasses
import math
import os
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fea.analysis.meshing import mesh_study
from fea.analysis.pipeline import prepare, refined_rod, solve_speed
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.refinement import wanted_sizes
from fea.analysis.speed_result import SpeedResult
from fea.base.choices import Element, Symmetry
from fea.base.material import Material
from fea.judge.case_result import CaseResult
from fea.judge.verdict import peak
from fea.machine.clock import Clock
from fea.machine.system import peak_memory
from fea.machine.threads import threads
from fea.output.inp import Step, read_frd, write_deck
from fea.output.json_file import JsonObject
from fea.solid.stress import von_mises
from fea.solid.supports import clamped, determinate_restraints
from fea.study.option_tables import MeshTable
from fea.study.study import Study
from fea.verify.cases.elasticity import (
    GOODIER_EQUATOR,
    LAME_HOOP,
    goodier_body,
    goodier_equator,
    lame_body,
    lame_hoop,
)
from geometry.arrays import Floats
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh


@dataclass(frozen=True)
class Computation:
    """A computation: problem, tool, element and size."""

    #: ``fea``, ``fea, mean`` (stress at the boundary averaged over elements, as inside), ``fea, whole`` (no
    #: mirror plane used), ``fea --tolerance`` (from the default size, or with a ``--size``) or ``CalculiX``
    tool: str
    element: str  #: ``p1`` or ``p2``
    problem: str  #: ``rod``, ``lame`` or ``goodier``
    size: float  #: element size, mm, or the tolerance in percent for ``--tolerance``
    #: element size, mm, from which the refinement to a tolerance starts; None for the default
    first_size: float | None = None

    @property
    def adaptive(self) -> bool:
        """Whether `size` is a tolerance."""
        return self.tool.endswith("--tolerance")

    @property
    def name(self) -> str:
        """The tool, with the tolerance if there is one."""
        return f"{self.tool} {self.size:g}" if self.adaptive else self.tool

    @property
    def order(self) -> int:
        """1 or 2."""
        return int(self.element[1])

    @property
    def series(self) -> tuple[str, str, str]:
        """Key of the series: computations that differ only in the size."""
        return self.problem, self.tool, self.element


QUANTITY = {
    "rod": "rod: largest von Mises stress",
    "lame": f"lame: {LAME_HOOP}",
    "goodier": f"goodier: {GOODIER_EQUATOR}",
}


@dataclass(frozen=True)
class ConvergenceRow:
    """A computation with its outcome."""

    computation: Computation
    size: float  #: element size, mm (of the first mesh if there are several)
    dofs: int  #: degrees of freedom of the meshed body (the whole rod)
    seconds: float  #: wall time from the geometry to the stress, the median of its runs
    peak_memory: float  #: peak memory of the process, MiB
    value: float  #: the quantity, MPa
    error_bar: float | None = None  #: estimated error of the value, MPa; None where nothing estimates it
    error_percent: float = math.nan  #: error of the value, once there is a reference

    @property
    def bar_percent(self) -> float | None:
        """The estimated error relative to the value, percent; None where nothing estimates it."""
        return None if self.error_bar is None else 100 * self.error_bar / self.value

    def as_dict(self) -> JsonObject:
        """Return the row with the names that other programs rely on."""
        return {
            "tool": self.computation.tool,
            "element": self.computation.element,
            "size_mm": self.size,
            "dofs": self.dofs,
            "seconds": self.seconds,
            "peak_memory_MiB": self.peak_memory,
            "quantity": QUANTITY[self.computation.problem],
            "value": self.value,
            "error_bar_percent": self.bar_percent,
            "error_percent": self.error_percent,
        }


_BODIES = {"lame": (lame_body, lame_hoop), "goodier": (goodier_body, goodier_equator)}
# Element size of the warm-up on Lamé's cylinder, mm.
_TINY = 8.0


def compute(computation: Computation, study: Study) -> ConvergenceRow:
    """Run a computation; `study` is that of the rod."""
    # A small model imports and starts every library: this time is not part of the comparison.
    loaded, quantity = _BODIES["lame"]
    solved = loaded(_TINY, computation.order).solved()
    quantity(solved.mesh, solved.stress)
    of_rod, by_calculix = computation.problem == "rod", computation.tool == "CalculiX"
    if of_rod and by_calculix:
        return _calculix_rod(computation, study)
    start = time.perf_counter()
    size, dofs, value, bar = _rod(computation, study) if of_rod else _body(computation)
    seconds = time.perf_counter() - start
    return ConvergenceRow(computation, size, dofs, seconds, peak_memory(of_children=by_calculix), value, bar)


def _body(computation: Computation) -> tuple[float, int, float, None]:
    loaded, quantity = _BODIES[computation.problem]
    body = loaded(computation.size, computation.order)
    if computation.tool == "CalculiX":
        stress = _calculix(body.mesh, {"material": body.material}, Step("", body.forces, body.fixed))
    else:
        if computation.tool == "fea, mean":
            body = dataclasses.replace(body, known=(), traction=None)
        stress = body.solved().stress
    return computation.size, body.mesh.points.size, quantity(body.mesh, stress).computed, None


def _rod(computation: Computation, study: Study) -> tuple[float, int, float, float]:
    speed, clock = study.speeds()[0], Clock()
    if computation.adaptive:
        options = dataclasses.replace(study.analysis, tolerance_percent=computation.size)
        table = MeshTable(size_mm=computation.first_size)
        refined = refined_rod(dataclasses.replace(study, mesh=table, analysis=options), (speed,), clock)
        return refined.rod.mesh.meshing.size, *_peak(refined.at(speed))
    rod = prepare(_meshed(computation, study), clock, known_traction=computation.tool != "fea, mean")
    return computation.size, *_peak(solve_speed(rod, speed))


def _meshed(computation: Computation, study: Study) -> Study:
    symmetry = Symmetry.NONE if computation.tool in ("fea, whole", "CalculiX") else study.analysis.symmetry
    options = dataclasses.replace(study.analysis, symmetry=symmetry, tolerance_percent=None, cycle=False)
    table = MeshTable(size_mm=computation.size, element=Element(computation.element))
    return dataclasses.replace(study, mesh=table, analysis=options)


def _peak(result: SpeedResult) -> tuple[int, float, float]:
    """Degrees of freedom, the largest von Mises stress of the first case and its error bar, MPa."""
    case = first_case(result)
    return case.mesh.points.size, case.max_von_mises, case.peak.bar


def calculix_refuses(study: Study) -> str:
    """Why CalculiX cannot solve the rod as one linear body; empty if it can."""
    if study.assembly is not None:
        return "CalculiX is left out for the rod: separate parts in contact are not one linear body."
    return ""


def _calculix_rod(computation: Computation, study: Study) -> ConvergenceRow:
    """Solve the rod by CalculiX, under the nodal forces that the pins exert in `fea` on the same mesh."""
    clock = Clock()
    meshed = _meshed(computation, study)
    rod = prepare(meshed, clock)
    mesh = rod.mesh.cell
    loads = rod.loading.at(rod.mass, study.speeds()[0])
    # Geometry, mesh and loads are made by fea for both programs; the time in which fea assembles, and finds
    # where the pins touch, is not counted here.
    before = sum(clock.seconds[stage] for stage in ("geometry", "mesh", "loads"))
    (response, *_) = rod.pins.respond(loads.cases[:1])
    held = meshed.analysis.support == "clamped"
    fixed = clamped(mesh, Surface.BIG_END_BORE) if held else determinate_restraints(mesh)
    materials = dict(zip(rod.mesh.parts, rod.materials, strict=True))
    start = time.perf_counter()
    stress = _calculix(mesh, materials, Step("", response.forces.symmetric, fixed))
    seconds = before + time.perf_counter() - start
    largest = _peak_of_counted(rod, stress)
    memory = peak_memory(of_children=True)
    return ConvergenceRow(computation, computation.size, mesh.points.size, seconds, memory, largest)


def _peak_of_counted(rod: PreparedRod, stress: Floats) -> float:
    """Largest von Mises stress, MPa, away from the singular places that `fea` leaves out."""
    value = np.nan_to_num(von_mises(stress))
    return peak(value, np.zeros_like(value), rod.fields.errors.masked).value


def _calculix(mesh: TetMesh, materials: Mapping[str, Material], step: Step) -> Floats:
    """Nodal stress (n_nodes, 6) computed by CalculiX on a mesh, whose parts have these materials."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        write_deck(folder / "job.inp", mesh, materials, [step], ["static load case"])
        # CalculiX uses one thread by default.
        environment = os.environ | {"OMP_NUM_THREADS": str(threads())}
        command = ["ccx", "-i", "job"]
        subprocess.run(command, cwd=folder, capture_output=True, check=True, env=environment)  # noqa: S603
        return read_frd(folder / "job.frd", "STRESS", len(mesh.points))


# Orders outside this range are accidents of irregular meshes.
LEAST_ORDER, LARGEST_ORDER = 1.0, 3.0
# Safety factor of Roache 1994, for three meshes or more.
SAFETY = 1.25


@dataclass(frozen=True)
class Reference:
    """A reference value."""

    value: float  #: MPa
    uncertainty_percent: float = 0.0  #: uncertainty of the value; 0 if it is exact


def extrapolated(sizes: Sequence[float], values: Sequence[float]) -> Reference:
    """Richardson extrapolation of the three finest meshes with Roache's (1994) grid convergence index.

    The order p solves (f3 − f2) / (f2 − f1) = r^p for the constant ratio r of the sizes. If the values do not
    converge monotonically, the value of the finest mesh is used, with the spread of the three as uncertainty.
    With fewer than three values, coarse to fine, the uncertainty is unknown (infinite).
    """
    if len(values) < 3:
        return Reference(values[-1], float("inf"))
    coarse, medium, fine = values[-3:]
    ratio = sizes[-2] / sizes[-1]
    first, second = medium - coarse, fine - medium
    spread = 100 * (max(coarse, medium, fine) - min(coarse, medium, fine)) / abs(fine)
    if second == 0 or first / second <= 1:
        return Reference(fine, spread)
    order = float(np.clip(np.log(first / second) / np.log(ratio), LEAST_ORDER, LARGEST_ORDER))
    change = second / (ratio**order - 1)
    return Reference(fine + change, 100 * SAFETY * abs(change / fine))


# Sizes of the meshes relative to the default size, in constant ratio, and the additional factor on the
# element size where the stress exceeds a fraction of the peak.
SCALES = (1.0, 0.75, 0.5625)
HOT = {0.75: 1 / 2.0, 0.9: 1 / 5.0}


def rod_reference(study: Study) -> Reference:
    """Extrapolate the largest von Mises stress of the first case at the first speed.

    All elements shrink in proportion from mesh to mesh, so that Richardson extrapolation applies. They are
    smallest at the peak, because equally fine uniform meshes would not fit into memory.
    """
    options = dataclasses.replace(study.analysis, tolerance_percent=None, cycle=False)
    plain = dataclasses.replace(study, analysis=options, mesh=MeshTable())
    speed = study.speeds()[0]
    rod = prepare(plain)
    mesh, case = rod.mesh, first_case(solve_speed(rod, speed))
    del rod
    values = []
    for scale in SCALES:
        ratio = np.ones_like(case.von_mises)
        for share, factor in HOT.items():
            ratio[case.von_mises > share * case.peak.value] = scale * factor
        wanted = wanted_sizes(mesh, ratio)
        fine = dataclasses.replace(plain, mesh=MeshTable(size_mm=scale * mesh.meshing.size))
        rod = prepare(fine, mesh=mesh_study(fine, wanted=[wanted] if wanted else []))
        values.append(first_case(solve_speed(rod, speed)).max_von_mises)
        del rod
    return extrapolated(SCALES, values)


def first_case(result: SpeedResult) -> CaseResult:
    """Return the first load case of a speed."""
    return next(iter(result.cases.values()))
