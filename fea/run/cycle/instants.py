"""What acts on a rod at instants of a crank cycle and in load cases."""

from collections.abc import Sequence

import numpy as np

from fea.pins.unit_loads import Course, Instants
from fea.units import DEG
from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.cases import LoadCase, RodMotion
from loads.dynamics import cycle, origin_acceleration
from loads.engine import Engine
from loads.gas import GasModel
from loads.slider_crank import cycle_angles

# Increments of a cycle, where friction makes it depend on its course: how many; and the crank angle at which
# it begins, in degrees: before the dead centre of gas exchange, at which the inertia pulls most, so that
# little is left afterwards of what friction did before.
INCREMENTS, BEGINNING = 80, -60


def instants(engine: Engine, gas: GasModel, rod: MassProperties, speed: float, angles: Floats) -> Instants:
    """What acts on a rod at crank angles (n,), rad; speed in rad/s."""
    c = cycle(engine, rod, gas, speed, angles)
    return Instants(
        np.stack([c.pin_axial, c.pin_transverse]),
        np.stack([-c.crank_axial, c.crank_transverse]),
        np.stack(origin_acceleration(engine, c.motion)),
        -c.motion.rod_rate,
        -c.motion.rod_acceleration,
    )


def of_cases(cases: Sequence[LoadCase]) -> Instants:
    """What acts on a rod in load cases."""
    still = RodMotion((0.0, 0.0), 0.0, 0.0)
    motions = [case.motion or still for case in cases]
    return Instants(
        np.array([[case.pin_axial, case.pin_transverse] for case in cases]).T,
        np.array([[-case.crank_axial, case.crank_transverse] for case in cases]).T,
        np.array([motion.acceleration for motion in motions]).T,
        np.array([motion.angular_velocity for motion in motions]),
        np.array([motion.angular_acceleration for motion in motions]),
    )


def as_cases(instants: Instants, name: str) -> list[LoadCase]:
    """Load cases of instants."""
    (pin, across), (crank, crank_across) = instants.pin, instants.crank
    return [
        LoadCase(
            name=name,
            crank_angle=None,
            pin_axial=pin[k],
            pin_transverse=across[k],
            crank_axial=-crank[k],
            crank_transverse=crank_across[k],
            motion=RodMotion(
                (instants.acceleration[0, k], instants.acceleration[1, k]),
                instants.rate[k],
                instants.turning[k],
            ),
        )
        for k in range(len(instants.rate))
    ]


def course(engine: Engine, gas: GasModel, rod: MassProperties, speed: float, angles: Floats) -> Course:
    """The cycle that crank angles (n,), rad, belong to; speed in rad/s.

    Half of what divides it into increments, of whole degrees, is the crank angle; the other half is the
    change of the pins' forces.
    """
    degrees = BEGINNING + np.arange(float(len(cycle_angles())))
    every = instants(engine, gas, rod, speed, degrees * DEG)
    forces = np.diff(np.concatenate([every.pin, every.crank]), axis=1)
    changed = np.append(0.0, np.cumsum(np.linalg.norm(forces, axis=0)))
    passed = np.linspace(0.0, 1.0, len(degrees))
    shares = (passed + changed / changed[-1]) / 2 if changed[-1] > 0 else passed
    places = np.interp(np.arange(INCREMENTS) / INCREMENTS, shares, np.arange(len(degrees)))
    steps = np.unique(np.round(places).astype(int))
    acting = Instants(*(own[..., steps] for own in every))
    return Course(angles, degrees[steps] * DEG, acting)


def whole_cycle(engine: Engine, gas: GasModel, rod: MassProperties, speed: float) -> tuple[Instants, Course]:
    """What acts on a rod at every degree of a cycle, and the cycle itself; speed in rad/s."""
    degrees = cycle_angles()
    return instants(engine, gas, rod, speed, degrees), course(engine, gas, rod, speed, degrees)
