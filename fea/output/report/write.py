"""Write the report of a run, beside the files that it has left."""

from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from fea.analysis.figures import Summary
from fea.analysis.result import Run
from fea.base.choices import UnitSystem
from fea.output.pictures.picture import draw_pictures
from fea.output.pictures.shown import described_by
from fea.output.report.page import page
from fea.output.report.scene import scene
from fea.output.target import PictureError, picture_name
from fea.output.text import write_text
from fea.output.units import system


def write_report(path: Path, run: Run) -> None:
    """Write a report; the still picture is that of the folder, or is drawn, or is left out.

    Raises `StorageError`: the disk, a permission or the file system refused.
    """
    with ThreadPoolExecutor(1) as beside:  # another process draws meanwhile
        units = run.study.output.units
        picture = beside.submit(copy_context().run, still, path.parent, run.summary, units)
        drawn = scene(run)
        text = page(run, drawn, picture.result())
    write_text(path, text)


def still(folder: Path, summary: Summary, drawn_in: UnitSystem = UnitSystem.SI) -> bytes | None:
    """The picture of the worst load case in a run's folder: the one there, or a new one; or None.

    `drawn_in` are the units of the one there, which stands if these are shown.
    """
    result = f"{summary.worst_case}.vtu"
    there = folder / picture_name(result)
    if there.is_file() and drawn_in is system():
        return there.read_bytes()
    if not (folder / result).is_file():
        return None
    with TemporaryDirectory() as scratch:
        png = Path(scratch, there.name)
        try:
            draw_pictures([replace(described_by(summary, folder / result), png=png)])
        except PictureError:
            return None
        return png.read_bytes()
