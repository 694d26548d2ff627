"""Run a study: check where its runs belong, mesh its rod, and meanwhile load what the rest needs."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fea.analysis.meshing import adaptive_mesh
from fea.apps.run_places import places_of
from fea.machine.clock import Clock, Listener
from fea.machine.threads import imported_meanwhile
from fea.output.pictures.process import ready_to_draw
from fea.output.units import shown_in
from fea.output.vtu import LIBRARIES
from fea.rod.discretise import drawn_once
from fea.study.study import Study

if TYPE_CHECKING:
    from fea.apps.write_run import WrittenRun

# What every run loads once it has a mesh. The flaws of a coarse mesh are measured with the first, so that
# meshing may wait for its import.
AFTER_THE_MESH = ("fea.solid.inertia", "fea.apps.write_run", "fea.pins.contact", *LIBRARIES)


def run_study(
    study: Study, listener: Listener | None = None, ahead: Sequence[str] = ()
) -> "list[WrittenRun]":
    """Analyse a study at each of its speeds, and write and return the runs in the order of the speeds.

    The listener is told the name of each stage as it begins. The modules `ahead` are imported in a second
    thread while the rod is drawn and meshed. Raises `InvalidValue`: a value breaks a rule; `OccupiedError`,
    `StorageError`: the output directory cannot take the run; `GeometryError`, `MeshError`,
    `UnderconstrainedError`, `SingularMatrixError`, `SolverUnavailableError`: see the stages.
    """
    places = places_of(study)
    clock = Clock(listener)
    with ready_to_draw(wanted=bool(study.output.screenshot or study.output.report)), drawn_once():
        with imported_meanwhile(() if study.rod.from_file else ahead):  # a file is read in a fork
            mesh = adaptive_mesh(study, clock)
        from fea.apps.write_run import write_runs  # noqa: PLC0415 - what solves is loaded while gmsh meshes

        with shown_in(study.output.units):
            return write_runs(study, mesh, places, clock, listener)
