"""Bending of bolts beside a joint that is partly open."""

from dataclasses import replace

import numpy as np
import pytest

from fea.verify.cases.assemblies import _PULL, _eccentric_block


@pytest.mark.parametrize("pull", [0.0, 2.2, 2.6])
def test_moments_bend_the_bolt_as_they_turn_its_seats(pull):
    """They act on the parts as loads, and contact is solved once more.

    The edge of what is open moves a little: 0.1 %. With the compliance of the closed joint 0.4 and 1.5 %.
    """
    body, bending = _eccentric_block(4.0)
    assembled = body.assembled
    state = body.step([pull * _PULL, 0.0])
    moments = bending.moments(state).ravel()
    unfolding = bending._unfolding
    unit = unfolding.parts(np.eye(unfolding.size))
    gap = assembled.problem.unfolding.moments({p: own.T @ unit[p] for p, own in bending._turned.items()})
    values, amounts = assembled.sticking(gap, bending._moved.T)
    beams = unfolding.compliance(
        dict.fromkeys(unfolding.parities(), 0.5 * np.kron(np.eye(2), bending.beam.flexibility))
    )
    itself = bending._compliance - beams - gap.T @ values - bending._moved @ amounts
    load = state.load
    back = replace(load, gap=load.gap - gap @ moments, parts=load.parts - bending._moved.T @ moments)
    turns = bending._turns(assembled.steps().step(back, state)) - itself @ moments + bending._made
    assert turns == pytest.approx(beams @ moments, rel=2e-3, abs=1e-9)
