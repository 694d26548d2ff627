"""The data of a picture of a result: the skin, its stress, the hot spot."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
import pyvista

from fea.output.pictures.scale import Bands, exaggeration
from fea.output.pictures.shown import MODE, Field, field_of
from fea.output.pictures.strokes import View, choose_view
from fea.output.pictures.surface import DrawnSurface
from fea.output.text import error_bar
from geometry.arrays import Floats, Ints


@dataclass(frozen=True)
class Scene:
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
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)  #: (3,) mm, from which the hot spot's place is told

    @classmethod
    def read(
        cls,
        vtu: Path,
        name: str = "von_mises",
        peak: float | None = None,
        at: tuple[float, float, float] | None = None,
        error_percent: float | None = None,
    ) -> "Scene":
        """Read a result file; unless it is given, the hot spot is the worst place of the named field.

        Raises `ValueError`: the file has no tetrahedra, or does not have the field at its nodes.
        """
        points, tets, data = read_result(vtu)
        if name not in data:
            raise ValueError(f"{vtu} is not a result of a run: it has no array {name}.")
        field = field_of(name).in_units()
        values = field.values(data)
        worst = field.worst(values)
        return cls(
            _skin(points.tobytes(), tets.tobytes(), tets.shape[1]),
            field,
            data.get(name if name.startswith(MODE) else "displacement", np.zeros_like(points)),
            values,
            points[worst] if at is None else np.array(at),
            float(values[worst]) if peak is None else field.scale * peak,
            error_percent,
        )

    @property
    def worst(self) -> str:
        """The worst value with its error bar, as text."""
        said, bar = self.field.said(self.peak), self.error_percent
        return said if bar is None else f"{said} ± {error_bar(bar)} %"

    @property
    def top(self) -> float:
        """The upper end of the colour scale."""
        return float(self.values.max()) if self.field.signed else self.field.top(self.peak)

    @cached_property
    def bands(self) -> Bands:
        """The colours."""
        if self.field.signed:
            return Bands.around_zero(float(self.values.min()), self.top)
        return Bands.up_to(self.top, low=self.field.low)

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
        return choose_view(normal, lambda towards: not self.skin.hides(start, towards), closeness)


@lru_cache(maxsize=1)
def _skin(points: bytes, tets: bytes, nodes: int) -> DrawnSurface:
    """Return the skin of tetrahedra with so many nodes each; the results of one run share it."""
    return DrawnSurface.of(
        np.frombuffer(points).reshape(-1, 3), np.frombuffer(tets, np.int64).reshape(-1, nodes)
    )


def read_result(vtu: Path) -> tuple[Floats, Ints, dict[str, Floats]]:
    """Return points, tetrahedra and nodal arrays of a file; raises `ValueError`: it has no tetrahedra."""
    grid = pyvista.read(vtu)
    tets = [cells for cells in getattr(grid, "cells_dict", {}).values() if cells.shape[1] in (4, 10)]
    if len(tets) != 1:
        raise ValueError(f"{vtu} is not a result of a run: it has no tetrahedra.")
    data = {name: np.array(values, float) for name, values in grid.point_data.items()}
    return np.array(grid.points, float), tets[0].astype(np.int64), data
