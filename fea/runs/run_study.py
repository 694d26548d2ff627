"""Run a study: mesh its rod, then load what solves."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from fea.analysis.meshing import first_mesh
from fea.machine.clock import Clock
from fea.runs.places import places_of
from fea.study.study import Study

if TYPE_CHECKING:
    from fea.runs.leave import RunReport


def run_study(study: Study, listener: Callable[[str], None] | None = None) -> "list[RunReport]":
    """Analyse a study at each of its speeds and write the runs.

    Parameters
    ----------
    study
        What is asked.
    listener
        Told the name of each stage as it begins.

    Returns
    -------
    list of RunReport
        In the order of the speeds.

    Raises
    ------
    InvalidValue
        A value breaks a rule.
    OccupiedError, StorageError
        The output directory cannot take the run.
    GeometryError, MeshError, UnderconstrainedError, SingularMatrixError, SolverUnavailableError
        See the stages.
    """
    places = places_of(study)
    clock = Clock(listener)
    mesh = first_mesh(study, clock)
    from fea.runs.leave import leave_runs  # noqa: PLC0415 - only a mesh needs what solves

    return leave_runs(study, mesh, places, clock, listener)
