"""The elastic pin of contact: a solid slice, a thin ring that becomes oval, slender pins that bend."""

import math

import numpy as np

from fea.contact.elastic_pin import ElasticPin, Pin
from fea.verify.benchmark import Benchmark, Computed, Goal
from geometry.arrays import Floats

E, NU = 206e3, 0.3
RADIUS, WALL = 10.0, 0.2  # of the slices
SLENDER, TOUCHED, SPAN, BOSS = 5.0, 25.0, 100.0, 2.0  # radius, half the bore's width, to the boss, its length
HOLLOW = 3.5

_MICHELL = "the closed form is exact; the rest is the mesh of the pin"
_BEAM = "Timoshenko's beam, whose sections stay plane; the pin is ten times as long as thick"
SOLID = {
    n: Goal(f"deflection of a solid slice under p cos {n}φ / exact", "1", 1.0, 0.2, _MICHELL) for n in (2, 9)
}
RING = Goal(
    "ovalisation of a ring / exact",
    "1",
    1.0,
    1.0,
    "the closed form neglects stretching and shear, of the order of the square of wall over radius",
)
BENT = {
    inner: Goal(f"sag of a pin with a bore of {2 * inner:g} mm / exact", "1", 1.0, 1.0, _BEAM)
    for inner in (0.0, HOLLOW)
}


def pressed(pin: Pin, order: int) -> tuple[Floats, Floats, Floats]:
    """Stations and inward displacements there, mm, under 1 MPa cos nφ on the contact, and on the supports."""
    half = ElasticPin(pin)
    (found,) = half.harmonics(np.array([order]))
    z = half.stations
    load = np.zeros(len(z))
    for first in range(0, len(z) - 2, 2):  # Simpson's rule along the quadratic elements
        load[first : first + 3] += (z[first + 2] - z[first]) * np.array([1, 4, 1]) / 6
    around = math.pi * (1 + (order == 0))
    return z, found.compliance @ (around * pin.radius * load), found.carried


def solid_slice(order: int) -> float:
    """Inward displacement, mm, of a solid slice under cos nφ of 1 MPa, n ≥ 2 (Michell 1899)."""
    n, mu = order, E / (2 * (1 + NU))
    # Airy's function (A rⁿ + B rⁿ⁺²) cos nφ with a radial traction of −cos nφ and no shear at the surface.
    a, b = np.linalg.solve([[n * (1 - n), n + 2 - n * n], [n * (n - 1), n * (n + 1)]], [-1.0, 0.0])
    return float((a * n - b * (2 - 4 * NU - n)) * RADIUS / (2 * mu))


def oval_ring() -> float:
    """Inward displacement, mm, of a thin long ring under cos 2φ of 1 MPa (Timoshenko 1940, article 78)."""
    mean = RADIUS - WALL / 2
    return RADIUS * mean**3 * (1 - NU**2) / (E * WALL**3 / 12 * 9)


def bent_pin(inner: float) -> tuple[float, float]:
    """Sag, mm, between the middle and four fifths of the half width: of the pin, and of Timoshenko's beam."""
    z, inward, carried = pressed(Pin(SLENDER, inner, TOUCHED, (SPAN, SPAN + BOSS), E, NU), 1)
    deflection = inward - TOUCHED / BOSS * carried  # the bosses carry what the bore presses with
    last = int(np.flatnonzero(z <= 0.8 * TOUCHED)[-1])
    x, force = float(z[last]), math.pi * SLENDER * TOUCHED  # on half of the pin
    area, inertia = math.pi * (SLENDER**2 - inner**2), math.pi / 4 * (SLENDER**4 - inner**4)
    m = inner / SLENDER
    shear = 6 * (1 + NU) * (1 + m**2) ** 2 / ((7 + 6 * NU) * (1 + m**2) ** 2 + (20 + 12 * NU) * m**2)
    q, moment = force / TOUCHED, force * (SPAN + BOSS / 2) - force * TOUCHED / 2
    bent = (moment * x**2 / 2 - q * x**4 / 24) / (E * inertia)
    sheared = q * x**2 / 2 / (shear * E / (2 * (1 + NU)) * area)
    return float(deflection[0] - deflection[last]), bent + sheared


def compute(_size: float) -> Computed:
    """Compare with the closed forms; the pin has a mesh of its own, which no element size changes."""
    found = {}
    for order, goal in SOLID.items():
        _, inward, _ = pressed(Pin(RADIUS, 0.0, 4.0, None, E, NU), order)
        found[goal.quantity] = float(inward.mean() / solid_slice(order))
    _, inward, _ = pressed(Pin(RADIUS, RADIUS - WALL, 4.0, None, E, NU), 2)
    found[RING.quantity] = float(inward.mean() / oval_ring())
    for inner, goal in BENT.items():
        sag, exact = bent_pin(inner)
        found[goal.quantity] = sag / exact
    return Computed(found, 0)


BENCHMARK = Benchmark(
    title="Elastic pin: harmonics, ovalisation, bending",
    source="Michell 1899; Timoshenko 1940, Strength of Materials II; Cowper 1966 (shear coefficients)",
    goals=(*SOLID.values(), RING, *BENT.values()),
    compute=compute,
    size=1.0,
    converges=False,
)
