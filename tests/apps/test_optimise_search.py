"""The search on rods that are formulas, with meshes that scatter: the optimum is known."""

import numpy as np
import pytest
from scipy.optimize import LinearConstraint, NonlinearConstraint, minimize

from fea.apps.optimise.designs import Design
from fea.apps.optimise.problem import DesignConstraint
from fea.apps.optimise.search import LocalModel, search

pytestmark = pytest.mark.slow


N, LIMITS = 6, 5
# What factors of one rod differ by from mesh to mesh, as of rods on meshes of fixed size.
SCATTER = 5e-3
# Dimensions 0 and 1 must leave room for each other.
ROOM = 0.5


class Formulas:
    """Rods whose stresses are products of powers of their dimensions; each mesh has an error of its own."""

    def __init__(self, seed, scatter=SCATTER):
        self.draw, self.scatter = np.random.default_rng([seed, 21]), scatter
        self.weights = self.draw.uniform(0.05, 0.2, N)
        self.powers = self.draw.uniform(0.0, 1.0, (LIMITS, N)) * (self.draw.random((LIMITS, N)) < 0.6)
        self.sizes = self.draw.uniform(0.5, 0.8, LIMITS)
        self.tried, self.count, self.mesh, self.off = [], 0, 0, np.zeros(LIMITS)

    def mass(self, x):
        return 0.3 + self.weights @ x

    def usage(self, x):
        return self.sizes / np.prod(((0.4 + x) / 0.9) ** self.powers, axis=1)

    def nearest(self, x, sound):
        room, before = x[0] + x[1] - ROOM, sound[0] + sound[1] - ROOM
        return x if room >= 0 else sound + before / (before - room) * (x - sound)

    def begin(self, x):
        self.mesh += 1
        self.off = self.scatter * self.draw.normal(size=LIMITS)
        return self.computed(x, remeshed=True)

    def at(self, x):
        return self.computed(self.nearest(x, np.full(N, 0.8)), remeshed=False)

    def computed(self, x, *, remeshed):
        usage = self.usage(x) * (1 + self.off)
        limits = tuple(
            DesignConstraint(f"limit {number}", 1 / own, 0.0, 1.0) for number, own in enumerate(usage)
        )
        self.count += 1
        self.tried.append(Design(x, self.mass(x), limits, remeshed, self.mesh))
        return self.tried[-1]

    def least(self):
        """The least mass without any scatter."""
        return min(
            minimize(
                self.mass,
                self.draw.uniform(0.3, 1.0, N),
                method="SLSQP",
                bounds=[(0.0, 1.0)] * N,
                constraints=[
                    NonlinearConstraint(lambda x: 1 - self.usage(x), 0.0, np.inf),
                    LinearConstraint(np.eye(N)[0] + np.eye(N)[1], ROOM, np.inf),
                ],
            ).fun
            for _ in range(5)
        )


@pytest.mark.parametrize("seed", [0, 5])  # 1 and 6 are searched from other starts, and with fewer evaluations
def test_the_lightest_rod_is_found_though_meshes_scatter(seed):
    """1 %: twice what the scatter of meshes is worth in mass."""
    rods = Formulas(seed)
    found, least = search(rods, np.full(N, 0.8), 150), rods.least()
    assert found.count <= 150
    assert found.holding
    assert found.best.remeshed
    assert found.best.mass_kg == pytest.approx(least, rel=0.01)
    assert (rods.usage(found.best.x) <= 1 + 3 * SCATTER).all()


@pytest.mark.parametrize(("seed", "start"), [(6, 0.8), (1, 0.26)])
def test_thirty_evaluations_bring_most_of_it(seed, start):
    """From a rod that is too heavy, and from one that does not hold."""
    rods = Formulas(seed)
    found, least = search(rods, np.full(N, start), 30), rods.least()
    assert found.count <= 30
    assert found.holding
    assert found.best.mass_kg == pytest.approx(least, rel=0.05)


def test_a_rod_that_lacks_strength_becomes_one_that_holds():
    rods = Formulas(1)
    found = search(rods, np.full(N, 0.26), 150)
    assert found.first.margin < 0
    assert found.holding
    assert found.best.mass_kg == pytest.approx(rods.least(), rel=0.01)


def test_where_no_rod_holds_the_search_ends_and_says_so():
    rods = Formulas(1)
    rods.sizes *= 10
    found = search(rods, np.full(N, 0.8), 150)
    assert not found.holding
    assert found.count <= 150
    assert "none that meets the factors was found" in found.ended or "evaluations are left" in found.ended


def test_the_model_is_that_of_the_mean_mesh():
    rods, centre, step = Formulas(0), np.full(N, 0.6), 1e-6
    for _ in range(12):
        rods.begin(centre + rods.draw.normal(size=N) * 0.02)
        for _ in range(4):
            rods.at(rods.tried[-1].x + rods.draw.normal(size=N) * 0.02)
    about = rods.tried[-1]
    model = LocalModel.of(rods.tried, about)
    mass, margins = model.at(centre)
    assert mass == pytest.approx(rods.mass(centre) / about.mass_kg, rel=1e-4)
    assert margins == pytest.approx(1 - rods.usage(centre), abs=3 * SCATTER / np.sqrt(12))
    slopes = np.array([rods.usage(centre) - rods.usage(centre + step * e) for e in np.eye(N)]).T / step
    found = model.slopes[1:]
    assert np.abs(found - slopes).max() < 0.1 * np.abs(slopes).max()
