"""The process that draws pictures: ``python -m fea.output.pictures.render``."""

import json
import os
import socket
from contextlib import suppress
from pathlib import Path
from typing import Any

from PIL import Image

from fea.output.pictures.child import ordered
from fea.output.pictures.drawing import draw, draw_mesh
from fea.output.pictures.scene import Scene, read_skin, trial_scene
from fea.output.pictures.strokes import save
from geometry.system import die_with_parent


def main() -> None:
    """Draw every requested picture; a copy of this process draws every second one of several."""
    copy = _copied()
    draw(trial_scene(), "")  # OpenGL and the fonts are loaded while there is nothing else to draw
    for pictures in ordered():
        shared = pictures[1::2] if copy else []
        if copy and shared:
            with suppress(ConnectionError):  # a picture is missing then
                copy.sendall(json.dumps(shared).encode() + b"\n")
        for picture in pictures[::2] if copy else pictures:
            save(_drawn(picture), Path(picture["png"]))
        if copy and shared:
            with suppress(ConnectionError):
                copy.recv(1)


def _copied() -> socket.socket | None:
    """Fork this process once its libraries are loaded; the copy takes its orders from the socket returned."""
    if not hasattr(os, "fork"):
        return None
    ours, its = socket.socketpair()
    if os.fork():
        its.close()
        return ours
    die_with_parent()
    ours.close()
    os.dup2(its.fileno(), 0)
    return None


def _drawn(picture: dict[str, Any]) -> Image.Image:
    vtu, title = Path(picture["vtu"]), picture["title"]
    if picture["mesh_only"]:
        return draw_mesh(read_skin(vtu), title)
    scene = Scene.read(vtu, picture["field"], picture["peak"], picture["at"], picture["error_percent"])
    return draw(scene, title, picture["notes"], picture["marks"])


if __name__ == "__main__":
    main()
