"""The job behind `fea limits`: the largest speed and peak pressure of a rod, and a map of both, as files."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from fea.analysis.pipeline import refined_rod
from fea.analysis.result import run_result
from fea.apps.limits.drawn_map import DrawnMap
from fea.apps.limits.explore import RodLimits, explore, limited_speeds
from fea.apps.limits.figures import LimitPointFigures, LimitsFigures, figures_of, words
from fea.apps.limits.flawed import with_flaw
from fea.machine.clock import Clock
from fea.output.folder import REPORT, SUMMARY, require_replaceable, run_folder, write_text
from fea.output.json_file import json_text
from fea.output.stored_run import Run
from fea.study.study import Study, load_study
from geometry.errors import require_positive

STUDY, TABLE, MAP, LIFE = "study.toml", "limits.csv", "limits.png", "life.csv"
FILES = (STUDY, SUMMARY, TABLE, MAP, REPORT)
_EVERY = 8  # columns and rows of the map in the table of life
# How the answer begins that is shown before the map is made.
FIRST = "answer: "


def limits(
    study: Study | str | Path,
    folder: Path | None = None,
    listener: Callable[[str], None] | None = None,
    *,
    at_rpm: float | None = None,
    duty: bool = False,
    permanent_set: bool = False,
) -> LimitsFigures:
    """Find how fast a rod can turn and how much peak pressure it stands.

    Parameters
    ----------
    study
        A study, a shipped one by name, or the path of a TOML file.
    folder
        Where the files go; None for none.
    listener
        Called with the name of each stage as it begins.
    at_rpm
        Speed at which the largest peak pressure is found; default: that of the study, the highest.
    duty
        Whether hours of life are found also for a rod of separate parts, where they take long; also with
        [duty] in the study.
    permanent_set
        Whether the line is found from which the rod is left deformed beyond its limits, which takes minutes;
        also with [overload] in the study.

    Raises
    ------
    InvalidValue
        There is no engine, or a value of the study breaks a rule.
    OccupiedError, StorageError
        The folder cannot take the files.
    GeometryError, MeshError, UnderconstrainedError, SingularMatrixError, ContactError
        The rod cannot be drawn, meshed or solved.
    """
    study = study if isinstance(study, Study) else load_study(study)
    speeds = limited_speeds(study)
    if at_rpm is not None:
        require_positive("at_rpm", at_rpm)
    if folder is not None:
        require_replaceable(folder)
    clock = Clock(listener)
    asked = duty or study.duty is not None
    given, study = study, replace(study, duty=None, analysis=replace(study.analysis, cycle=True))
    adapted = refined_rod(study, [speeds[-1]], clock)
    show = listener or (lambda _text: None)

    def answered(first: RodLimits) -> None:
        show(FIRST + words(first))

    with clock("limits"):
        lives_at = speeds if asked or study.assembly is None else []
        with_set = permanent_set or study.overload is not None
        found = explore(
            adapted, speeds[-1], at_rpm, show, answered, lives_at=lives_at, permanent_set=with_set
        )
        found = found if asked else replace(found, no_life_because="")
        figures = with_flaw(figures_of(study, found, adapted, clock), found, show)
    files = FILES if found.life is None else (*FILES, LIFE)
    figures = replace(figures, files=files, timings_s=dict(clock.seconds), total_s=clock.total)
    if folder is not None:
        run = replace(run_result(study, adapted, found.static), study=given)
        with run_folder(folder) as part:
            write_files(part, run, found, figures, speeds)
    return figures


def write_files(
    folder: Path, run: Run, found: RodLimits, figures: LimitsFigures, speeds: list[float]
) -> None:
    """Write the files; `run`: that of the highest speed."""
    write_text(folder / STUDY, run.study.text())
    write_text(folder / SUMMARY, json_text(figures))
    head = "mode,rpm,peak_pressure_bar,gas_scale,bar_percent,interpolated,x_mm,y_mm,z_mm,crank_deg"
    lines = [head, *map(_row, figures.limits)]
    write_text(folder / TABLE, "\n".join(lines) + "\n")
    drawn = DrawnMap(found, figures, speeds)
    if drawn.hours is not None:
        rows, columns = (range(0, count, _EVERY) for count in drawn.hours.shape)
        cells = [
            f"{drawn.rpm[column]:.7g},{drawn.peak[row]:.7g},{drawn.hours[row, column]:.4g}"
            for column in columns
            for row in rows
        ]
        write_text(folder / LIFE, "\n".join(["rpm,peak_pressure_bar,hours", *cells]) + "\n")
    box = drawn.draw(folder / MAP)
    drawn.write_page(folder / REPORT, run, (folder / MAP).read_bytes(), box)


def _row(limit: LimitPointFigures) -> str:
    place = limit.at_mm or (None, None, None)
    first = (limit.rpm, limit.peak_pressure_bar, limit.gas_scale, limit.bar, limit.interpolated)
    values = (*first, *place, limit.crank_deg)
    return ",".join([limit.mode, *("" if value is None else f"{value:.7g}" for value in values)])
