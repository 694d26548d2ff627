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

from fea.base.material import Material
from fea.contact.elastic_pin import Pin
from fea.contact.interfaces import PinInBore
from fea.contact.multipliers import Multipliers, radial
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, held
from fea.verify.contact_body import TouchedBody, contact_end
from geometry.bodies import Prism, Side
from geometry.segments import Arc, Line
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.tetmesh import TetMesh

RADIUS, OUTSIDE, FORCE = 10.0, 600.0, 1000.0  # mm, mm, N/mm
_E, _NU = STEEL.youngs_modulus, STEEL.poissons_ratio
_PLANE = _E / (1 - _NU**2)
ALUMINIUM = Material(70e3, 0.3, 2.7e-9, 400.0)
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
# A steel pin in aluminium, X with the E' of the plate: half angle, p R / Q and hoop R / Q by collocation of
# the integral equation, to three digits.
_COLLOCATED = {1.0: (55.1, 0.751, 0.592), 0.0: (82.4, 0.604, 0.464)}


def _unlike_goals(X: float) -> tuple[Goal, Goal, Goal]:
    angle, largest, around = _COLLOCATED[X]
    why = "the target has three digits"
    return (
        Goal(f"steel in aluminium: p R / Q, X = {X:g}", "1", largest, 1.0, why),
        Goal(f"steel in aluminium: half angle, X = {X:g}", "°", angle, 100 / angle, why),
        Goal(f"steel in aluminium: hoop R / Q, X = {X:g}", "1", around, 1.0, why),
    )


_UNLIKE = {X: _unlike_goals(X) for X in _COLLOCATED}
NEAT = Goal(
    "pressures of 1000 N over those of 1 N, neat fit",
    "1",
    1000.0,
    1e-7,
    "the contact of a neat fit does not depend on the size of the force; only rounding errors remain",
)


def sliced(size: float) -> TetMesh:
    """Mesh half of a slice of the plate, with elements of `size` at the hole."""
    sides = (
        Side(Line((-OUTSIDE, 0.0), (-RADIUS, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), RADIUS, math.pi, -math.pi), Surface.INNER),
        Side(Line((RADIUS, 0.0), (OUTSIDE, 0.0)), Surface.SYMMETRY_Y),
        Side(Arc((0.0, 0.0), OUTSIDE, 0.0, math.pi), Surface.OUTER),
    )
    return mesh_body(Prism(sides, (0.0, size)), OUTSIDE / 10, fine={Surface.INNER: Fine(size)})


def plate(mesh: TetMesh, material: Material) -> TouchedBody:
    """The plate and its steel pin."""
    size = float(mesh.points[:, 2].max())
    fixed = held(mesh, {Surface.OUTER: (0, 1)})
    fixed[mesh.points[:, 2] > size * (1 - 1e-9), 2] = True
    multipliers = Multipliers.of(mesh, Surface.INNER, radial(0.0))
    pin = Pin(RADIUS, 0.0, size, None, _E, _NU)
    return TouchedBody(
        mesh, material, fixed, PinInBore(multipliers, (0.0, 0.0), 0.0, pin, cut_y=True, cut_z=True)
    )


def compute(size: float) -> Computed:
    """Solve every fit of a plate with one factorisation."""
    mesh = sliced(size)
    found: dict[str, float] = {}
    steel, aluminium = plate(mesh, STEEL), plate(mesh, ALUMINIUM)
    for X, goals in _GOALS.items():
        found |= _figures(steel, X * FORCE / _PLANE, goals)
    for X, goals in _UNLIKE.items():
        plane = ALUMINIUM.youngs_modulus / (1 - ALUMINIUM.poissons_ratio**2)
        found |= _figures(aluminium, X * FORCE / plane, goals)
    body = steel
    one, thousand = (body.touched(0.0, force).pressure for force in (1.0, 1e3))
    touching = one > 0
    ratios = thousand[touching] / one[touching]
    found[NEAT.quantity] = float(ratios[np.abs(ratios - 1e3).argmax()])
    return Computed(found, mesh.points.size)


def _figures(body: TouchedBody, clearance: float, goals: tuple[Goal, Goal, Goal]) -> dict[str, float]:
    """Largest pressure, half angle and largest hoop stress, by the quantities of the goals."""
    mesh, bore = body.mesh, body.mesh.facets[Surface.INNER]
    on_bore, vertices = np.unique(bore), np.unique(bore[:, :3])
    angle, at = (np.arctan2(mesh.points[own, 1], mesh.points[own, 0]) for own in (on_bore, vertices))
    p = body.touched(clearance, FORCE * 2 * float(mesh.points[:, 2].max())).pressure
    xx, yy, _, xy, _, _ = body.stress(p)[on_bore].T
    hoop = xx * np.sin(angle) ** 2 + yy * np.cos(angle) ** 2 - xy * np.sin(2 * angle)
    figures = (p.max() * RADIUS / FORCE, math.degrees(contact_end(at, p)), hoop.max() * RADIUS / FORCE)
    return {goal.quantity: float(figure) for goal, figure in zip(goals, figures, strict=True)}


BENCHMARK = Benchmark(
    title="Pin in a plate: contact with clearance and interference",
    source="Persson 1964, plane strain, pin and plate of the same material",
    goals=(*(goal for of in (_GOALS, _UNLIKE) for goals in of.values() for goal in goals), NEAT),
    compute=compute,
    size=0.06,
    converges=False,
)
