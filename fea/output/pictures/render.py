"""What the drawing process does with pictures; it shares several with a copy of itself."""

from collections.abc import Sequence
from pathlib import Path

from fea.machine.isolated import IsolatedProcess, copied
from fea.output.pictures.drawing import draw, draw_mesh
from fea.output.pictures.scene import Scene, read_skin, trial_scene
from fea.output.pictures.shown import Picture
from fea.output.pictures.strokes import save
from geometry.system import CAN_FORK

_copies: list[IsolatedProcess] = []


def warm_up() -> None:
    """Copy this process while only its libraries are loaded; in both, start OpenGL and load the fonts."""
    if CAN_FORK:
        _copies.append(copied(_draw_trial))
    _draw_trial()


def _draw_trial() -> None:
    draw(trial_scene(), "")


def draw_all(pictures: Sequence[Picture]) -> None:
    """Draw every picture; the copy, if there is one, draws every second one of several."""
    if len(pictures) > 1 and _copies:
        _copies[0].begin(_draw_each, pictures[1::2])
        _draw_each(pictures[::2])
        _copies[0].result()
    else:
        _draw_each(pictures)


def _draw_each(pictures: Sequence[Picture]) -> None:
    for picture in pictures:
        if picture.mesh_only:
            image = draw_mesh(read_skin(picture.vtu), picture.title)
        else:
            scene = Scene.read(picture.vtu, picture.field, picture.peak, picture.at, picture.error_percent)
            image = draw(scene, picture.title, picture.notes, picture.marks)
        save(image, Path(picture.png))
