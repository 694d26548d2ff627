"""Pictures of results, drawn by a process that may fail without harm to them."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from fea.output.errors import PictureError
from fea.output.text import make_directory
from fea.output.vtu import write_vtu
from fea.pictures.child import REMEDY, environments, run_drawing
from fea.pictures.png import is_complete_png
from geometry.invalid import require
from mesh.tetmesh import TetMesh

TIMEOUT = 60.0  # seconds a picture; one takes about one


@dataclass(frozen=True)
class Picture:
    """A picture to be drawn.

    Attributes
    ----------
    vtu, png
        The result file to show and the picture to write.
    title
        Study, case, speed and crank angle.
    peak
        The largest von Mises stress that counts, MPa; None for the largest in the file.
    at
        Where it is, (x, y, z) in mm; None for where the file's largest is.
    notes
        More lines beside the legend.
    mesh_only
        Show the rod and its elements; there are no results.
    """

    vtu: Path
    png: Path
    title: str
    peak: float | None = None
    at: tuple[float, float, float] | None = None
    notes: tuple[str, ...] = ()
    mesh_only: bool = False


def take_pictures(folder: Path, summary: Mapping[str, Any]) -> list[Path]:
    """Draw one picture for each case of the run in `folder`; return their files."""
    pictures = [_described(folder / f"{case}.vtu", summary, case) for case in summary["results"]]
    draw_pictures(pictures)
    return [picture.png for picture in pictures]


def picture_of(vtu: Path, png: Path) -> Path:
    """Draw one result file, titled by the summary beside it if there is one; return `png`.

    Raises
    ------
    InvalidValue
        The file exists but is not that of a load case.
    PictureError
        See `draw_pictures`.
    """
    if vtu.is_file():
        _require_case(vtu)
    draw_pictures([described(vtu, png)])
    return png


def _require_case(vtu: Path) -> None:
    content = vtu.read_bytes()
    missing = [name for name in ("displacement", "von_mises") if f'Name="{name}"'.encode() not in content]
    require(
        not missing,
        "FILE",
        vtu.name,
        f"must be the result of a load case: it lacks {' and '.join(missing)}",
        "Open other files (envelope.vtu, buckling.vtu) in ParaView.",
    )


def picture_of_mesh(mesh: TetMesh, name: str, folder: Path) -> Path:
    """Draw a rod and its elements as ``<name>-rod.png`` in `folder`, which is made; return the file.

    Raises
    ------
    PictureError
        See `draw_pictures`.
    StorageError
        The folder cannot be made.
    """
    png = folder / f"{name}-rod.png"
    title = f"{name}: {len(mesh.points)} nodes, {len(mesh.tets)} elements"
    with TemporaryDirectory() as scratch:
        vtu = Path(scratch, "mesh.vtu")
        write_vtu(vtu, mesh, {})
        make_directory(folder)
        draw_pictures([Picture(vtu, png, title, mesh_only=True)])
    return png


def described(vtu: Path, png: Path) -> Picture:
    """Return the picture of a result file in the words of the summary beside it, if there is one."""
    try:
        summary = json.loads((vtu.parent / "summary.json").read_text(encoding="utf-8"))
        return replace(_described(vtu, summary, vtu.stem), png=png)
    except (OSError, ValueError, KeyError, TypeError):
        return Picture(vtu, png, vtu.stem)


def try_rendering() -> None:
    """Draw something small the way pictures are drawn.

    Raises
    ------
    PictureError
        This machine cannot; says what to install.
    """
    with TemporaryDirectory() as folder:
        vtu = Path(folder, "trial.vtu")
        points = np.vstack([np.zeros(3), np.eye(3)])
        mesh = TetMesh(points, np.array([[0, 1, 2, 3]]))
        write_vtu(vtu, mesh, {"displacement": points * 0.01, "von_mises": points @ [1.0, 2.0, 3.0]})
        draw_pictures([Picture(vtu, vtu.with_suffix(".png"), "trial")])


def draw_pictures(pictures: Sequence[Picture]) -> None:
    """Draw pictures, all in one process.

    Raises
    ------
    PictureError
        One is missing, damaged or blank; says what to install.
    """
    if not pictures:
        return
    orders = json.dumps([_order(picture) for picture in pictures])
    for environment in environments():
        for picture in pictures:
            picture.png.unlink(missing_ok=True)
        said = run_drawing("fea.pictures.render", orders, environment, TIMEOUT * (1 + len(pictures)))
        missing = [picture.png.name for picture in pictures if not is_complete_png(picture.png)]
        if not missing:
            return
    raise PictureError(f"{', '.join(missing)} could not be drawn: {said}. {REMEDY}")


def _described(vtu: Path, summary: Mapping[str, Any], case: str) -> Picture:
    """Return the picture of a case of a run."""
    result = summary["results"][case]
    angle = summary["loads"][case].get("crank_deg")
    speed = summary.get("rpm")
    parts = [
        case,
        f"{speed:g} rpm" if speed else "",
        f"crank angle {angle:.1f}°" if angle is not None else "",
    ]
    title = f"{summary['study']}: " + ", ".join(part for part in parts if part)
    safety = result.get("min_safety_factor")
    notes = [
        f"smallest safety factor against yield {safety:.3g}" if safety is not None else "",
        "" if summary.get("trusted", True) else "NOT TO BE TRUSTED: a check failed",
    ]
    at = result.get("at_mm")
    return Picture(
        vtu,
        vtu.with_suffix(".png"),
        title,
        result.get("max_von_mises_MPa"),
        tuple(at) if at else None,
        tuple(note for note in notes if note),
    )


def _order(picture: Picture) -> dict[str, Any]:
    return asdict(picture) | {"vtu": os.fspath(picture.vtu), "png": os.fspath(picture.png)}
