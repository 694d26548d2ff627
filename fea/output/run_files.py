"""The files of a run: every output format is one writer of `WRITERS`.

A writer yields the files that it has for a run. The names of all that were written are the manifest in
`summary.json`, by which `fea.output.earlier` recognises a run: a new format needs nothing but its writer.
"""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

from fea.analysis.force_table import force_columns
from fea.analysis.outcome import Outcome
from fea.assess.case_result import CaseResult
from fea.machine.clock import Clock
from fea.output.forces_csv import write_forces_csv
from fea.output.text import write_text
from fea.output.vtu import write_vtu
from fea.rod.load_cases import EngineLoading

SUMMARY = "summary.json"


class RunFile(NamedTuple):
    """A file to be written: its name in the folder of the run, and what writes it to a path."""

    name: str
    write: Callable[[Path], None]


class Writer(NamedTuple):
    """An output format: the stage that its time counts for, and the files that it has for a run."""

    stage: str
    files: Callable[[Outcome], Iterator[RunFile]]


def _case_fields(run: Outcome) -> Iterator[RunFile]:
    for name, case in run.cases.items():
        yield RunFile(f"{name}.vtu", partial(_write_case, run, case))


def _write_case(run: Outcome, case: CaseResult, path: Path) -> None:
    write_vtu(path, run.mesh, case.point_data(), case.cell_data(run.materials))


def _study(run: Outcome) -> Iterator[RunFile]:
    yield RunFile("study.toml", lambda path: write_text(path, run.study.text()))


def _forces(run: Outcome) -> Iterator[RunFile]:
    if isinstance(run.loading, EngineLoading) and run.rpm is not None:
        columns = force_columns(run.loading.engine, run.mass, run.loading.gas, run.rpm)
        yield RunFile("loads.csv", lambda path: write_forces_csv(path, columns))


def _envelope(run: Outcome) -> Iterator[RunFile]:
    if run.cycle is not None:
        data = run.cycle.envelope.point_data()
        yield RunFile("envelope.vtu", lambda path: write_vtu(path, run.mesh, data))


def _buckling_shapes(run: Outcome) -> Iterator[RunFile]:
    if run.buckling is not None and run.buckling.shapes:
        shapes = run.buckling.shapes
        yield RunFile("buckling.vtu", lambda path: write_vtu(path, run.mesh, shapes))


def _stress_history(run: Outcome) -> Iterator[RunFile]:
    if run.cycle is not None:
        from fea.output.plots.history import plot_stress_history  # noqa: PLC0415 - only a plot needs it

        yield RunFile("history.png", lambda path: plot_stress_history(path, run))


WRITERS = (
    Writer("write", _case_fields),
    Writer("write", _study),
    Writer("write", _forces),
    Writer("write", _envelope),
    Writer("write", _buckling_shapes),
    Writer("plot", _stress_history),
)


def write_files(folder: Path, run: Outcome, clock: Clock) -> list[str]:
    """Write every file that a run has into its folder, but for pictures and the summary; return their names.

    Raises
    ------
    StorageError
        The disk, a permission or the file system refused.
    """
    names = []
    for writer in WRITERS:
        for file in writer.files(run):
            with clock(writer.stage):
                file.write(folder / file.name)
            names.append(file.name)
    return names


def picture_name(result: str) -> str:
    """Return the name of the picture of a result file, which stands beside it."""
    return Path(result).with_suffix(".png").name
