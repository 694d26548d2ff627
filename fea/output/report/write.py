"""Write the report of a run, beside the files that it has left."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fea.output.picture_name import picture_name
from fea.output.pictures.picture import draw_pictures
from fea.output.pictures.shown import described_by
from fea.output.report.bores import drawn_bores
from fea.output.report.page import page
from fea.output.report.reported import Reported
from fea.output.report.scene import scene
from fea.output.target import PictureError
from fea.output.text import write_text
from fea.rod.loading import EngineLoading
from fea.run.forces import force_columns
from fea.run.outcome import Outcome

_NOT_KEPT = "the cycle was analysed without what it needs (analyse(…, report=True) keeps that)"


def write_report(path: Path, run: Outcome) -> None:
    """Write the report of a run in memory into its folder, which holds its fields; errors as `leave`."""
    leave(path, reported(run))


def leave(path: Path, run: Reported) -> None:
    """Write a report; the still picture is that of the folder, or is drawn, or is left out.

    Raises
    ------
    StorageError
        The disk, a permission or the file system refused.
    """
    with ThreadPoolExecutor(1) as beside:  # another process draws meanwhile
        picture = beside.submit(copy_context().run, still, path.parent, run)
        drawn = scene(run)
        text = page(replace(run, picture=picture.result()), drawn)
    write_text(path, text)


def reported(run: Outcome) -> Reported:
    """Return what a report needs of a run in memory, but for the picture."""
    forces: Mapping[str, Any] | None = None
    if isinstance(run.loading, EngineLoading) and run.rpm is not None:
        forces = force_columns(run.loading.engine, run.mass, run.loading.gas, run.rpm)
    cycle = run.cycle
    return Reported(
        study=run.study,
        summary=run.summary,
        mesh=run.mesh if run.cases else None,
        cases={name: case.point_data() for name, case in run.cases.items()},
        envelope=None if cycle is None else cycle.envelope.point_data(),
        forces=forces,
        contact=cycle.contact_columns() if cycle is not None and cycle.touches else None,
        bores=drawn_bores(run.mesh, run.summary.rod.length_mm),
        motion=run.motion,
        without_motion="" if cycle is None or run.motion is not None else run.without_motion or _NOT_KEPT,
    )


def still(folder: Path, run: Reported) -> bytes | None:
    """The picture of the worst load case in a run's folder: the one there, or a new one; or None."""
    result = f"{run.summary.worst_case}.vtu"
    there = folder / picture_name(result)
    if there.is_file():
        return there.read_bytes()
    if not (folder / result).is_file():
        return None
    with TemporaryDirectory() as scratch:
        png = Path(scratch, there.name)
        try:
            draw_pictures([replace(described_by(run.summary, folder / result), png=png)])
        except PictureError:
            return None
        return png.read_bytes()
