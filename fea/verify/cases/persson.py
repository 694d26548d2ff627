"""Persson's pin: an elastic pin in the hole of a large plate of the same material, plane strain, no friction.

The pressure depends on X = E' ΔR / Q alone, with ΔR the difference of the radii, Q the force per thickness
and E' = E / (1 − ν²): X = 0 is a neat fit, X < 0 a press fit that has not lifted off all the way round. With
b the tangent of a quarter of the contact's arc, Persson gives X and the pressure in closed form. The stress
around the hole follows from the pressure's Fourier coefficients p₀ and p₁ (Michell 1899): σ_θ = −p + 2 p₀ +
2 κ / (κ + 1) p₁ cos θ with κ = 3 − 4 ν and p₁ = Q / (π R). It is largest where the contact ends, where its
slope is infinite: hence the small elements.
"""

import math

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from fea.contact.elastic_pin import Pin
from fea.contact.interface import PinInBore
from fea.contact.multipliers import Multipliers, radial
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, held
from fea.verify.contact_body import TouchedBody, contact_end
from geometry.bodies.shape import Prism, Side
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.body import Fine, mesh_body

RADIUS, OUTSIDE, FORCE = 10.0, 600.0, 1000.0  # mm, mm, N/mm
_E, _NU = STEEL.youngs_modulus, STEEL.poissons_ratio
_PLANE = _E / (1 - _NU**2)
FITS = (5.0, 2.0, 1.0, 0.5, 0.2, 0.0, -0.2, -0.4)


def half_angle(X: float) -> float:
    """Half of the arc of contact, rad (Persson 1964)."""

    def off(angle: float) -> float:
        square = math.tan(angle / 2) ** 2
        return (2 - math.log(square + 1) - 2 * square**2) / (math.pi * square * (square + 1)) - X

    return float(brentq(off, math.radians(5), math.radians(170)))


def pressure(X: float, theta: float) -> float:
    """P R / Q at an angle from the force, rad (Persson 1964)."""
    b, y = math.tan(half_angle(X) / 2), math.tan(theta / 2)
    root, left = math.sqrt(b * b + 1), math.sqrt(max(b * b - y * y, 0.0))
    smooth = 2 * left / (math.pi * root * (1 + y * y))
    return float(smooth + math.log((root + left) / (root - left)) / (2 * math.pi * b * b * (b * b + 1)))


def largest_hoop(X: float) -> float:
    """σ_θ R / Q where the contact ends."""
    end = half_angle(X)
    mean = float(quad(lambda theta: pressure(X, theta), 0, end)[0]) / math.pi
    kappa = 3 - 4 * _NU
    return 2 * mean + 2 * kappa / (kappa + 1) / math.pi * math.cos(end)


def _goals(X: float) -> tuple[Goal, Goal, Goal]:
    angle = math.degrees(half_angle(X))
    plate = "the plate is a ring, sixty times as large as the hole; the rest is the mesh"
    return (
        Goal(f"p R / Q, X = {X:g}", "1", pressure(X, 0.0), 0.5, plate),
        Goal(f"half angle, X = {X:g}", "°", angle, 50 / angle, "half a degree: the distance of two vertices"),
        Goal(f"hoop R / Q, X = {X:g}", "1", largest_hoop(X), 1.0, "its slope is infinite at its peak"),
    )


_GOALS = {X: _goals(X) for X in FITS}
NEAT = Goal(
    "pressures of 1000 N over those of 1 N, neat fit",
    "1",
    1000.0,
    1e-7,
    "the contact of a neat fit does not depend on the size of the force; only rounding errors remain",
)


def plate(size: float) -> TouchedBody:
    """Half of a slice of the plate, with elements of `size` at the hole, and its pin."""
    sides = (
        Side(Line((-OUTSIDE, 0.0), (-RADIUS, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), RADIUS, math.pi, -math.pi), Surface.INNER),
        Side(Line((RADIUS, 0.0), (OUTSIDE, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), OUTSIDE, 0.0, math.pi), Surface.OUTER),
    )
    mesh = mesh_body(Prism(sides, (0.0, size)), OUTSIDE / 10, fine={Surface.INNER: Fine(size)})
    fixed = held(mesh, {Surface.OUTER: (0, 1)})
    fixed[mesh.points[:, 2] > size * (1 - 1e-9), 2] = True
    multipliers = Multipliers.of(mesh, Surface.INNER, radial(0.0))
    pin = Pin(RADIUS, 0.0, size, None, _E, _NU)
    return TouchedBody(
        mesh, STEEL, fixed, PinInBore(multipliers, (0.0, 0.0), 0.0, pin, cut_y=True, cut_z=True)
    )


def compute(size: float) -> Computed:
    """Solve every fit with one factorisation."""
    body = plate(size)
    mesh, bore = body.mesh, body.mesh.facets[Surface.INNER]
    on_bore, thickness = np.unique(bore), 2 * size
    angle = np.arctan2(mesh.points[on_bore, 1], mesh.points[on_bore, 0])
    vertices = np.unique(bore[:, :3])
    at = np.arctan2(mesh.points[vertices, 1], mesh.points[vertices, 0])
    found: dict[str, float] = {}
    for X in FITS:
        p = body.touched(X * FORCE / _PLANE, FORCE * thickness).pressure
        xx, yy, _, xy, _, _ = body.stress(p)[on_bore].T
        hoop = xx * np.sin(angle) ** 2 + yy * np.cos(angle) ** 2 - xy * np.sin(2 * angle)
        largest, arc, around = (goal.quantity for goal in _GOALS[X])
        found[largest] = float(p.max() * RADIUS / FORCE)
        found[arc] = math.degrees(contact_end(at, p))
        found[around] = float(hoop.max() * RADIUS / FORCE)
    one, thousand = (body.touched(0.0, force).pressure for force in (1.0, 1e3))
    touching = one > 0
    ratios = thousand[touching] / one[touching]
    found[NEAT.quantity] = float(ratios[np.abs(ratios - 1e3).argmax()])
    return Computed(found, mesh.points.size)


BENCHMARK = Benchmark(
    title="Pin in a plate: contact with clearance and interference",
    source="Persson 1964, plane strain, pin and plate of the same material",
    goals=(*(goal for goals in _GOALS.values() for goal in goals), NEAT),
    compute=compute,
    size=0.06,
    converges=False,
)
