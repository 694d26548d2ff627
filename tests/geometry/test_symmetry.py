"""Solids that are symmetric but for a little are not taken for it; the same solid in other faces is."""

import math

import gmsh
import numpy as np
import pytest

from geometry.cad.mirror_planes import smallest_cell
from geometry.session import session
from geometry.surfaces import Mirror

LEAN = 6 * math.tan(math.radians(0.2))  # of a draft of 0.2° over half the thickness, mm
BORES = ((0, 10), (100, 5))


def bored(occ, solid):
    """Cut the bores."""
    tools = [(3, occ.addCylinder(x, 0, -50, 0, 0, 100, r)) for x, r in BORES]
    return occ.cut(solid, tools)[0]


def strap(occ):
    return bored(occ, [(3, occ.addBox(-25, -20, -6, 150, 40, 12))])


def prism(occ, *section):
    """A bar with this section (y, z)."""
    points = [occ.addPoint(-25, y, z) for y, z in section]
    lines = [occ.addLine(a, b) for a, b in zip(points, points[1:] + points[:1], strict=True)]
    face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
    return bored(occ, [entity for entity in occ.extrude([(2, face)], 150, 0, 0) if entity[0] == 3])


def drafted(occ):
    """Both walls lean inwards above."""
    prism(occ, (-20 - LEAN, -6), (20 + LEAN, -6), (20 - LEAN, 6), (-20 + LEAN, 6))


def sheared(occ):
    """Both walls lean the same way."""
    prism(occ, (-20 - LEAN, -6), (20 - LEAN, -6), (20 + LEAN, 6), (-20 + LEAN, 6))


def parted(occ):
    """Drafted from a parting line amid each wall, as a forging is."""
    prism(occ, (-20, -6), (20, -6), (20 + LEAN, 0), (20, 6), (-20, 6), (-20 - LEAN, 0))


def chamfered(occ):
    """A chamfer of 0.3 mm along one edge."""
    ((_, body),) = strap(occ)
    occ.synchronize()
    edges = [tag for _, tag in gmsh.model.getEntitiesInBoundingBox(-26, 19.9, 5.9, 126, 20.1, 6.1, 1)]
    face = int(gmsh.model.getAdjacencies(1, edges[0])[0][0])
    occ.chamfer([body], edges, [face], [0.3])


def notched(occ, y, z):
    occ.cut(strap(occ), [(3, occ.addBox(50, y - 0.2, z - 0.2, 1, 0.4, 0.4))])


def drilled(occ, z):
    """A hole along y, at a height."""
    occ.cut(strap(occ), [(3, occ.addCylinder(50, -50, z, 0, 100, 0, 2))])


def bulged(occ, height):
    """One wall bulges above the plane as far as it is hollow below, and is straight along its rim."""
    points = [
        occ.addPoint(
            -25 + 5 * i, 20 + height * math.sin(math.pi * i / 30) ** 2 * math.sin(math.pi * j / 6), j
        )
        for j in range(-6, 7)
        for i in range(31)
    ]
    sheet = occ.addBSplineSurface(points, 31)
    pieces, _ = occ.fragment([(3, occ.addBox(-25, -20, -6, 150, 45, 12))], [(2, sheet)])
    solids = [tag for dim, tag in pieces if dim == 3]
    occ.synchronize()
    kept = min(solids, key=lambda tag: occ.getCenterOfMass(3, tag)[1])
    occ.remove([(3, tag) for tag in solids if tag != kept], recursive=True)
    bored(occ, [(3, kept)])


def divided(occ, low, high, *, pocket=0.0):
    """One wall is divided into several faces, by lines at two x, and its middle may lie deeper."""
    wall = occ.addRectangle(low, -6, 0, high - low, 12)
    occ.rotate([(2, wall)], 0, 0, 0, 1, 0, 0, math.pi / 2)
    occ.translate([(2, wall)], 0, 20, 0)
    pieces, _ = occ.fragment(strap(occ), [(2, wall)])
    if pocket:
        solids = [entity for entity in pieces if entity[0] == 3]
        occ.cut(solids, [(3, occ.addBox(low, 20 - pocket, -6, high - low, pocket, 12))])


DRAWN = {
    "divided on one side": (lambda occ: divided(occ, 30, 60), Mirror.QUARTER),
    "divided and deeper there": (lambda occ: divided(occ, 30, 60, pocket=0.02), Mirror.HALF),
    "plain": (strap, Mirror.QUARTER),
    "drafted from a parting line": (parted, Mirror.QUARTER),
    "drilled amid": (lambda occ: drilled(occ, 0.0), Mirror.QUARTER),
    "notched on one side, amid": (lambda occ: notched(occ, 20, 0), Mirror.HALF),
    "drafted by 0.2°": (drafted, Mirror.NONE),
    "leaning by 0.2°": (sheared, Mirror.NONE),
    "one chamfer of 0.3 mm": (chamfered, Mirror.NONE),
    "notched above": (lambda occ: notched(occ, 0, 6), Mirror.NONE),
    "drilled 0.01 mm off": (lambda occ: drilled(occ, 0.01), Mirror.NONE),
    "bulged": (lambda occ: bulged(occ, 0.3), Mirror.NONE),
    "hardly bulged": (lambda occ: bulged(occ, 0.02), Mirror.NONE),
    "not bulged": (lambda occ: bulged(occ, 0.0), Mirror.QUARTER),
}


@pytest.mark.parametrize("name", DRAWN)
def test_the_planes_found_are_those_that_the_solid_has(name):
    draw, mirror = DRAWN[name]
    with session():
        gmsh.model.add(name)
        draw(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        volumes = [tag for _, tag in gmsh.model.getEntities(3)]
        assert smallest_cell(volumes, 100.0) is mirror


def test_corners_that_the_kernel_misses_do_not_hide_a_plane(monkeypatch):
    # At a corner of its parameters the kernel may take the opposite corner of a face for the nearest point.
    closest = gmsh.model.getClosestPoint

    def missing(dim, tag, places):
        nearest, parameters = closest(dim, tag, places)
        at_corner = np.abs(np.reshape(places, (-1, 3)) - [-25, -20, 6]).max(axis=1) < 1e-6
        if dim == 2:
            nearest = np.reshape(nearest, (-1, 3)) - [[0, 0, 12]] * at_corner[:, None]
        return np.ravel(nearest), parameters

    with session():
        gmsh.model.add("corner")
        divided(gmsh.model.occ, 30, 60)
        gmsh.model.occ.synchronize()
        volumes = [tag for _, tag in gmsh.model.getEntities(3)]
        monkeypatch.setattr(gmsh.model, "getClosestPoint", missing)
        assert smallest_cell(volumes, 100.0) is Mirror.QUARTER
