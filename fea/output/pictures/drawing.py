"""The picture of a result: the deformed rod, its hot spot magnified, and the legend."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
from PIL import Image

from fea.machine.isolated import IsolatedProcess, copied
from fea.machine.system import CAN_FORK
from fea.output.pictures import strokes
from fea.output.pictures.scale import Bands, exaggeration, round_down
from fea.output.pictures.shown import MODE, VON_MISES, Field, Picture, field_of
from fea.output.pictures.strokes import GREY, INK, PAPER, SHADING, SIZE, USUAL, CameraFrame, View
from fea.output.pictures.surface import DrawnSurface, refined_line
from fea.output.units import bar, coordinates, quantity, scale, shown_in, unit
from fea.output.vtu import point_name
from geometry.arrays import Floats, Ints


@dataclass(frozen=True)
class ResultScene:
    """A rod under load."""

    skin: DrawnSurface  #: the outer surface without load
    field: Field
    #: displacement, values: (n_nodes, 3) in mm, zero if the result has none, and (n_nodes,) of the field that
    #: the colours show
    displacement: Floats
    values: Floats
    #: at, peak: (3,) the hot spot on the undeformed rod, mm, and the value there
    at: Floats
    peak: float
    error_percent: float | None = None
    origin: tuple[float, float, float] = (
        0.0,
        0.0,
        0.0,
    )  #: (3,) mm, from which the place is measured

    @classmethod
    def read(cls, picture: Picture) -> "ResultScene":
        """Read what a picture shows; unless it is given, the hot spot is the worst place of its field.

        Raises `ValueError`: the file has no tetrahedra, or does not have the field at its nodes.
        """
        points, tets, data = read_result(picture.vtu)
        name = picture.field
        if name not in data:
            raise ValueError(f"{picture.vtu} is not a result of a run: it has no array {name}.")
        field = field_of(name)
        values = field.values(data)
        worst = field.worst(values)
        return cls(
            _skin(points.tobytes(), tets.tobytes(), tets.shape[1]),
            field,
            data.get(name if name.startswith(MODE) else "displacement", np.zeros_like(points)),
            values,
            points[worst] if picture.at is None else np.array(picture.at),
            float(values[worst]) if picture.peak is None else field.scale * picture.peak,
            picture.error_percent,
            picture.origin,
        )

    @property
    def worst(self) -> str:
        """The worst value with its error bar, as text."""
        extreme = self.field.extreme(self.peak)
        return extreme if self.error_percent is None else f"{extreme} ± {bar(self.error_percent)} %"

    @property
    def top(self) -> float:
        """The upper end of the colour scale."""
        return float(self.values.max()) if self.field.signed else self.field.top(self.peak)

    @cached_property
    def bands(self) -> Bands:
        """The colours."""
        return self.field.bands(self.values, self.peak)

    @cached_property
    def extent(self) -> float:
        """The largest dimension of the rod, mm."""
        return float(np.ptp(self.skin.points, axis=0).max())

    @cached_property
    def exaggeration(self) -> float:
        """The magnification of the displacements."""
        return exaggeration(self.extent, self.displaced)

    @cached_property
    def displaced(self) -> float:
        """The largest displacement, mm."""
        return float(np.linalg.norm(self.displacement, axis=1).max())

    @cached_property
    def deformed(self) -> Floats:
        """(n_nodes, 3) drawn positions of the nodes."""
        return self.skin.points + self.exaggeration * self.displacement

    @cached_property
    def node(self) -> int:
        """The node of the skin closest to the hot spot."""
        nodes = np.unique(self.skin.facets)
        return int(nodes[np.linalg.norm(self.skin.points[nodes] - self.at, axis=1).argmin()])

    def view(self, closeness: float) -> View:
        """Return the view that shows the hot spot (`closeness` as in `choose_view`)."""
        mean = self.skin.normals[self.skin.facets == self.node].mean(axis=0)
        normal = mean / np.linalg.norm(mean)
        start = self.skin.points[self.node] + 2e-3 * self.extent * normal
        return strokes.choose_view(normal, lambda towards: not self.skin.hides(start, towards), closeness)


@lru_cache(maxsize=1)
def _skin(points: bytes, tets: bytes, nodes: int) -> DrawnSurface:
    """Return the skin of tetrahedra with so many nodes each; the results of one run share it."""
    elements = np.frombuffer(tets, np.int64).reshape(-1, nodes)
    return DrawnSurface.of(np.frombuffer(points).reshape(-1, 3), elements)


def read_result(vtu: Path) -> tuple[Floats, Ints, dict[str, Floats]]:
    """Return points, tetrahedra and nodal arrays of a file; raises `ValueError`: it has no tetrahedra."""
    grid = pyvista.read(vtu)
    tets = [cells for cells in getattr(grid, "cells_dict", {}).values() if cells.shape[1] in (4, 10)]
    if len(tets) != 1:
        raise ValueError(f"{vtu} is not a result of a run: it has no tetrahedra.")
    data = {point_name(name): np.array(values, float) for name, values in grid.point_data.items()}
    return np.array(grid.points, float), tets[0].astype(np.int64), data


ROD_SHARE, SPOT_SHARE = 0.58, 0.64  # share of the height for the rod, of the width for the hot spot
SCALARS = "shown"  # name of the array that the colours show
MAGNIFIED = 0.055  # half the height of the hot spot's frame, relative to the rod's extent
BELOW_TITLE = 0.9  # lower end of the title, relative to the height of the rod's frame
MARGIN = 0.11  # half the width of the label of the peak, which must stay within the picture


Marks = Sequence[tuple[str, Sequence[float]]]


def draw(scene: ResultScene, title: str, notes: Sequence[str] = (), marks: Marks = ()) -> Image.Image:
    """Return the picture of a result, with more notes beside the legend.

    `marks` are names and places, mm, on the undeformed rod, that get a small ring. Raises `RuntimeError`: the
    picture is blank: some OpenGL libraries fail without an error.
    """
    plotter = strokes.canvas((ROD_SHARE, 1 - ROD_SHARE), (SPOT_SHARE, 1 - SPOT_SHARE), joined=(0,), axes=(0,))
    plotter.subplot(0, 0)
    _draw_rod(plotter, scene, marks)
    strokes.write(plotter, title, (0.02, 0.91), size=30)
    plotter.subplot(1, 0)
    _draw_spot(plotter, scene)
    plotter.subplot(1, 1)
    _draw_legend(plotter, scene, notes)
    return strokes.finish(plotter, ROD_SHARE)


def _draw_rod(plotter: Any, scene: ResultScene, marks: Marks) -> None:
    aspect = SIZE[0] / (SIZE[1] * ROD_SHARE)
    frame = CameraFrame.around(scene.deformed, scene.view(closeness=0.8), aspect, width=0.9, height=0.7)
    add_surface(plotter, _surface(scene, scene.skin), scene.bands)
    strokes.add_edges(plotter, scene.skin, scene.skin.points, frame, (GREY, 1.0))
    strokes.add_edges(plotter, scene.skin, scene.deformed, frame, (INK, 1.5))
    radius = 0.5 * MAGNIFIED * scene.extent
    _add_ring(plotter, frame, frame.view.across(scene.deformed[scene.node]), radius)
    _add_label(plotter, scene, frame, radius)
    for name, place in marks:
        _add_mark(plotter, scene, frame, name, np.asarray(place))
    frame.aim(plotter)


def _add_label(plotter: Any, scene: ResultScene, frame: CameraFrame, radius: float) -> None:
    flat = frame.view.across(scene.deformed)
    x, y = flat[scene.node]
    beside = flat[abs(flat[:, 0] - x) < 0.15 * scene.extent, 1]
    gap = 0.05 * 2 * frame.half_height
    highest = frame.relative(np.array([x, beside.max() + 2 * gap]))[1]
    above = beside.max() - y < y - beside.min() and highest < BELOW_TITLE
    end = beside.max() + gap if above else beside.min() - gap
    start = y + radius if above else y - radius
    strokes.add_lines(plotter, frame.lifted(np.array([[[x, start], [x, end]]])), INK, 2)
    across, height = frame.relative(np.array([x, end + (0.3 if above else -0.9) * gap]))
    strokes.write(plotter, scene.worst, (min(max(across, MARGIN), 1 - MARGIN), height), size=24, centred=True)


def _draw_spot(plotter: Any, scene: ResultScene) -> None:
    aspect = SIZE[0] * SPOT_SHARE / (SIZE[1] * (1 - ROD_SHARE))
    view, half = scene.view(closeness=2.5), MAGNIFIED * scene.extent
    near = float((scene.deformed @ view.towards).max()) + 1.0
    frame = CameraFrame(view, view.across(scene.deformed[scene.node]), half, aspect, near)
    skin = scene.skin.part(frame.meets(scene.deformed[scene.skin.facets]))
    add_surface(plotter, _surface(scene, skin), scene.bands)
    elements = refined_line(scene.deformed, skin.sides[0]) + frame.nudge
    strokes.add_lines(plotter, elements, INK, 1.0, opacity=0.35)
    strokes.add_edges(plotter, skin, scene.deformed, frame, (INK, 2.0))
    _add_ring(plotter, frame, frame.view.across(scene.deformed[scene.node]), 0.06 * half)
    shown = round_down(0.6 * half * scale("mm"))
    length = shown / scale("mm")
    start = frame.place((0.03, 0.08))
    end = start + np.array([length, 0.0])
    strokes.add_lines(plotter, frame.lifted(np.array([[start, end]])), INK, 4)
    above = (start + end) / 2 + np.array([0.0, 0.06 * half])
    strokes.write(
        plotter, f" {shown:g} {unit('mm')} ", frame.relative(above), size=20, centred=True, ground=0.7
    )
    frame.aim(plotter)


def _draw_legend(plotter: Any, scene: ResultScene, notes: Sequence[str]) -> None:
    limits, colours = scene.bands.limits, scene.bands.colours
    edges = np.linspace(0.06, 0.94, len(limits))
    low, high = 0.76, 0.84
    corners = [[[a, low], [b, low], [b, high], [a, high]] for a, b in itertools.pairwise(edges)]
    aspect = SIZE[0] * (1 - SPOT_SHARE) / (SIZE[1] * (1 - ROD_SHARE))
    frame = CameraFrame(View.along(np.array([0.0, 0.0, 1.0])), np.array([aspect / 2, 0.5]), 0.5, aspect, 0.0)
    points = frame.lifted(np.reshape(corners, (-1, 2)) * [aspect, 1.0])
    bar = pyvista.PolyData.from_regular_faces(points, np.arange(len(points)).reshape(-1, 4))
    bar.cell_data["colours"] = colours
    plotter.add_mesh(bar, scalars="colours", rgb=True, lighting=False, show_edges=True, edge_color=INK)
    frame.aim(plotter)
    strokes.write(plotter, scene.field.label, (edges[0], high + 0.035), size=24)
    for edge, limit in zip(edges, limits, strict=True):
        strokes.write(plotter, f"{limit:g}", (edge, low - 0.065), size=19, centred=True)
    moved = f"displacement up to {quantity(scene.displaced, '.3g', 'mm')}, drawn × {scene.exaggeration:g}"
    if scene.field.name.startswith(MODE):
        moved = "mode shape: its amplitude is arbitrary"
    lines = [
        scene.worst,
        f"at x, y, z = {coordinates(scene.at - scene.origin)} {unit('mm')}",
        *([f"blue: {limits[-1]:g} and above"] if scene.field.capped else []),
        *([moved] if scene.displaced > 0 else []),
        *notes,
        *(["grey lines: the undeformed rod"] if scene.displaced > 0 else []),
    ]
    for k, line in enumerate(lines):
        strokes.write(plotter, line, (edges[0], 0.57 - 0.085 * k), size=21)


def _surface(scene: ResultScene, skin: DrawnSurface) -> Any:
    return surface_of(skin, scene.deformed, np.minimum(scene.values, scene.top))


def surface_of(skin: DrawnSurface, points: Floats, values: Floats | None = None) -> Any:
    """Return a surface with its nodes at `points`, and nodal values as its `SCALARS`."""
    surface = pyvista.PolyData.from_regular_faces(skin.refined(points), skin.triangles)
    if values is not None:
        surface.point_data[SCALARS] = skin.refined(values)
    surface.point_data["Normals"] = skin.refined_normals
    surface.point_data.active_normals_name = "Normals"
    return surface


def add_surface(plotter: Any, surface: Any, bands: Bands) -> Any:
    """Add a surface in the colour bands of its `SCALARS`; return the actor."""
    bare = {"show_scalar_bar": False, "smooth_shading": False, "copy_mesh": False}
    return plotter.add_mesh(surface, scalars=SCALARS, cmap=bands.table(), **bare, **SHADING)


def _add_mark(plotter: Any, scene: ResultScene, frame: CameraFrame, name: str, place: Floats) -> None:
    node = int(np.linalg.norm(scene.skin.points - place, axis=1).argmin())
    middle, radius = frame.view.across(scene.deformed[node]), 0.2 * MAGNIFIED * scene.extent
    _add_ring(plotter, frame, middle, radius)
    beside = frame.relative(middle + np.array([1.5, 1.5]) * radius)
    strokes.write(plotter, name, beside, size=22, ground=0.7)


def _add_ring(plotter: Any, frame: CameraFrame, middle: Floats, radius: float) -> None:
    angle = np.linspace(0, 2 * np.pi, 73)[:, None]
    ring = frame.lifted(middle + radius * np.hstack([np.cos(angle), np.sin(angle)]))[None]
    strokes.add_lines(plotter, ring, PAPER, 6)
    strokes.add_lines(plotter, ring, INK, 3)


ROWS = (0.56, 0.44)
STEEL = "#9db4cc"


def draw_mesh(skin: DrawnSurface, title: str) -> Image.Image:
    """Return the picture of a rod and its elements; raises RuntimeError if it is blank."""
    surface = surface_of(skin, skin.points)
    plotter = strokes.canvas(ROWS, (1.0,), axes=(0, 1))
    for row, towards in enumerate((USUAL, np.array([0.0, 0.0, 1.0]))):
        plotter.subplot(row, 0)
        aspect = SIZE[0] / (SIZE[1] * ROWS[row])
        frame = CameraFrame.around(skin.points, View.along(towards), aspect, width=0.9, height=0.74)
        plotter.add_mesh(surface, color=STEEL, copy_mesh=False, **SHADING)
        strokes.add_lines(
            plotter, refined_line(skin.points, skin.sides[0]) + frame.nudge, INK, 0.8, opacity=0.3
        )
        strokes.add_edges(plotter, skin, skin.points, frame, (INK, 1.5))
        frame.aim(plotter)
    plotter.subplot(0, 0)
    strokes.write(plotter, title, (0.02, 0.91), size=30)
    return strokes.finish(plotter, ROWS[0])


_copies: list[IsolatedProcess] = []


def warm_up() -> None:
    """Copy this process while only its libraries are loaded; in both, start OpenGL and load the fonts."""
    if CAN_FORK:
        _copies.append(copied(_draw_trial))
    _draw_trial()


def _draw_trial() -> None:
    points = np.vstack([np.zeros(3), np.eye(3)])
    skin = DrawnSurface.of(points, np.array([[0, 1, 2, 3]]))
    draw(ResultScene(skin, field_of(VON_MISES), 0.01 * points, points.sum(axis=1), points[1], 1.0), "")


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
        with shown_in(picture.units):
            image = _drawn(picture)
        strokes.save(image, Path(picture.png))


def _drawn(picture: Picture) -> Image.Image:
    if picture.mesh_only:
        points, tets, _ = read_result(picture.vtu)
        return draw_mesh(DrawnSurface.of(points, tets), picture.title)
    return draw(ResultScene.read(picture), picture.title, picture.notes, picture.marks)
