import pytest

from geometry.mass import MassProperties, joined

# A unit cube with one corner at the origin: I = m/6 about its centre.
CUBE = MassProperties(1.0, (0.5, 0.5, 0.5), ((1 / 6, 0, 0), (0, 1 / 6, 0), (0, 0, 1 / 6)))


def test_a_reflected_cube_is_a_block():
    block = CUBE.reflected(1).reflected(2)  # 1 × 2 × 2
    assert block.mass == 4
    assert block.center == (0.5, 0.0, 0.0)
    assert [block.inertia[i][i] for i in range(3)] == pytest.approx([4 * 8 / 12, 4 * 5 / 12, 4 * 5 / 12])
    assert block.inertia[0][1:] == pytest.approx((0, 0))


def test_joined_bodies_keep_their_products_of_inertia():
    # Two cubes along the diagonal of the x–y plane: Ixy = −Σ m dx dy.
    other = MassProperties(1.0, (2.5, 2.5, 0.5), CUBE.inertia)
    pair = joined((CUBE, other))
    assert pair.inertia[0][1] == pytest.approx(-2.0)
    assert pair.inertia_z == pytest.approx(2 / 6 + 4.0)


def test_density_scales_mass_and_inertia():
    steel = CUBE.times(7.7e-9)
    assert steel.mass == 7.7e-9
    assert steel.inertia_z == pytest.approx(7.7e-9 / 6)
    assert steel.center == CUBE.center
