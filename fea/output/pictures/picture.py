"""Pictures of results, drawn by another process: a broken OpenGL library may end that at once."""

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fea.analysis.summary_figures import Summary
from fea.machine.isolated import CrashError, IsolatedProcess, OvertimeError, fresh
from fea.machine.remedies import system_remedy
from fea.output.folder import PictureError, make_directory
from fea.output.json_file import governing_file
from fea.output.pictures.shown import Picture, chosen_field, described, described_by, point_arrays
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
    require(
        vtu.is_file(),
        "FILE",
        str(vtu),
        "is not a file",
        "Name a .vtu file that fea wrote, or the folder of a run.",
    )
    draw_pictures([described(vtu, png, chosen_field(field, point_arrays(vtu), vtu.name))])
    return png


def picture_of_run(folder: Path, png: Path | None = None, field: str | None = None) -> tuple[Path, str]:
    """Draw what governs a run, by default beside its result; return the picture and what governs in words.

    Raises `InvalidValue`: the folder is not that of a run with fields, or has no such field; `PictureError`.
    """
    vtu, summary = governing_file(folder)
    shown = None if field is None else chosen_field(field, point_arrays(vtu), vtu.name)
    picture = replace(described_by(summary, vtu, shown), png=png or vtu.with_suffix(".png"))
    draw_pictures([picture])
    return picture.png, f"{summary.title}: {summary.survival.text}"


def picture_of_mesh(mesh: TetMesh, name: str, png: Path) -> Path:
    """Draw a rod's elements; return the picture. Raises `PictureError`, `StorageError`."""
    title = f"{name}: {len(mesh.points)} nodes, {len(mesh.tets)} elements"
    with TemporaryDirectory() as scratch:
        vtu = Path(scratch, "mesh.vtu")
        write_vtu(vtu, mesh, {})
        make_directory(png.parent)
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
        failure = run_drawing(job, pictures, environment=environment, timeout=timeout)
        missing = [picture.png.name for picture in pictures if not is_complete_png(picture.png)]
        if not missing:
            return
    names = ", ".join(missing)
    raise PictureError(
        f"{names} could not be drawn: {failure or _NOTHING}. Remedy: {system_remedy('pictures')}."
    )


def is_complete_png(path: Path) -> bool:
    """Return whether `path` is a PNG with every chunk intact and more than one colour in it."""
    from PIL import Image  # noqa: PLC0415 - only a picture needs it

    try:
        with Image.open(path, formats=["PNG"]) as image:
            image.verify()  # of the chunks; after it an image cannot be read
        with Image.open(path, formats=["PNG"]) as image:
            bands = np.atleast_2d(image.getextrema())
    except (OSError, SyntaxError, ValueError):  # Pillow's for a chunk that is damaged or missing
        return False
    return bool((bands[:, 0] < bands[:, 1]).any())


_ready: ContextVar[IsolatedProcess | None] = ContextVar("_ready", default=None)


def environments() -> list[dict[str, str]]:
    """Return what to try in the environment of the drawing process; on Linux, first without a display."""
    headless = {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
    if not sys.platform.startswith("linux") or headless.keys() <= os.environ.keys():
        return [{}]
    has_display = bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return [headless, {}] if has_display else [headless]


@contextmanager
def ready_to_draw(*, wanted: bool = True) -> Iterator[None]:
    """Keep a process for all pictures of the block, which loads its libraries meanwhile."""
    with ExitStack() as stack:
        if wanted:
            with suppress(OSError):  # to be reported where something is to be drawn
                process = stack.enter_context(drawing_process(environments()[0]))
                process.begin(_called, "fea.output.pictures.drawing:warm_up")
                stack.callback(_ready.reset, _ready.set(process))
        yield


def drawing_process(environment: dict[str, str]) -> IsolatedProcess:
    """Start a process whose environment is that of this one and the given one."""
    alone = {"OPENBLAS_NUM_THREADS": "1"}  # waiting threads would slow the analysis down
    return fresh(alone | environment, messages=True)


def run_drawing(job: str, *arguments: object, environment: dict[str, str], timeout: float) -> str:
    """Do a job in the process that is ready, or a new one; return why it failed, in one line, or "".

    The job is a function, ``"module:name"``, whose module only that process imports.
    """
    ready = _ready.get()
    if ready is not None and ready.alive and environment == environments()[0]:
        return explained(ready, job, *arguments, timeout=timeout)
    try:
        with drawing_process(environment) as process:
            return explained(process, job, *arguments, timeout=timeout)
    except OSError as error:  # it could not be started
        return str(error)


def explained(process: IsolatedProcess, job: str, *arguments: object, timeout: float) -> str:
    """Do a job in a process; return as `run_drawing`."""
    try:
        process.run(_called, job, *arguments, seconds=timeout)
    except OvertimeError as error:
        return str(error)
    except CrashError as error:
        exited = error.cause.startswith("exit")
        message = process.last_message if exited else f"the drawing process ended ({error.cause})"
        return message.rstrip(".") or str(error)
    except Exception as error:  # noqa: BLE001 - whatever a library raises
        return f"{type(error).__name__}: {error}".rstrip(".")
    return ""


def _called(job: str, *arguments: object) -> None:
    module, _, name = job.partition(":")
    getattr(import_module(module), name)(*arguments)
