"""Many right-hand sides are checked by a few sums of theirs."""

import numpy as np
import pytest

from fea.base.choices import Support
from fea.base.material import Material
from fea.solid.parity import Parity, ParityPair
from fea.solvers.residuals import CHECKED_SINGLY, REFINE_ABOVE, residuals
from fea.solvers.static import Model
from geometry.bodies import block
from geometry.surfaces import Surface
from mesh.generate import mesh_body

COLUMNS = 3 * CHECKED_SINGLY


@pytest.fixture(scope="module")
def bar():
    mesh = mesh_body(block(10.0, 2.0, 2.0, Surface.BIG_END_BORE), 2.0)
    return Model(mesh, Material(210e3, 0.3, 7.85e-9, 400.0), Support.CLAMPED)


@pytest.fixture(scope="module")
def loads(bar):
    """Forces (3 n_nodes, n) of very different size."""
    rng = np.random.default_rng(1)
    forces = rng.normal(size=(COLUMNS, *bar.mesh.points.shape)) * 10.0 ** rng.uniform(-6, 6, (COLUMNS, 1, 1))
    forces[0] = 0.0
    return forces


def _checked(bar, u, f):
    fixed, _ = bar.restrained(Parity.SYMMETRIC)
    return residuals(bar.stiffness, u, f, fixed=fixed, restraints=np.zeros_like(fixed)).backward_error


def test_right_solutions_pass(bar, loads):
    found = bar.solve([ParityPair(force, None) for force in loads])
    assert found.residuals[Parity.SYMMETRIC].backward_error < 1e-14


@pytest.mark.parametrize("wrong", range(1, COLUMNS))
def test_a_column_that_is_wrong_shows_whatever_its_size(bar, loads, wrong):
    u = bar.solve([ParityPair(force, None) for force in loads]).displacement[Parity.SYMMETRIC].copy()
    u[..., wrong] *= 1 + 1e-9
    u, f = u.reshape(-1, COLUMNS), loads.reshape(COLUMNS, -1).T
    alone = _checked(bar, u[:, [wrong]], f[:, [wrong]])
    assert alone > 10 * REFINE_ABOVE
    assert _checked(bar, u, f) == pytest.approx(alone, rel=0.01)


def test_what_is_not_finite_is_no_solution(bar, loads):
    u = (
        bar.solve([ParityPair(force, None) for force in loads])
        .displacement[Parity.SYMMETRIC]
        .reshape(-1, COLUMNS)
    )
    u[7, 5] = np.nan
    assert _checked(bar, u, loads.reshape(COLUMNS, -1).T) == np.inf
