"""A stepped flat bar in tension, D/d = 2, whose shoulders are sharp.

Without secondary bending the structural stress is the nominal one. The peaks at fillets are those of Young &
Budynas, Roark's Formulas for Stress and Strain (7th ed., 2002), table 17.1, case 5a: a polynomial fitted to
photoelastic and numerical figures, good to a few percent. The relation between notch and fillet is asymptotic
(Filippi, Lazzarin & Tovo 2002), so that 15 % is what it promises.
"""

import math

import numpy as np
import pytest

from fea.judge.sharp_places import SharpPlaces
from fea.solid.sharp_edges import SharpEdges
from fea.solid.stress import von_mises
from fea.solid.traction import traction_forces
from fea.verify.body import STEEL, LoadedBody, held
from geometry.bodies import Prism, draw, polygon
from geometry.session import session
from geometry.surfaces import Surface
from mesh.creases import creases
from mesh.generate import tetrahedralise
from mesh.sizing import Refinement, Sizing

D, WIDE, NOMINAL = 10.0, 20.0, 100.0  # narrow and wide side, mm; stress of the narrow one, MPa
STEP = (WIDE - D) / 2


def bar() -> Prism:
    low, high = D / 2, WIDE / 2
    corners = (
        ((-30.0, -low), Surface.FREE),
        ((0.0, -low), Surface.INNER),
        ((0.0, -high), Surface.FREE),
        ((25.0, -high), Surface.CLAMPED),
        ((25.0, high), Surface.FREE),
        ((0.0, high), Surface.INNER),
        ((0.0, low), Surface.FREE),
        ((-30.0, low), Surface.LOADED),
    )
    return Prism(polygon(*corners), (0.0, 2.0), top=Surface.ROLLER)


@pytest.fixture(scope="module")
def place():
    with session():
        faces = draw(bar())
        shoulders = [Refinement(faces[Surface.INNER], 0.5, 10.0)]
        mesh, _ = tetrahedralise(faces, shoulders, Sizing(4.0, 2, 0.4))
        found = creases(faces, mesh)
    forces = traction_forces(mesh, Surface.LOADED, lambda _, normals: NOMINAL * normals)
    fixed = held(mesh, {Surface.ROLLER: (2,), Surface.CLAMPED: (0, 1)})
    stress = LoadedBody(mesh, STEEL, forces, fixed, (Surface.FREE, Surface.INNER)).solved().stress
    edges = SharpEdges.of(mesh, found)
    factor = STEEL.yield_strength / von_mises(stress)
    nominal = STEEL.yield_strength / NOMINAL
    places = SharpPlaces(edges, STEEL.poissons_ratio)(stress, np.zeros(len(stress)), factor, nominal)
    assert len(places) == 2  # the shoulders on either side
    return places[0]


def roark(radius: float) -> float:
    """Peak over nominal stress for 2 ≤ h/r ≤ 20."""
    ratio, share = STEP / radius, 2 * STEP / WIDE
    root = math.sqrt(ratio)
    terms = (
        1.042 + 0.982 * root - 0.036 * ratio,
        -0.074 - 0.156 * root - 0.010 * ratio,
        -3.418 + 1.220 * root - 0.005 * ratio,
        3.450 - 2.046 * root + 0.051 * ratio,
    )
    return sum(term * share**power for power, term in enumerate(terms))


def test_the_shoulder_is_where_and_what_it_is(place):
    assert abs(place.at[0]) < 1e-9
    assert abs(place.at[1]) == pytest.approx(D / 2)
    assert math.degrees(place.opening) == pytest.approx(90.0)
    assert place.between == ("plane x = 0 mm", f"plane y = {math.copysign(D / 2, place.at[1]):g} mm")
    assert place.thickness == pytest.approx(D, rel=1e-3)
    assert place.length == pytest.approx(2.0)


def test_its_structural_stress_is_the_nominal_one(place):
    assert place.structural_stress == pytest.approx(NOMINAL, rel=0.03)


@pytest.mark.parametrize("radius", [0.3, 0.5, 1.0, 2.0])
def test_the_peak_at_a_fillet_is_roarks(place, radius):
    assert place.notch.peak(radius) == pytest.approx(roark(radius) * NOMINAL, rel=0.15)


def test_the_fillet_for_a_factor_has_it(place):
    radius = place.fillet(2.0)
    assert place.plane * abs(place.notch.peak(radius)) == pytest.approx(STEEL.yield_strength / 2.0, rel=1e-6)
    assert place.fillet(2.2) > radius
    assert place.fillet(5.0) is None  # the nominal stress itself has a factor of about 4
