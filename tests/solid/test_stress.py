import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fea.judge.verdict import CAP, element_largest, safety_factor
from fea.solid.stress import principal, von_mises

# Where products underflow, LAPACK's eigenvalues are off by 5e-8.
values = st.floats(-1e3, 1e3).map(lambda value: value if abs(value) > 1e-100 else 0.0)
tensors = arrays(float, (5, 6), elements=values)


def matrix(stress):
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    return np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=-1).reshape(*stress.shape[:-1], 3, 3)


@given(tensors)
def test_principal_stresses_are_the_eigenvalues(stress):
    expected = np.linalg.eigvalsh(matrix(stress))[..., ::-1]
    # coincident roots of a cubic are known to the square root of rounding
    assert principal(stress) == pytest.approx(expected, abs=3e-8 * max(np.abs(stress).max(), 1e-300))


@given(tensors)
def test_von_mises_is_the_norm_of_the_deviator(stress):
    full = matrix(stress)
    deviator = full - np.trace(full, axis1=-2, axis2=-1)[..., None, None] / 3 * np.eye(3)
    expected = np.sqrt(1.5 * (deviator**2).sum(axis=(-2, -1)))
    assert von_mises(stress) == pytest.approx(expected, abs=1e-10 * max(np.abs(stress).max(), 1e-300))


def test_textbook_states():
    uniaxial, pure_shear, hydrostatic = np.eye(6)[0] * 100, np.eye(6)[3] * 100, np.r_[7.0, 7, 7, 0, 0, 0]
    assert von_mises(uniaxial) == pytest.approx(100)
    assert von_mises(pure_shear) == pytest.approx(100 * np.sqrt(3))
    assert von_mises(hydrostatic) == pytest.approx(0, abs=1e-12)
    assert principal(pure_shear) == pytest.approx([100, 0, -100], abs=1e-6)
    assert principal(hydrostatic) == pytest.approx([7, 7, 7])


def test_safety_is_yield_over_stress_and_capped():
    stress = np.array([0.0, 100.0, 310.2, 1240.8])
    assert safety_factor(stress, 620.4) == pytest.approx([CAP, 6.204, 2, 0.5])
    assert element_largest(stress, np.array([[0, 1], [2, 3]])) == pytest.approx([100, 1240.8])
