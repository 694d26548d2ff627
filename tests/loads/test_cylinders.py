import dataclasses
import math

import numpy as np
import pytest
from engines import DEG, LEON, LEON_ROD, RPM, rod_of

from fea.study.engine_table import EngineTable
from fea.study.traces import shipped_trace
from geometry.errors import InvalidValue
from loads.dynamics import cycle, whole_engine
from loads.engine import Engine
from loads.gas import Boyle, NoGas

ANGLES = np.arange(0, 720, 1.0) * DEG


def test_one_cylinder_is_its_cycle():
    single = dataclasses.replace(LEON, cylinders=1)
    gas = shipped_trace("leon-2001")
    whole = whole_engine(single, LEON_ROD, gas, 6000 * RPM, ANGLES)
    np.testing.assert_array_equal(whole.torque, cycle(single, LEON_ROD, gas, 6000 * RPM, ANGLES).torque)


def test_four_cylinders_at_180_degrees_shake_in_the_second_order_only():
    """First orders cancel in pairs, second ones add: 4 m r ω² λ cos 2θ and smaller even orders."""
    whole = whole_engine(LEON, LEON_ROD, NoGas(), 6000 * RPM, ANGLES)
    orders = np.abs(np.fft.rfft(whole.shaking_x)) / ANGLES.size * 2
    cycles = np.arange(orders.size)  # per 720°: order k of the crank is 2k
    odd = orders[(cycles % 4 != 0)]
    assert odd.max() < 1e-9 * orders[4]


def test_three_cylinders_at_240_degrees_balance_first_and_second_order():
    engine = Engine(38.5, 120, 73.6, 0.208e-3, cylinders=3, phase=math.radians(240))
    rod = rod_of(0.384, (31.77, 0.0), 9.3974e-4)
    whole = whole_engine(engine, rod, NoGas(), 3200 * RPM, ANGLES)
    orders = np.abs(np.fft.rfft(whole.shaking_x)) / ANGLES.size * 2
    assert max(orders[2], orders[4]) < 1e-9 * np.abs(whole.cylinders[0].shaking_x).max()


def test_mean_torque_of_the_engine_is_that_of_a_cylinder_times_their_number():
    engine = Engine(38.5, 120, 73.6, 0.208e-3, friction=0.1, cylinders=3, phase=math.radians(240))
    rod = rod_of(0.384, (31.77, 0.0), 9.3974e-4)
    whole = whole_engine(engine, rod, Boyle(engine, 5.2), 3200 * RPM, ANGLES)
    assert whole.torque.mean() == pytest.approx(3 * whole.cylinders[0].torque.mean(), rel=1e-9)
    assert whole.torque.mean() < 0  # friction alone is left: Boyle's gas gives back what it takes


@pytest.mark.parametrize(("banks", "phase"), [("AB", 360.0), ("AABB", 180.0)])
def test_the_forces_of_a_boxer_cancel(banks, phase):
    """Opposed pistons move as mirror images of each other: the frame feels no force."""
    axes = tuple(math.pi * (bank == "B") for bank in banks)
    engine = dataclasses.replace(LEON, cylinders=len(banks), phase=math.radians(phase), axes=axes)
    whole = whole_engine(engine, LEON_ROD, NoGas(), 6000 * RPM, ANGLES)
    largest = np.abs(whole.cylinders[0].shaking_x).max()
    np.testing.assert_allclose(whole.shaking_x, 0.0, atol=1e-9 * largest)
    np.testing.assert_allclose(whole.shaking_y, 0.0, atol=1e-9 * largest)


def test_the_first_order_of_a_right_angled_twin_turns_with_the_crank():
    """Both rods on one crank pin: the first orders add up to a force of constant size (den Hartog 1956)."""
    engine = dataclasses.replace(LEON, cylinders=2, phase=math.pi / 2, axes=(0.0, math.pi / 2))
    turn = np.arange(0.0, 2 * np.pi, 2 * np.pi / 360)
    whole = whole_engine(engine, LEON_ROD, NoGas(), 6000 * RPM, turn)
    force = whole.shaking_x + 1j * whole.shaking_y
    forwards, backwards = (abs(np.mean(force * np.exp(-1j * k * turn))) for k in (1, -1))
    assert forwards > 0
    assert backwards < 1e-3 * forwards


def table(**keys):
    return EngineTable(stroke_mm=94.0, bore_mm=76.0, piston_mass_kg=0.5, **keys)


@pytest.mark.parametrize(
    ("keys", "fires"),
    [
        ({"cylinders": 2, "bank_angle_deg": 45.0, "crank_pins_deg": (0.0, 0.0)}, [0, 405]),
        ({"cylinders": 2, "bank_angle_deg": 90.0, "crank_pins_deg": (0.0, 0.0)}, [0, 450]),
        (  # an early V6 of 90 degrees with three crank pins fires at intervals of 90 and 150 degrees
            {
                "cylinders": 6,
                "bank_angle_deg": 90.0,
                "crank_pins_deg": (0.0, 0.0, 240.0, 240.0, 120.0, 120.0),
            },
            [0, 90, 240, 330, 480, 570],
        ),
        (  # the later one, with pins split by 30 degrees, at equal ones
            {
                "cylinders": 6,
                "bank_angle_deg": 90.0,
                "crank_pins_deg": (0.0, 30.0, 240.0, 270.0, 120.0, 150.0),
            },
            [0, 120, 240, 360, 480, 600],
        ),
        ({"cylinders": 4, "crank_pins_deg": (0.0, 270.0, 90.0, 180.0)}, [0, 270, 450, 540]),  # crossplane
    ],
)
def test_cylinders_fire_when_their_crank_pins_reach_the_top(keys, fires):
    engine = table(**keys).engine(141.0)
    np.testing.assert_allclose(np.degrees(engine.firing_angles), fires, atol=1e-9)


def test_crank_pins_that_cannot_be_are_refused():
    with pytest.raises(InvalidValue, match="pin of each of 2 cylinders"):
        table(cylinders=2, crank_pins_deg=(0.0,)).engine(141.0)
    with pytest.raises(InvalidValue, match="would fire at 0, 300, 180 degrees"):
        table(cylinders=3, phase_deg=180.0, crank_pins_deg=(0.0, 300.0, 180.0)).engine(141.0)
