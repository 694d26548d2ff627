"""Bolts that bear on their holes: two blocks that a bolt presses together, sheared beyond friction."""

from functools import cache

import numpy as np
import pytest
from bolts import bolt

from fea.contact.assembly_state import BoltBeam
from fea.contact.bolts import BoltStop
from fea.contact.interfaces import MatingFaces, uniform
from fea.pins.assembly_states import AssemblyStates
from fea.solid.traction import traction_forces
from fea.study.assembly_table import parse_thread
from fea.verify.assembled_body import AssembledBody, along_x, apart, bars, pulled
from fea.verify.body import STEEL
from fea.verify.body import uniform as shear
from geometry.surfaces import Surface

FRICTION, PRELOAD, STIFF, LENGTH, SIDE = 0.2, 20e3, 4e5, 20.0, 10.0
AREA = SIDE * SIDE


@cache
def sheared(play):
    """The blocks with a load that shears their joint by 1 N, half of it on the cell."""
    names = {frozenset((0, 1)): (Surface.JOINT, Surface.JOINT_CAP)}
    body = bars((0.0, LENGTH, 2 * LENGTH), (-SIDE / 2, SIDE / 2), SIDE / 2)
    mesh = apart(body, 5.0, [LENGTH], along_x, names)
    joint = MatingFaces.of(mesh, (Surface.JOINT, Surface.JOINT_CAP), uniform(np.array([-1.0, 0.0, 0.0])))
    none = np.zeros((1, 1))
    beam = BoltBeam(np.eye(2), none[0], none[0], none[0], lateral=STIFF, play=play)
    around = np.ones(joint.pressing.size, dtype=bool)
    stops = BoltStop.pair(joint, around, beam, 0.5, len(mesh.points))
    loads = sum(
        traction_forces(mesh, surface, shear(0.0, way / AREA, 0.0))
        for surface, way in ((Surface.JOINT, 1.0), (Surface.JOINT_CAP, -1.0))
    )
    pull = pulled(mesh, 1e5, share=0.5)
    return AssembledBody(
        mesh, [STEEL, STEEL], [joint], [pull, *stops], loads[..., None], friction=FRICTION, preload=[PRELOAD]
    )


def borne(body, force):
    """What the bolt bears either way, N, and the mean slip of the joint, mm, under a force across it."""
    state = body.step([force])
    assembled, joint = body.assembled, body.problem.faces[0]
    at = joint.tangential[1] + body.problem.starts[0]
    slip = state.gap[np.searchsorted(assembled.interface, at)].sum() / AREA
    return AREA * state.values[assembled.stops], float(slip)


@pytest.mark.parametrize("play", [0.0, 0.01])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_bolt_bears_what_friction_does_not(play, way):
    # Coulomb on the whole joint, then the bolt as a spring: Q = μ F + k (s − play).
    body = sheared(play)
    held, _ = borne(body, 0.8 * way * FRICTION * PRELOAD)
    assert np.abs(held).max() <= (1e-9 if play else 0.02) * PRELOAD  # a fit takes of the micro-slip
    force = 1.5 * FRICTION * PRELOAD
    found, slip = borne(body, way * force)
    left = force - FRICTION * float(body.tension(body.step([way * force]))[0])
    assert found.max() == pytest.approx(left, rel=1e-6)
    assert found.min() == pytest.approx(0.0, abs=1e-6 * left)
    assert abs(slip) == pytest.approx(play + left / STIFF, rel=1e-6)


def test_a_bolt_across_the_joint_is_a_beam_of_its_diameter():
    # Timoshenko: s = F d³/(12 E I) + F d/(κ G A), κ = 0.886 of a circle of ν = 0.3 (Cowper 1966).
    thread, E = parse_thread("thread", "M10x1"), 2.1e5
    beam = bolt(thread=thread, shank_diameter=9.0, free_thread=10.0, hole=10.5, modulus=E).beam
    area, inertia = np.pi / 4 * 81, np.pi / 64 * 9.0**4
    give = 1000 / (12 * E * inertia) + 10 / (0.886 * E / 2.6 * area)
    assert 1 / beam.lateral == pytest.approx(give, rel=1e-3)
    assert beam.play == 0.25


def test_shear_of_every_bolt_is_summed_up():
    body = sheared(0.0)
    state = body.step([1.5 * FRICTION * PRELOAD])

    class Straight:
        beam = bolt(thread=parse_thread("thread", "M10x1"), free_thread=10.0).beam

        def moments(self, _state):
            return np.zeros((1, 2, 2))

    sums = AssemblyStates(body.assembled, FRICTION, np.zeros((1, 3)), Straight(), 0.0)
    assert sums(state).bolts[0].shear == pytest.approx(borne(body, 1.5 * FRICTION * PRELOAD)[0].max())
