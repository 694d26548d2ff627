"""Problems that fall into blocks are solved block by block, and what couples these is not forgotten."""

import numpy as np
import pytest
from scipy.linalg import block_diag

from fea.contact.block import ContactBlock, CoupledBlocks, Guess, Places, Product
from fea.contact.friction_system import FrictionSystem, Load, Steps
from fea.contact.problem import CondensedInterface

PINS, PLACES, FRICTION = 12, 8, 0.3
SIZE = PINS + 3 * PLACES


class TwoEnds:
    """Two random problems of pins, places and friction that hardly know of each other."""

    def __init__(self, coupling, seed=4):
        rng = np.random.default_rng(seed)
        ends = [self._compliance(rng) for _ in range(2)]
        between = coupling * rng.normal(size=(2 * SIZE, 2 * SIZE))
        self.C = block_diag(*ends) + between + between.T
        self.R = block_diag(*(self._of_pins(rng) for _ in range(2)))
        self.P = block_diag(*rng.normal(size=(2, SIZE, 3)))
        self.pins = np.concatenate([np.arange(PINS), SIZE + np.arange(PINS)])
        self.condensed = CondensedInterface.of(self.C, self.P, self.pins)
        normal = np.arange(PLACES)
        shear = PLACES + np.arange(2 * PLACES).reshape(PLACES, 2)
        self.places = Places(
            normal=np.concatenate([normal, 3 * PLACES + normal]),
            tangential=np.concatenate([shear, 3 * PLACES + shear]),
            friction=np.full(2 * PLACES, FRICTION),
            bolt=np.zeros(2 * PLACES, dtype=bool),
            frictional=np.ones(2 * PLACES, dtype=bool),
        )
        gap = rng.normal(size=2 * SIZE)
        gap[np.concatenate([PINS + normal, SIZE + PINS + normal])] -= 5.0
        inner = np.abs(rng.normal(size=2 * SIZE))
        pressed = np.where(np.isin(np.arange(2 * SIZE), self.pins), inner, 0.0)
        self.load = Load(gap, self.R.T @ pressed, self.P.T @ inner)

    @staticmethod
    def _compliance(rng):
        root = rng.normal(size=(SIZE, 2 * SIZE))
        return root @ root.T / SIZE + np.eye(SIZE)

    @staticmethod
    def _of_pins(rng):
        return np.vstack([rng.normal(size=(PINS, 2)), np.zeros((3 * PLACES, 2))])

    def solved(self):
        system = FrictionSystem(self.condensed, self.R, self.places)
        gap = np.zeros(2 * 3 * PLACES)
        ends = [Steps(system, numbers=range(end, end + 1)) for end in system.every]
        found, *alone = (
            steps.at_once(self.load, gap, Guess.closed(2 * PINS, 2 * PLACES))
            for steps in [Steps(system), *ends]
        )
        return found, system.together(alone), system.part_motion(found)

    def blocks(self):
        return CoupledBlocks.of(ContactBlock.whole(self.condensed, self.R[self.pins], self.places)).blocks


def as_one(monkeypatch):
    monkeypatch.setattr(CoupledBlocks, "of", classmethod(lambda cls, whole: cls((whole,), ((),))))


@pytest.mark.parametrize("coupling", [0.0, 1e-9, 1e-8, 1e-5])
def test_in_blocks_it_is_the_same(coupling, monkeypatch):
    problem = TwoEnds(coupling)
    assert [len(own.pins) for own in problem.blocks()] == [PINS, PINS]
    found, together, moved = problem.solved()
    as_one(monkeypatch)
    one, _, moved_as_one = problem.solved()
    assert found.guess.slipping.any()
    for name in ("touching", "opened", "slipping"):
        np.testing.assert_array_equal(getattr(together.guess, name), getattr(found.guess, name))
    size = max(100 * coupling, 1e-11)  # alone, an end does not know how the other one opens and slips
    np.testing.assert_allclose(together.values, one.values, atol=size * np.abs(one.values).max())
    np.testing.assert_allclose(together.gap, one.gap, atol=size * np.abs(one.gap).max())
    np.testing.assert_allclose(found.values, one.values, atol=1e-11 * np.abs(one.values).max())
    np.testing.assert_allclose(found.gap, one.gap, atol=1e-10 * np.abs(one.gap).max())
    np.testing.assert_allclose(moved, moved_as_one, atol=1e-10 * np.abs(moved_as_one).max())


def test_what_knows_of_each_other_is_not_divided():
    assert len(TwoEnds(1e-3).blocks()) == 1


def test_a_motion_of_both_ends_keeps_them_together():
    problem = TwoEnds(0.0)
    problem.R = np.hstack([problem.R, problem.R[:, :1] + problem.R[:, 2:3]])
    assert len(problem.blocks()) == 1


@pytest.mark.parametrize("kind", ["narrow", "full", "nothing"])
def test_a_product_is_the_matrix(kind):
    rng = np.random.default_rng(1)
    rows, columns = rng.uniform(1, 9, 7), rng.uniform(1, 9, 5)
    basis = np.linalg.qr(rng.normal(size=(5, 2)))[0]
    scaled = {"narrow": rng.normal(size=(7, 2)) @ basis.T, "full": rng.normal(size=(7, 5))}
    matrix = scaled.get(kind, np.zeros((7, 5))) / rows[:, None] / columns
    found, start, values = Product.of(matrix, rows, columns, basis), rng.normal(size=7), rng.normal(size=5)
    assert (found.left is None) == (kind == "nothing")
    assert (found.right is not None) == (kind == "narrow")
    np.testing.assert_allclose(found.added(start, values, -1.0), start - matrix @ values, rtol=1e-12)
    back = found.transposed.added(values, start)
    np.testing.assert_allclose(back, values + matrix.T @ start, rtol=1e-12)
