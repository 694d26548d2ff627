"""What is worked out only where it can matter is what is found by looking everywhere."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fea.analysis.cycle import screened
from fea.analysis.cycle.screened import ExtremeBounds, extremes, path
from fea.analysis.cycle.unit_solutions import PartStress
from fea.judge.fatigue import enclosing_balls
from fea.judge.history import Extremes, deviatoric, extreme_principals
from fea.judge.history import extremes as everywhere
from fea.pins.model import NOT_JOINT, JointBounds, Weights
from fea.solid.stress import von_mises

NODES, UNITS = 40, 6


def _part(rng):
    even, odd = rng.normal(size=(2, NODES, 6, UNITS)) * rng.lognormal(size=(2, NODES, 1, UNITS))
    odd[::4] = 0.0  # some nodes lie on the plane
    return PartStress(np.arange(NODES), even, odd)


def _weights(rng, instants, roughness):
    """Smooth curves, a sharp pulse and noise."""
    angle = np.linspace(0, 4 * np.pi, instants)
    orders = rng.integers(1, 9, (2, UNITS, 1))
    smooth = rng.normal(size=(2, UNITS, 1)) * np.cos(orders * angle + rng.uniform(0, 6, (2, UNITS, 1)))
    pulse = rng.normal(size=(2, UNITS, 1)) * 3 * np.exp(-(((angle - 7.0) / 0.1) ** 2))
    mean = rng.normal(size=(2, UNITS, 1)) * rng.choice([0.0, 4.0])
    return Weights(*(smooth + pulse + mean + roughness * rng.normal(size=smooth.shape)))


@pytest.mark.parametrize(
    "joint", [NOT_JOINT, JointBounds(slice(1, 5), slice(2, UNITS))], ids=["alone", "joint"]
)
@pytest.mark.parametrize("sides", [(1,), (1, -1)], ids=["whole", "mirrored"])
@pytest.mark.parametrize("seed", range(12))
def test_screened_extremes_are_those_of_every_instant(seed, sides, joint):
    rng = np.random.default_rng(seed)
    part = dataclasses.replace(_part(rng), joint=joint)
    instants = int(rng.integers(2, 400))
    weights = _weights(rng, instants, rng.choice([0.0, 0.3]))
    (found,) = extremes([part], path(weights, joint), sides)
    for side, own in zip(sides, found, strict=True):
        even, odd = deviatoric(part.even), deviatoric(part.odd)
        expected = everywhere(even @ weights[0] + side * (odd @ weights[1]))
        for field in dataclasses.fields(Extremes):
            if field.name != "instant":  # of equal instants either may be named
                np.testing.assert_allclose(
                    getattr(own, field.name), getattr(expected, field.name), rtol=1e-5, err_msg=field.name
                )


def test_parts_do_not_know_of_each_other(monkeypatch):
    rng = np.random.default_rng(8)
    parts, weights = [_part(rng) for _ in range(3)], _weights(rng, 50, 0.0)
    monkeypatch.setattr(screened, "BLOCK_BYTES", 2**12)  # several blocks each
    along = path(weights)
    for part, found in zip(parts, extremes(parts, along, (1, -1)), strict=True):
        (alone,) = extremes([part], along, (1, -1))
        for own, other in zip(found, alone, strict=True):
            for field in dataclasses.fields(ExtremeBounds):
                np.testing.assert_array_equal(getattr(own, field.name), getattr(other, field.name))


@pytest.mark.parametrize("seed", range(6))
def test_balls_hold_every_instant(seed):
    rng = np.random.default_rng(seed)
    part, weights = _part(rng), _weights(rng, 200, 0.0)
    ((found,),) = extremes([part], path(weights), (1,))
    history = deviatoric(part.even) @ weights[0] + deviatoric(part.odd) @ weights[1]
    least, _ = enclosing_balls(history[:, :5])
    assert (found.radius >= least * (1 - 2e-3)).all()
    assert (found.radius <= found.von_mises).all()
    assert (found.tension >= history[:, 5].max(axis=1) - 1e-5 * least).all()


def test_a_place_without_stress_has_extremes_of_zero():
    part = PartStress(np.arange(2), np.zeros((2, 6, 1)), np.zeros((2, 6, 1)))
    ((found,),) = extremes([part], path(Weights(np.ones((1, 30)), np.ones((1, 30)))), (1,))
    for field in dataclasses.fields(Extremes):
        assert not getattr(found, field.name).any()


def test_extreme_principals_are_the_eigenvalues():
    rng = np.random.default_rng(3)
    turned = Rotation.random(50, rng=3).as_matrix()
    roots = np.sort(rng.normal(size=(50, 3)), axis=1)
    roots[0] = 0.0
    roots[1, 1] = roots[1, 0]
    matrices = turned @ (roots[:, :, None] * turned.swapaxes(1, 2))
    stress = matrices[:, [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    largest, least = extreme_principals(deviatoric(stress[..., None]), von_mises(stress)[:, None])
    np.testing.assert_allclose(largest[:, 0], roots[:, 2], rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(least[:, 0], roots[:, 0], rtol=1e-7, atol=1e-9)
