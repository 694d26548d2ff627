"""To what the displacement of a rod refers that nothing holds."""

from dataclasses import replace

import numpy as np
import pytest

from fea import prepare
from fea.solid.supports import bore_mean, referred_to_bores, rigid_motions
from fea.solid.traction import traction_forces
from geometry.surfaces import Surface


@pytest.fixture(scope="module")
def mesh():
    """A rod that no plane mirrors."""
    mesh = prepare("leon-2001", size=20).mesh.whole
    return replace(mesh, points=mesh.points + np.array([0.4, 0.3, 0.2]))


def test_which_nodes_hold_the_rod_does_not_move_it(mesh):
    """Restraints at other nodes, as on a renumbered mesh, add a rigid motion, which no result must show."""
    numbers = np.random.default_rng(3)
    waves = np.sin(mesh.points[:, :1] * [0.01, 0.02, 0.03, 0.05])
    bent = (waves @ numbers.normal(size=(4, 3)) * 1e-3)[..., None]
    motions = rigid_motions(mesh.points, np.zeros(3))
    moved = bent + np.tensordot(numbers.normal(size=6) * 1e-2, motions, axes=1)[..., None]
    referred = referred_to_bores(mesh, bent)
    np.testing.assert_allclose(referred_to_bores(mesh, moved), referred, atol=1e-13)


def test_the_bores_are_at_rest_in_the_mean(mesh):
    u = np.random.default_rng(5).normal(size=(len(mesh.points), 3, 2))
    referred = referred_to_bores(mesh, u)
    big, small = (bore_mean(mesh, end, referred) for end in (Surface.BIG_END_BORE, Surface.SMALL_END_BORE))
    turns = traction_forces(mesh, Surface.BIG_END_BORE, lambda at, _: np.cross([1.0, 0.0, 0.0], at))
    turn = np.tensordot(turns / (turns * np.cross([1.0, 0.0, 0.0], mesh.points)).sum(), referred, axes=2)
    for zero in (big, small[1:], turn):
        np.testing.assert_allclose(zero, 0.0, atol=1e-12)
