"""The hand calculation: numbers that were worked on paper, and its ratios to a run."""

import math

import numpy as np
import pytest
from reports import reported_rod

from fea.analysis.hand_calculation import bolt_force, gas_force, inertia_force, johnson_load
from fea.base.units import KG, RPM
from fea.judge.column import Plane
from fea.output.tables import hand_tables
from geometry.section import CrossSection

SQUARE = CrossSection(0.0, 100.0, 1e4 / 12, 1e4 / 12)  # 10 mm × 10 mm


def test_the_inertia_of_a_piston():
    # 0.5 kg · 0.045 m · (628.3185/s)² · 1.3 = 11 547 N; 0.6 kg on the crank pin pull with 10 659 N more
    assert inertia_force(0.5 * KG, 45.0, 6000 * RPM, 0.3) == pytest.approx(11_547.4, rel=1e-5)
    both = inertia_force(0.5 * KG, 45.0, 6000 * RPM, 0.3, 0.6 * KG)
    assert both == pytest.approx(11_547.4 + 10_659.2, rel=1e-5)


def test_gas_and_bolt():
    assert gas_force(7.0, 76.0) == pytest.approx(31_755.2, rel=1e-6)  # 70 bar on 4536.46 mm²
    assert bolt_force(40e3, 0.2, 50e3, 2) == pytest.approx(45e3)


@pytest.mark.parametrize(
    ("plane", "length", "load"),
    [
        # P_E = π² 207 000 · 833.33/200² = 42 562.6 N; 35 000 (1 − 35 000/(4 · 42 562.6)) = 27 804.7 N
        (Plane.IN_PLANE, 200.0, 27_804.7),
        # Sideways half of the length buckles: P_E = 170 250.5 N
        (Plane.SIDEWAYS, 200.0, 33_201.2),
        # Above l/k = √(2π²E/S_y) = 108 Euler's load: 42 562.6 N/4
        (Plane.IN_PLANE, 400.0, 10_640.7),
    ],
)
def test_johnsons_column(plane, length, load):
    assert johnson_load(SQUARE, plane, length, 207e3, 350.0) == pytest.approx(load, rel=1e-5)


def inertia_beyond(rod, station, load):
    """Force along the rod, N, of the mass beyond a station, mm: −m (a_x − ω² x)."""
    mesh = rod.mesh.whole
    corners = mesh.points[mesh.tets[:, :4]]
    mass = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6 * rod.materials[0].density
    x = corners[..., 0].mean(axis=1)
    along, square, *_ = load.motions
    return -float((mass * (along - square * x))[x > station].sum())


def test_a_run_is_compared_with_the_hand():
    rod, result, _, _ = reported_rod()
    hand, loads = result.summary.hand, result.summary.loads
    assert set(hand) == {
        "piston_inertia", "inertia", "gas", "shank_pulled", "shank_pushed", "goodman", "column",
    }  # fmt: skip
    # In the frame of the piston the gas is all that the formula leaves out.
    assert hand["gas"].ratio == pytest.approx(1.0, rel=1e-6)
    for name in ("piston_inertia", "inertia"):
        without = hand[name].result + loads["tension"].gas_N / 1e3
        # The exact motion at 3.6° after the dead centre has lost less than 1 % of its acceleration.
        assert without == pytest.approx(hand[name].value, rel=0.01)
    # The mean stress over the section carries the force at the pin and the inertia of the rod beyond.
    section = rod.shank[1]
    for name, case in (("shank_pulled", "tension"), ("shank_pushed", "compression")):
        force = float(result.cases[case].load.pin_axial) + inertia_beyond(
            rod, section.x, result.cases[case].load
        )
        # 2 %: elements of 14 mm straddle the section, and each counts on one side of it.
        assert hand[name].result == pytest.approx(force / section.area, rel=0.02)
    mean, amplitude = (
        (hand["shank_pulled"].value + sign * hand["shank_pushed"].value) / 2 for sign in (1, -1)
    )
    material = rod.materials[0]
    limit = material.endurance_limit * material.marin.rest.factor
    assert 1 / hand["goodman"].value == pytest.approx(
        amplitude / limit + max(mean, 0) / material.ultimate_strength
    )
    assert hand["goodman"].ratio < 1.1  # a notch cannot be safer than the plain section by more than a mesh
    assert hand["column"].ratio > 1
    (table,) = hand_tables(result.summary)
    assert [row[0] for row in table.rows] == [each.title for each in hand.values()]
    assert all(math.isfinite(float(row[-1])) for row in table.rows)
