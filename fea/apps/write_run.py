"""Solve every speed of a study and write each run complete into its directory."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fea.analysis.many_speeds import MOST_FULL_RUNS, SpeedSweep, case_rows, opening_speeds, speed_map
from fea.analysis.pipeline import RefinedRod, refined_rod
from fea.analysis.result import ELSEWHERE, RunResult, gathered_result, run_result
from fea.analysis.speed_result import SpeedResult
from fea.analysis.summary_figures import Summary
from fea.machine.clock import Clock, Listener
from fea.output.folder import REPORT, csv_text, run_folder, write_columns, write_text
from fea.output.pictures.animation import filmed, write_film
from fea.output.plots.forces import plot_speed_map
from fea.output.run_files import write_run
from fea.rod.meshed_rod import MeshedRod
from fea.study.study import Study

if TYPE_CHECKING:
    from fea.apps.run_study import RunPlace

# Beside the folders of several speeds.
CASE_MAP = "map.csv"
CYCLE_MAP = ("cycle_map.csv", "cycle_map.png")


@dataclass(frozen=True)
class WrittenRun:
    """One speed's run in its folder."""

    folder: Path
    summary: Summary  #: what its `summary.json` says
    without_pictures: str = ""  #: why pictures or the animation are missing although they were asked for
    film: Path | None = None  #: the animation's file
    frames: bytes = b""  #: what it holds


OneRun = tuple[WrittenRun, SpeedResult, RunResult]


def write_runs(
    study: Study,
    mesh: MeshedRod,
    places: "Sequence[RunPlace]",
    target: Path,
    *,
    clock: Clock,
    listener: Listener | None = None,
) -> list[WrittenRun]:
    """Solve a study and write each speed's run into its place, all of them inside the target or none.

    See `fea.apps.run_study.run_study`.
    """
    prepared = refined_rod(study, [place.rpm for place in places], clock, listener, mesh)
    if len(places) == 1:
        result = run_result(study, prepared, prepared.at(places[0].rpm))
        if study.output.report:
            from fea.apps.what_if.solve import what_if  # noqa: PLC0415 - only a report needs it

            result = dataclasses.replace(result, what_if=what_if(result, clock))
        with run_folder(target) as part:
            reports = [_write(result, prepared, places[0]._replace(folder=part), clock)]
    else:
        with run_folder(target) as part:
            parts = [place._replace(folder=part / place.folder.name) for place in places]
            reports = _write_all(study, prepared, parts, clock)
    for report in reports:
        if report.film is not None:
            write_film(report.film, report.frames)
    both = zip(reports, places, strict=True)
    return [dataclasses.replace(report, folder=place.folder) for report, place in both]


def _write_all(
    study: Study, prepared: RefinedRod, places: "Sequence[RunPlace]", clock: Clock
) -> list[WrittenRun]:
    shown = bool(study.output.screenshot) or study.analysis.buckling or any(place.film for place in places)
    sweep, speeds = None, [place.rpm for place in places if place.rpm is not None]
    if study.analysis.cycle:
        with clock("map"):
            sweep = SpeedSweep(prepared.rod, speeds)
    critical = opening_speeds(prepared.rod, speeds) or None if sweep is None else sweep.critical
    if sweep is not None and len(places) > MOST_FULL_RUNS and not shown:
        reports, worst = _write_worst(study, prepared, sweep, places, clock)
    else:
        reports, worst = list[WrittenRun](), None
        for place in places:
            each = _write_one(study, prepared, critical, place, clock)
            reports.append(each[0])
            worst = each if worst is None else min(worst, each, key=_assured)
    if study.output.report and worst is not None:
        _with_what_if(worst[0], worst[2], clock)
    above, summaries = places[0].folder.parent, [report.summary for report in reports]
    write_text(above / CASE_MAP, csv_text(case_rows(summaries)))
    found = speed_map(summaries)
    if found is not None:
        with clock("plot"):
            table, plot = CYCLE_MAP
            write_columns(above / table, found.columns)
            plot_speed_map(above / plot, study.name, found)
    return reports


def _write_worst(
    study: Study, prepared: RefinedRod, sweep: SpeedSweep, places: "Sequence[RunPlace]", clock: Clock
) -> tuple[list[WrittenRun], OneRun]:
    full = {
        place.rpm: _write_one(study, prepared, sweep.critical, place, clock)
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
        found = gathered_result(study, prepared.rod, summary)
        written, _ = write_run(place.folder, found, clock, shared_files=_shared(study))
        reports.append(WrittenRun(place.folder, written))
    return reports, min(full.values(), key=_assured)


def _assured(run: OneRun) -> float:
    return run[0].summary.survival.assured_safety_factor


def _with_what_if(written: WrittenRun, found: RunResult, clock: Clock) -> None:
    """Write the report of the speed that governs again, with what only that speed is solved for."""
    from fea.apps.what_if.solve import what_if  # noqa: PLC0415 - only a report needs it
    from fea.output.report.page import write_report  # noqa: PLC0415 - only a report needs it

    write_report(written.folder / REPORT, dataclasses.replace(found, what_if=what_if(found, clock)))


def _write_one(
    study: Study,
    prepared: RefinedRod,
    critical: Mapping[str, float | None] | None,
    place: "RunPlace",
    clock: Clock,
) -> OneRun:
    solved = prepared.at(place.rpm)
    found = dataclasses.replace(run_result(study, prepared, solved), what_if=ELSEWHERE)
    if critical is not None:
        summary = dataclasses.replace(found.summary, critical_speeds_rpm=critical)
        found = dataclasses.replace(found, summary=summary)
    return _write(found, prepared, place, clock, shared_files=_shared(study)), solved, found


def _write(
    found: RunResult,
    prepared: RefinedRod,
    place: "RunPlace",
    clock: Clock,
    shared_files: tuple[str, ...] | None = None,
) -> WrittenRun:
    place.folder.mkdir(exist_ok=True)
    frames, refused = b"", ""
    if place.film is not None and place.rpm is not None:
        frames, refused = filmed(prepared.rod, place.rpm, place.film, clock)
    written, without_pictures = write_run(place.folder, found, clock, shared_files=shared_files)
    film = place.film if frames else None
    return WrittenRun(place.folder, written, without_pictures or refused, film, frames)


def _shared(study: Study) -> tuple[str, ...]:
    return (CASE_MAP, *CYCLE_MAP) if study.analysis.cycle else (CASE_MAP,)
