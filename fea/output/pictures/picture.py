"""Pictures of results, drawn by a process that may fail without harm to them."""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fea.analysis.figures import Summary
from fea.machine.remedies import system_remedy
from fea.output.pictures.process import environments, run_drawing
from fea.output.pictures.shown import Picture, chosen_field, described, described_by, point_arrays
from fea.output.pictures.strokes import is_complete_png
from fea.output.target import PictureError
from fea.output.text import make_directory
from fea.output.vtu import write_vtu
from geometry.errors import require
from mesh.tetmesh import TetMesh

_NOTHING = "the drawing process wrote no picture"
TIMEOUT = 60.0  # seconds a picture; one takes about one


def take_pictures(folder: Path, summary: Summary, results: Sequence[str]) -> list[Path]:
    """Draw one picture for each named result file of the run in `folder`; return their files."""
    pictures = [described_by(summary, folder / name) for name in results]
    draw_pictures(pictures)
    return [picture.png for picture in pictures]


def picture_of(vtu: Path, png: Path, field: str | None = None) -> Path:
    """Draw a file as `png`, titled by its summary. Raises `InvalidValue`: no such field; `PictureError`."""
    require(vtu.is_file(), "FILE", str(vtu), "is not a file", "Name a .vtu file that fea wrote.")
    draw_pictures([described(vtu, png, chosen_field(field, point_arrays(vtu), vtu.name))])
    return png


def picture_of_mesh(mesh: TetMesh, name: str, folder: Path) -> Path:
    """Draw a rod's elements as ``<name>-rod.png`` in `folder`. Raises `PictureError`, `StorageError`."""
    png = folder / f"{name}-rod.png"
    title = f"{name}: {len(mesh.points)} nodes, {len(mesh.tets)} elements"
    with TemporaryDirectory() as scratch:
        vtu = Path(scratch, "mesh.vtu")
        write_vtu(vtu, mesh, {})
        make_directory(folder)
        draw_pictures([Picture(vtu=vtu, png=png, title=title, mesh_only=True)])
    return png


def try_rendering() -> None:
    """Draw something small as pictures are drawn. Raises `PictureError`: it fails; says what to install."""
    with TemporaryDirectory() as folder:
        vtu = Path(folder, "trial.vtu")
        points = np.vstack([np.zeros(3), np.eye(3)])
        mesh = TetMesh(points, np.array([[0, 1, 2, 3]]))
        write_vtu(vtu, mesh, {"displacement": points * 0.01, "von_mises": points @ [1.0, 2.0, 3.0]})
        draw_pictures([Picture(vtu=vtu, png=vtu.with_suffix(".png"), title="trial")])


def draw_pictures(pictures: Sequence[Picture]) -> None:
    """Draw pictures in the process of `ready_to_draw`, if any. Raises `PictureError`: what to install."""
    if not pictures:
        return
    for environment in environments():
        for picture in pictures:
            picture.png.unlink(missing_ok=True)
        job, timeout = "fea.output.pictures.drawing:draw_all", TIMEOUT * (1 + len(pictures))
        said = run_drawing(job, pictures, environment=environment, timeout=timeout)
        missing = [picture.png.name for picture in pictures if not is_complete_png(picture.png)]
        if not missing:
            return
    names = ", ".join(missing)
    raise PictureError(
        f"{names} could not be drawn: {said or _NOTHING}. Remedy: {system_remedy('pictures')}."
    )
