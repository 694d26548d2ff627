"""The process that draws pictures: ``python -m fea.output.pictures.render ORDERS``, its pictures as JSON."""

import json
import sys
from pathlib import Path

from fea.output.pictures.drawing import draw
from fea.output.pictures.mesh_drawing import draw_mesh
from fea.output.pictures.scene import Scene, read_skin


def main() -> None:
    """Draw every requested picture."""
    for picture in json.loads(sys.argv[1]):
        vtu, png, title = Path(picture["vtu"]), Path(picture["png"]), picture["title"]
        if picture["mesh_only"]:
            draw_mesh(read_skin(vtu), title, png)
        else:
            draw(
                Scene.read(vtu, picture["field"], picture["peak"], picture["at"], picture["error_percent"]),
                title,
                png,
                picture["notes"],
            )


if __name__ == "__main__":
    main()
