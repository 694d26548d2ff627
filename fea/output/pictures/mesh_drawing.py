"""The picture of a mesh: the rod in an oblique view and in plan, with the edges of the elements."""

import numpy as np
import pyvista
from PIL import Image

from fea.output.pictures.frame import Frame
from fea.output.pictures.skin import Skin, refined_line
from fea.output.pictures.strokes import INK, SHADING, SIZE, add_edges, add_lines, canvas, finish, write
from fea.output.pictures.view import USUAL, View

ROWS = (0.56, 0.44)
STEEL = "#9db4cc"


def draw_mesh(skin: Skin, title: str) -> Image.Image:
    """Return the picture of a rod and its elements.

    Parameters
    ----------
    skin
        Its surface.
    title
        Title of the picture.

    Raises
    ------
    RuntimeError
        The picture is blank.
    """
    surface = pyvista.PolyData.from_regular_faces(skin.refined(skin.points), skin.triangles)
    surface.point_data["Normals"] = skin.refined_normals
    surface.point_data.active_normals_name = "Normals"
    plotter = canvas(ROWS, (1.0,), axes=(0, 1))
    for row, towards in enumerate((USUAL, np.array([0.0, 0.0, 1.0]))):
        plotter.subplot(row, 0)
        aspect = SIZE[0] / (SIZE[1] * ROWS[row])
        frame = Frame.around(skin.points, View.along(towards), aspect, width=0.9, height=0.74)
        plotter.add_mesh(surface, color=STEEL, copy_mesh=False, **SHADING)
        add_lines(plotter, refined_line(skin.points, skin.sides[0]) + frame.nudge, INK, 0.8, opacity=0.3)
        add_edges(plotter, skin, skin.points, frame, (INK, 1.5))
        frame.aim(plotter)
    plotter.subplot(0, 0)
    write(plotter, title, (0.02, 0.91), size=30)
    return finish(plotter, ROWS[0])
