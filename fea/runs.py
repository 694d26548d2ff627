"""The job behind `fea run`: analyse every speed and leave each run complete in its directory."""

import csv
import dataclasses
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from fea.analysis.adapt import Adapted, adapt_mesh
from fea.analysis.figures import Summary
from fea.analysis.outcome import outcome, outcome_of
from fea.analysis.speed import SpeedResult
from fea.analysis.speed_map import case_rows, speed_map
from fea.analysis.sweep import MOST_FULL_RUNS, SpeedSweep
from fea.machine.clock import Clock
from fea.output.folder import require_replaceable, run_folder
from fea.output.pictures.animation import require_film, write_film
from fea.output.pictures.film import animation_file, filmed
from fea.output.text import write_text
from fea.result import Result, result_of
from fea.study.study import Study

# Beside the folders of several speeds.
CASE_MAP = "map.csv"
CYCLE_MAP = ("cycle_map.csv", "cycle_map.png")


@dataclass(frozen=True)
class RunReport:
    """One speed's run.

    Attributes
    ----------
    folder
        Where it is.
    summary
        What its `summary.json` says.
    complaint
        Why there are no pictures, or no animation, although they were asked for; empty otherwise.
    film
        The animation's file, if there is one.
    pages
        What it holds.
    """

    folder: Path
    summary: Summary
    complaint: str = ""
    film: Path | None = None
    pages: bytes = b""


class _Place(NamedTuple):
    """Where a speed's run belongs: speed in rpm, folder, and file of its animation."""

    rpm: float | None
    folder: Path
    film: Path | None


def run_study(study: Study, listener: Callable[[str], None] | None = None) -> list[RunReport]:
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
    speeds = study.speeds()
    folders = _folders(study, speeds)
    films = [animation_file(study, rpm) for rpm in speeds]
    one = len(folders) == 1
    target = folders[0] if one else folders[0].parent
    require_replaceable(target)
    for film in films:
        if film is not None:
            require_film(film)
    clock = Clock(listener)
    prepared = adapt_mesh(study, speeds, clock, listener)
    with run_folder(target) as part:
        if one:
            found = result_of(outcome(study, prepared, prepared.at(speeds[0])))
            reports = [_leave(found, prepared, _Place(speeds[0], part, films[0]), clock)]
        else:
            places = [
                _Place(rpm, part / folder.name, film)
                for rpm, folder, film in zip(speeds, folders, films, strict=True)
            ]
            reports = _leave_all(study, prepared, places, clock)
    for report in reports:
        if report.film is not None:
            write_film(report.film, report.pages)
    return [
        dataclasses.replace(report, folder=folder) for report, folder in zip(reports, folders, strict=True)
    ]


def _leave_all(study: Study, prepared: Adapted, places: Sequence[_Place], clock: Clock) -> list[RunReport]:
    """Write the runs of several speeds, and the tables over all of them."""
    shown = study.output.screenshot or study.analysis.buckling or any(place.film for place in places)
    sweep = None
    if study.analysis.cycle:
        with clock("map"):
            sweep = SpeedSweep(prepared.rod, [place.rpm for place in places if place.rpm is not None])
    if sweep is not None and len(places) > MOST_FULL_RUNS and not shown:
        reports = _leave_worst(study, prepared, sweep, places, clock)
    else:
        reports = [_leave_one(study, prepared, sweep, place, clock)[0] for place in places]
    above, summaries = places[0].folder.parent, [report.summary for report in reports]
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(case_rows(summaries))
    write_text(above / CASE_MAP, text.getvalue())
    found = speed_map(summaries)
    if found is not None:
        from fea.output.plots.speed_map import plot_speed_map, write_speed_map  # noqa: PLC0415 - only a sweep

        with clock("plot"):
            table, plot = CYCLE_MAP
            write_speed_map(above / table, found)
            plot_speed_map(above / plot, study.name, found)
    return reports


def _leave_worst(
    study: Study, prepared: Adapted, sweep: SpeedSweep, places: Sequence[_Place], clock: Clock
) -> list[RunReport]:
    """Leave full runs at the worst of many speeds, and at the others their figures."""
    full = {
        place.rpm: _leave_one(study, prepared, sweep, place, clock)
        for place in places
        if place.rpm is not None and place.rpm in sweep.worst
    }
    reports = []
    for place in places:
        rpm = place.rpm
        if rpm is None or rpm in full:
            reports.append(full[rpm or 0.0][0])
            continue
        near = min(full, key=lambda other: (other < rpm, abs(other - rpm)))  # inertia grows with speed
        summary = sweep.summary(rpm, full[near][1], prepared.passes)
        place.folder.mkdir()
        found = result_of(outcome_of(study, prepared.rod, summary))
        written, _ = found.write_into(place.folder, clock, shared_files=_shared(study))
        reports.append(RunReport(place.folder, written))
    return reports


def _leave_one(
    study: Study, prepared: Adapted, sweep: SpeedSweep | None, place: _Place, clock: Clock
) -> tuple[RunReport, SpeedResult]:
    """Write the run of one speed of several; return what it left, and what was found at that speed."""
    solved = prepared.at(place.rpm)
    found = result_of(outcome(study, prepared, solved))
    if sweep is not None:
        summary = dataclasses.replace(found.summary, critical_speeds_rpm=sweep.critical)
        found = dataclasses.replace(found, summary=summary)
    return _leave(found, prepared, place, clock, shared_files=_shared(study)), solved


def _leave(
    found: Result,
    prepared: Adapted,
    place: _Place,
    clock: Clock,
    shared_files: tuple[str, ...] | None = None,
) -> RunReport:
    """Write one speed's run into its folder, which is made where it is missing."""
    place.folder.mkdir(exist_ok=True)
    pages, refused = b"", ""
    if place.film is not None and place.rpm is not None:
        pages, refused = filmed(prepared.rod, place.rpm, place.film, clock)
    written, complaint = found.write_into(place.folder, clock, shared_files=shared_files)
    return RunReport(place.folder, written, complaint or refused, place.film if pages else None, pages)


def _shared(study: Study) -> tuple[str, ...]:
    """Names of the files beside the folders of several speeds."""
    return (CASE_MAP, *CYCLE_MAP) if study.analysis.cycle else (CASE_MAP,)


def default_directory(study: Study, rpm: float | None) -> Path:
    """``results/<study>-<rpm>rpm``, or ``results/<study>`` where there is no speed."""
    return Path("results") / (study.name if rpm is None else f"{study.name}-{rpm:g}rpm")


def _folders(study: Study, speeds: Sequence[float | None]) -> list[Path]:
    given = study.output.directory
    if len(speeds) == 1:
        folder = default_directory(study, speeds[0]) if given is None else study.folder / given
        return [folder]
    parent = Path("results") / study.name if given is None else study.folder / given
    return [parent / f"{rpm:g}rpm" for rpm in speeds]
