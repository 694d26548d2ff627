"""The job behind `fea run`: analyse every speed and leave each run complete in its directory."""

import csv
import dataclasses
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fea.analysis.adapt import Adapted, analysed
from fea.analysis.buckling import BUCKLING_COLUMNS, buckling_factors, buckling_report
from fea.analysis.force_table import cycle_columns
from fea.analysis.pipeline import Analysis, SpeedResult
from fea.analysis.speed_map import speed_map
from fea.analysis.speed_sweep import MOST_FULL_RUNS, SpeedSweep
from fea.analysis.summary import summary
from fea.cycle.superposition import CycleResult
from fea.machine.clock import Clock
from fea.output.errors import PictureError
from fea.output.folder import require_replaceable, run_folder
from fea.output.forces_csv import write_cycle_csv
from fea.output.pictures.animation import require_film, write_film
from fea.output.pictures.film import animation_file, filmed
from fea.output.summary import json_text
from fea.output.text import write_text
from fea.output.vtu import write_vtu
from fea.study.study import Study

# Speed, rpm, directory and animation of a run.
Run = tuple[float | None, Path, Path | None]


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
    summary: dict[str, Any]
    complaint: str = ""
    film: Path | None = None
    pages: bytes = b""


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
    speeds: Sequence[float | None] = study.speed.speeds() if study.engine else (None,)
    folders = _folders(study, speeds)
    films = [animation_file(study, rpm) for rpm in speeds]
    one = len(folders) == 1
    target = folders[0] if one else folders[0].parent
    require_replaceable(target)
    for film in films:
        if film is not None:
            require_film(film)
    clock = Clock(listener)
    adapted = analysed(study, speeds, clock, listener)
    with run_folder(target) as place:
        if one:
            reports = [_leave(adapted, adapted.at(speeds[0]), place, films[0], clock)]
        else:
            places = [place / folder.name for folder in folders]
            reports = _leave_all(adapted, list(zip(speeds, places, films, strict=True)), clock)
    for report in reports:
        if report.film is not None:
            write_film(report.film, report.pages)
    return [
        dataclasses.replace(report, folder=folder) for report, folder in zip(reports, folders, strict=True)
    ]


def _leave_all(adapted: Adapted, runs: Sequence[Run], clock: Clock) -> list[RunReport]:
    """Write the runs of several speeds, and what tells them all."""
    study = adapted.analysis.study
    shown = study.output.screenshot or study.analysis.buckling or any(film for _, _, film in runs)
    sweep = _sweep(adapted, [rpm for rpm, _, _ in runs], clock) if study.analysis.cycle else None
    if sweep is not None and len(runs) > MOST_FULL_RUNS and not shown:
        reports = _swept(adapted, sweep, runs, clock)
    else:
        reports = [
            _leave(adapted, adapted.at(rpm), folder, film, clock, sweep=sweep) for rpm, folder, film in runs
        ]
    place = runs[0][1].parent
    write_text(place / "map.csv", map_text(reports))
    with clock("plot"):
        _map_speeds(place, study.name, reports)
    return reports


def _sweep(adapted: Adapted, speeds: Sequence[float | None], clock: Clock) -> SpeedSweep:
    with clock("map"):
        return SpeedSweep(adapted.analysis, [rpm for rpm in speeds if rpm is not None])


def _swept(
    adapted: Adapted,
    sweep: SpeedSweep,
    runs: Sequence[Run],
    clock: Clock,
) -> list[RunReport]:
    """Leave full runs at the worst of many speeds, and at the others their figures."""
    full = {
        rpm: _leave(adapted, adapted.at(rpm), folder, film, clock, sweep=sweep)
        for rpm, folder, film in runs
        if rpm in sweep.worst
    }
    folders = [folder for _, folder, _ in runs]
    reports = []
    for rpm, folder, _ in runs:
        if rpm is None or rpm in full:
            continue
        folder.mkdir()
        with clock("write"):
            _write_study(folder, adapted.analysis, rpm)
            near = min(full, key=lambda other: (other < rpm, abs(other - rpm)))  # inertia grows with speed
            figures = sweep.summary(full[near].summary, rpm)
            write_text(folder / "summary.json", json_text(figures))
        reports.append(RunReport(folder, figures))
    return sorted([*reports, *full.values()], key=lambda report: folders.index(report.folder))


def _map_speeds(place: Path, study: str, reports: Sequence[RunReport]) -> None:
    found = speed_map([report.summary for report in reports])
    if found is not None:
        from fea.output.plots.speed_map import plot_speed_map, write_speed_map  # noqa: PLC0415 - only a sweep needs it

        write_speed_map(place / "cycle_map.csv", found)
        plot_speed_map(place / "cycle_map.png", study, found)


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


def _leave(
    adapted: Adapted,
    result: SpeedResult,
    folder: Path,
    film: Path | None,
    clock: Clock,
    *,
    sweep: SpeedSweep | None = None,
) -> RunReport:
    """Write one speed's run, of a `sweep` or alone, into its directory, which is made where it is missing."""
    folder.mkdir(exist_ok=True)
    analysis = adapted.analysis
    mesh = analysis.mesh.whole.mesh
    buckling = buckling_report(analysis, result, clock)
    result = dataclasses.replace(
        result, checks=result.checks | buckling.checks, left_out=(*result.left_out, *buckling.left_out)
    )
    with clock("write"):
        for case in result.cases:
            write_vtu(
                folder / f"{case.case.name}.vtu",
                mesh,
                case.point_data(),
                case.cell_data(mesh, analysis.materials),
            )
        _write_study(folder, analysis, result.rpm)
        if result.cycle is not None:
            write_vtu(folder / "envelope.vtu", mesh, result.cycle.envelope.point_data())
        if buckling.shapes:
            write_vtu(folder / "buckling.vtu", mesh, buckling.shapes)
    if result.cycle is not None:
        with clock("plot"):
            _plot_history(folder / "history.png", analysis.study.name, result, result.cycle)
    figures = summary(analysis, result, buckling.figures, clock, adapted.passes)
    if sweep is not None:
        figures["critical_speeds_rpm"] = sweep.critical
    complaint, pages = "", b""
    if analysis.study.output.screenshot:
        complaint = _take_pictures(folder, figures, clock)
    if film is not None and result.rpm is not None:
        pages, refused = filmed(analysis, result.rpm, film, clock)
        complaint = complaint or refused
    figures["timings_s"], figures["total_s"] = dict(clock.seconds), clock.total
    write_text(folder / "summary.json", json_text(figures))
    return RunReport(folder, figures, complaint, film if pages else None, pages)


def _write_study(place: Path, analysis: Analysis, rpm: float | None) -> None:
    """Write the study at one speed, and its cycle."""
    write_text(place / "study.toml", _study_text(analysis.study, rpm))
    if analysis.engine is not None and analysis.gas is not None and rpm is not None:
        write_cycle_csv(place / "loads.csv", cycle_columns(analysis.engine, analysis.rod, analysis.gas, rpm))


def _plot_history(path: Path, study: str, result: SpeedResult, cycle: CycleResult) -> None:
    from fea.output.plots.history import plot_histories  # noqa: PLC0415 - only a plot needs it

    plot_histories(
        path,
        f"{study} at {result.rpm:g} rpm",
        cycle.angles,
        [(spot.place.tolist(), spot.signed) for spot in cycle.spots],
        {
            case.case.name: case.case.crank_angle
            for case in result.cases
            if case.case.crank_angle is not None and case.case.motion is not None
        },
    )


def _take_pictures(place: Path, figures: dict[str, Any], clock: Clock) -> str:
    """Take the pictures; a machine that cannot draw still keeps the figures."""
    from fea.output.pictures.picture import take_pictures  # noqa: PLC0415 - only a picture needs it

    try:
        with clock("picture"):
            take_pictures(place, figures)
    except PictureError as error:
        return str(error)
    return ""


def _study_text(study: Study, rpm: float | None) -> str:
    # Not where the files of the run went: run again from there, it would replace its sweep, or fill the run.
    output = dataclasses.replace(study.output, directory=None, animate=None)
    speed = study.speed if rpm is None else dataclasses.replace(study.speed, rpm=rpm)
    return dataclasses.replace(study, speed=speed, output=output).text()


def map_text(reports: Sequence[RunReport]) -> str:
    """The extremes of every run as CSV, a row a speed and case."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    figures = ("crank_deg", "pin_axial_N", "crank_axial_N", "max_von_mises_MPa", "min_safety_factor")
    writer.writerow(["rpm", "case", *figures, *BUCKLING_COLUMNS])
    for report in reports:
        loads = report.summary["loads"]
        for name, result in report.summary["results"].items():
            load = loads[name]
            values = (
                load["crank_deg"],
                load["pin_axial_N"],
                load["crank_axial_N"],
                result["max_von_mises_MPa"],
                result["min_safety_factor"],
                *buckling_factors(report.summary["buckling"], name),
            )
            row = ["" if value is None else f"{value:.7g}" for value in values]
            writer.writerow([f"{report.summary['rpm']:g}", name, *row])
    return text.getvalue()
