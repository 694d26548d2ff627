"""Bodies of several parts that touch, for the benchmark cases."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from geometry.arrays import Floats
from geometry.bodies import Body, Prism, Side, SideBySide, polygon
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.numbering import numbered
from mesh.separate import Interfaces, separated
from mesh.tetmesh import TetMesh

# From places (…, 3) to a measure (…,) that grows from part to part.
Measure = Callable[[Floats], Floats]


def along_x(places: Floats) -> Floats:
    """Measure of parts that lie beside each other."""
    return places[..., 0]


def radius(places: Floats) -> Floats:
    """Measure of parts that lie around each other."""
    return np.asarray(np.hypot(places[..., 0], places[..., 1]))


def parted(mesh: TetMesh, splits: Sequence[float], measure: Measure) -> TetMesh:
    """Number the parts of a mesh, which end where the measure reaches the `splits`."""
    furthest = measure(mesh.points)[mesh.tets[:, :4]].max(axis=1)
    part = np.searchsorted(np.asarray(splits) + 1e-9 * float(np.abs(splits).max()), furthest)
    return replace(mesh, part=part.astype(np.int64))


def apart(
    body: Body,
    size: float,
    splits: Sequence[float],
    measure: Measure,
    interfaces: Interfaces,
    *,
    order: int = 2,
    fine: Mapping[Surface, Fine] | None = None,
) -> TetMesh:
    """Mesh a body and take its parts apart.

    Parameters
    ----------
    body, size, order, fine
        As for `mesh.generate.mesh_body`; faces of elements lie where the parts touch.
    splits, measure
        As for `parted`.
    interfaces
        As for `mesh.separate.separated`.
    """
    mesh = parted(mesh_body(body, size, order=order, fine=fine), splits, measure)
    return numbered(separated(mesh, interfaces)[0])[0]


def rings(radii: Sequence[float], height: float) -> SideBySide:
    """Upper halves of rings around each other, with radii from the inside to the outside, mm.

    They are cut at `Surface.SYMMETRY_Y` and `Surface.SYMMETRY_Z`; the inside is `Surface.INNER`, the outside
    `Surface.OUTER`, the top free.
    """

    def ring(inner: float, outer: float) -> Prism:
        sides = (
            Side(Line((inner, 0.0), (outer, 0.0)), Surface.SYMMETRY_Y),
            Side(Arc((0.0, 0.0), outer, 0.0, math.pi), Surface.OUTER),
            Side(Line((-outer, 0.0), (-inner, 0.0)), Surface.SYMMETRY_Y),
            Side(Arc((0.0, 0.0), inner, math.pi, -math.pi), Surface.INNER),
        )
        return Prism(sides, (0.0, height))

    return SideBySide(tuple(ring(*pair) for pair in pairwise(radii)))


def bars(
    ends: Sequence[float], width: tuple[float, float], height: float, below: Surface = Surface.FREE
) -> SideBySide:
    """Bars one after another along x, from `Surface.BOLT_THREAD` to `Surface.BOLT_HEAD`.

    Parameters
    ----------
    ends
        x where the first begins, where they touch and where the last ends, mm.
    width
        Least and greatest y, mm.
    height
        Greatest z, mm; they are cut at `Surface.SYMMETRY_Z`.
    below
        Name of the sides at the least y.
    """
    low, high = width

    def bar(number: int, first: float, last: float) -> Prism:
        start = Surface.BOLT_THREAD if number == 0 else Surface.FREE
        end = Surface.BOLT_HEAD if number == len(ends) - 2 else Surface.FREE
        corners = (
            ((first, low), below),
            ((last, low), end),
            ((last, high), Surface.FREE),
            ((first, high), start),
        )
        return Prism(polygon(*corners), (0.0, height))

    return SideBySide(tuple(bar(number, *pair) for number, pair in enumerate(pairwise(ends))))
