"""Small dense systems: in single precision where that does, in double where it does not."""

import numpy as np
import pytest

from fea.contact.trial import solved

SIZE = 40


def matrix(condition, seed=0):
    """With singular values from 1 to 1 / condition."""
    rng = np.random.default_rng(seed)
    left, right = (np.linalg.qr(rng.normal(size=(SIZE, SIZE)))[0] for _ in range(2))
    return left * np.geomspace(1.0, 1 / condition, SIZE) @ right.T


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("condition", [1.0, 1e2, 1e4, 1e7, 1e10])
def test_a_solution_is_as_accurate_as_the_condition_allows(condition, seed):
    own, exact = matrix(condition, seed), np.random.default_rng(seed).normal(size=SIZE)
    found, factor = solved(own, own @ exact)
    assert np.abs(own @ (found - exact)).max() < 1e-12 * np.abs(found).max()
    assert np.abs(found - exact).max() < 1e-13 * max(condition, 10.0) * np.abs(exact).max()
    single = factor.triangles.dtype == np.float32
    if condition <= 1e2 or condition >= 1e7:
        assert single == (condition <= 1e2)


def test_the_factor_of_a_matrix_that_is_nearly_the_same_is_used_again():
    own, side = matrix(100.0), np.ones(SIZE)
    _, factor = solved(own, side)
    changed = own + 1e-4 * matrix(1.0, seed=1) / 100
    found, again = solved(changed, side, factor)
    assert again is factor
    np.testing.assert_allclose(changed @ found, side, atol=1e-11)
    other = matrix(100.0, seed=2)
    found, fresh = solved(other, side, factor)
    assert fresh is not factor
    np.testing.assert_allclose(other @ found, side, atol=1e-11)


def test_a_motion_that_nothing_resists_stays_zero():
    own = matrix(10.0)
    own[3], own[:, 3] = 0.0, 0.0
    side = np.ones(SIZE)
    side[3] = 0.0
    found, factor = solved(own, side)
    assert factor is None
    assert abs(found[3]) < 1e-12
    np.testing.assert_allclose(own @ found, side, atol=1e-11)
    # Not along an axis, and free up to rounding.
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(SIZE, SIZE)))[0]
    free = turn @ own @ turn.T
    found, factor = solved(free, turn @ side)
    assert factor is None
    assert abs(turn[:, 3] @ found) < 1e-10
