"""Bodies of several parts that touch, for the benchmark cases."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from geometry.arrays import Floats
from geometry.bodies.shape import Body, Prism, Side, SideBySide
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.body import Fine, mesh_body
from mesh.numbering import numbered
from mesh.separate import Interfaces, separated
from mesh.tetmesh import TetMesh

# From places (…, 3) to a measure (…,) that grows from part to part.
Measure = Callable[[Floats], Floats]


def height(places: Floats) -> Floats:
    """Measure of parts that lie on top of each other."""
    return places[..., 2]


def radius(places: Floats) -> Floats:
    """Measure of parts that lie around each other."""
    return np.hypot(places[..., 0], places[..., 1])


def apart(
    body: Body,
    size: float,
    splits: Sequence[float],
    measure: Measure,
    interfaces: Interfaces,
    *,
    fine: Mapping[Surface, Fine] | None = None,
) -> TetMesh:
    """Mesh a body and take it apart.

    Parameters
    ----------
    body, size, fine
        As for `mesh.body.mesh_body`; faces of elements lie where the parts touch.
    splits, measure
        The parts end where the measure reaches these values, part 0 at the first.
    interfaces
        As for `mesh.separate.separated`.
    """
    mesh = mesh_body(body, size, fine=fine)
    furthest = measure(mesh.points)[mesh.tets[:, :4]].max(axis=1)
    part = np.searchsorted(np.asarray(splits) * (1 + 1e-9), furthest).astype(np.int64)
    return numbered(separated(replace(mesh, part=part), interfaces)[0])[0]


def rings(radii: Sequence[float], levels: tuple[float, ...], top: Surface = Surface.ROLLER) -> SideBySide:
    """Upper halves of rings around each other, with radii from the inside to the outside, mm.

    They are cut at `Surface.SYMMETRY_Y`; the inside is `Surface.INNER`, the outside `Surface.OUTER`.
    """

    def ring(inner: float, outer: float) -> Prism:
        sides = (
            Side(Line((inner, 0.0), (outer, 0.0)), Surface.SYMMETRY_Y),
            Side(Arc((0.0, 0.0), outer, 0.0, math.pi), Surface.OUTER),
            Side(Line((-outer, 0.0), (-inner, 0.0)), Surface.SYMMETRY_Y),
            Side(Arc((0.0, 0.0), inner, math.pi, -math.pi), Surface.INNER),
        )
        return Prism(sides, levels, top=top)

    return SideBySide(tuple(ring(*pair) for pair in pairwise(radii)))
