"""The process that draws: ``python -m fea.output.render`` reads its pictures as JSON from standard input.

It is a process of its own because an OpenGL library that is missing or broken may end it at once.
"""

import json
import sys
from pathlib import Path

from fea.output.drawing import draw
from fea.output.scene import Scene


def main() -> None:
    """Draw every picture asked for."""
    for picture in json.load(sys.stdin):
        scene = Scene.read(Path(picture["vtu"]), picture["peak"], picture["at"])
        draw(scene, picture["title"], Path(picture["png"]), picture["notes"])


if __name__ == "__main__":
    main()
