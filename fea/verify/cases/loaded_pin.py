"""NAFEMS R0094, benchmark 4: a steel pin in friction in the hole of an aluminium sheet, pulled along it.

The pin fits without clearance, so that the stress grows in proportion to the force, and one step of it is
exact. The benchmark has only curves.
"""

import math
from typing import NamedTuple

import numpy as np

from fea.contact.mating import MatingFaces
from fea.material import Material
from fea.solid.traction import traction_forces
from fea.verify.assembled_body import AssembledBody
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.cases.lame_fit import outwards
from fea.verify.parted import parted
from geometry.arrays import Floats
from geometry.bodies.shape import Prism, Side, SideBySide
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.body import mesh_body
from mesh.numbering import numbered
from mesh.separate import separated
from mesh.tetmesh import TetMesh

# Radii of pin and sheet, length of the sheet from the pin's axis; half of the sheet's thickness and of the
# pin's length, mm. N.
RADIUS, OUTSIDE, LENGTH, HALF, PIN_HALF, FORCE = 50.0, 100.0, 200.0, 5.0, 10.0, 100e3
FRICTION = 0.1
PIN, SHEET = Material(210e3, 0.3, 7.85e-9, 400.0), Material(70e3, 0.3, 2.7e-9, 400.0)
SIDES = Surface.SHELL_SEAT, Surface.SHELL_BACK
# From the force, degrees.
ANGLES = (0.0, 30.0, 60.0)


def drawn(size: float) -> TetMesh:
    """A quarter of pin and sheet."""
    arc = Arc((0.0, 0.0), RADIUS, math.pi, -math.pi)
    free, cut = Surface.FREE, Surface.SYMMETRY_Y
    pin = (Side(arc, free), Side(Line((RADIUS, 0.0), (-RADIUS, 0.0)), cut))
    sheet = (
        Side(arc, free),
        Side(Line((RADIUS, 0.0), (OUTSIDE, 0.0)), cut),
        Side(Arc((0.0, 0.0), OUTSIDE, 0.0, math.pi / 2), free),
        Side(Line((0.0, OUTSIDE), (-LENGTH, OUTSIDE)), free),
        Side(Line((-LENGTH, OUTSIDE), (-LENGTH, 0.0)), Surface.CLAMPED),
        Side(Line((-LENGTH, 0.0), (-RADIUS, 0.0)), cut),
    )
    longer = Prism(pin, (0.0, HALF, PIN_HALF), top=Surface.LOADED)
    mesh = parted(mesh_body(SideBySide((longer, Prism(sheet, (0.0, HALF)))), size), [RADIUS], _radius)
    return numbered(separated(mesh, {(1, 0): SIDES})[0])[0]


def _radius(places: Floats) -> Floats:
    return np.asarray(np.hypot(places[..., 0], places[..., 1]))


def loaded(size: float, friction: float = FRICTION) -> AssembledBody:
    """Pin and sheet; the load is 1 N on the ends of the pin and at the end of the sheet."""
    mesh = drawn(size)
    areas = {Surface.LOADED: 2 * math.pi * RADIUS**2, Surface.CLAMPED: -4 * OUTSIDE * HALF}
    pull = np.zeros_like(mesh.points)
    for surface, area in areas.items():
        stress = np.array([1 / area, 0.0, 0.0])
        pull += traction_forces(mesh, surface, lambda places, _, s=stress: np.broadcast_to(s, places.shape))
    face = MatingFaces.of(mesh, SIDES, outwards, friction=friction > 0)
    return AssembledBody(mesh, (PIN, SHEET), [face], [], pull[..., None], friction=friction)


class Around(NamedTuple):
    """Pressure and shear stress, MPa, at angles from the force, rad, in the middle of the sheet."""

    angle: Floats
    pressure: Floats
    shear: Floats


def around(body: AssembledBody) -> Around:
    """Solve for the force."""
    pressure, _, shear = body.stresses(body.step([FORCE]))
    nodes = body.problem.faces[0].pressing.nodes
    x, y, z = body.mesh.points[nodes].T
    middle = np.flatnonzero(z < 1e-9 * RADIUS)
    angle = np.arctan2(y, x)[middle]
    order = np.argsort(angle)
    return Around(angle[order], pressure[middle][order], shear[middle][order])
