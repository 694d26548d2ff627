"""The process that draws pictures: ``python -m fea.output.pictures.render``."""

from pathlib import Path
from typing import Any

from PIL import Image

from fea.output.pictures.child import ordered
from fea.output.pictures.drawing import draw
from fea.output.pictures.mesh_drawing import draw_mesh
from fea.output.pictures.scene import Scene, read_skin, trial_scene
from fea.output.pictures.strokes import save


def main() -> None:
    """Draw every requested picture."""
    draw(trial_scene(), "")  # OpenGL and the fonts are loaded while there is nothing else to draw
    for pictures in ordered():
        for picture in pictures:
            save(_drawn(picture), Path(picture["png"]))


def _drawn(picture: dict[str, Any]) -> Image.Image:
    vtu, title = Path(picture["vtu"]), picture["title"]
    if picture["mesh_only"]:
        return draw_mesh(read_skin(vtu), title)
    scene = Scene.read(vtu, picture["field"], picture["peak"], picture["at"], picture["error_percent"])
    return draw(scene, title, picture["notes"])


if __name__ == "__main__":
    main()
