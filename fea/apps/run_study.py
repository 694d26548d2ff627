"""Run a study: check where its runs belong, mesh its rod, and meanwhile load what the rest needs."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from fea.analysis.meshing import adaptive_mesh
from fea.machine.clock import Clock, Listener
from fea.machine.threads import imported_meanwhile
from fea.output.folder import require_replaceable
from fea.output.pictures.picture import ready_to_draw
from fea.output.units import shown_in
from fea.output.vtu import LIBRARIES
from fea.rod.discretise import drawn_once
from fea.study.study import Study
from geometry.errors import require

if TYPE_CHECKING:
    from fea.apps.write_run import WrittenRun


class RunPlace(NamedTuple):
    """Destination of a run: its speed in rpm, its folder, and the file of its animation."""

    rpm: float | None
    folder: Path
    film: Path | None


def places_of(study: Study) -> list[RunPlace]:
    """Return the place of each speed's run, where it may be written.

    Raises `InvalidValue`: an animation cannot be written, or is requested without the cycle; `OccupiedError`,
    `StorageError`: the output directory cannot take the run.
    """
    speeds = study.speeds()
    folders = _folders(study, speeds)
    places = [RunPlace(rpm, folder, _film(study, rpm)) for rpm, folder in zip(speeds, folders, strict=True)]
    require_replaceable(target_of(places))
    for film in (place.film for place in places if place.film is not None):
        from fea.output.pictures.animation import require_film  # noqa: PLC0415 - only a film needs it

        require_film(film)
    return places


def target_of(places: Sequence[RunPlace]) -> Path:
    """Return the directory that is replaced as a whole: a run's own, or the one above several."""
    return places[0].folder if len(places) == 1 else places[0].folder.parent


def _folders(study: Study, speeds: Sequence[float | None]) -> list[Path]:
    given = study.output.directory
    if len(speeds) == 1:
        name = study.name if speeds[0] is None else f"{study.name}-{speeds[0]:g}rpm"
        return [Path("results") / name if given is None else study.folder / given]
    parent = Path("results") / study.name if given is None else study.folder / given
    return [parent / f"{rpm:g}rpm" for rpm in speeds]


def _film(study: Study, rpm: float | None) -> Path | None:
    if study.output.animate is None:
        return None
    rule = "has no effect without the crank cycle"
    require(study.analysis.cycle, "--animate", study.output.animate, rule, "Add --cycle.")
    path = study.folder / study.output.animate
    speeds = study.speeds()
    return path if len(speeds) == 1 else path.with_stem(f"{path.stem}-{rpm:g}rpm")


# What every run loads once it has a mesh. The flaws of a coarse mesh are measured with the first, so that
# meshing may wait for its import.
AFTER_THE_MESH = ("fea.solid.inertia", "fea.apps.write_run", "fea.pins.contact", *LIBRARIES)


def run_study(
    study: Study, listener: Listener | None = None, ahead: Sequence[str] = ()
) -> "list[WrittenRun]":
    """Analyse a study at each of its speeds, and write and return the runs in the order of the speeds.

    The listener receives the name of each stage as it begins. The modules `ahead` are imported in a second
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
            return write_runs(study, mesh, places, target_of(places), clock=clock, listener=listener)
