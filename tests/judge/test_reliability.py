"""B-lives against exact quantiles.

A place whose amplitude is proportional to the gas load, on a line of slope k without a knee in sight, has a
log-normal life: ln N is k times the difference of two normal values, of strength and of load. Two independent
places, a chain of equal links and the rods of an engine follow from its distribution.
"""

import math
from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from fea.base.material import Basquin
from fea.judge.fatigue import LifeLine
from fea.judge.reliability import AWAY, FirstFailure, Place, Scatter, deviation, responded

NORMAL = NormalDist()
K, KNEE, LIMIT = 8.0, 1e9, 100.0
GAS = np.linspace(0.3, 1.7, 57)
QMC = 0.01  # of quasi-random points, as the issue of this module asks
SHARES = (0.01, 0.1, 0.5)


def line(k=K, knee=KNEE, limit=LIMIT, *, gentle=math.inf):
    return LifeLine(Basquin(limit * (2 * knee) ** (1 / k), -1 / k), knee, np.array([limit]), gentle)


def place(amplitude=300.0, *, by_gas=False, count=1, **more):
    of_gas = amplitude * (GAS if by_gas else np.ones_like(GAS))
    return Place("fillet", count, line(), GAS, of_gas[:, None], **more)


def median(amplitude=300.0, k=K):
    return KNEE * (LIMIT / amplitude) ** k


def spread(*variations, k=K):
    return k * math.hypot(*map(deviation, variations))


def test_one_place_has_the_quantiles_of_its_strength():
    """CV 8 %, k = 8: B10/B50 = 0.44 and B1/B50 = 0.225, from exp(−1.2816·8·0.0799) and exp(−2.3263·…)."""
    found = FirstFailure([place()], Scatter(strength=0.08))
    b1, b10, b50 = (found.of_rod(share).cycles for share in SHARES)
    assert b50 == pytest.approx(median(), rel=QMC)
    assert b10 / b50 == pytest.approx(0.44, abs=0.005)
    assert b1 / b50 == pytest.approx(0.225, abs=0.0025)
    for share, life in zip(SHARES, (b1, b10, b50), strict=True):
        exact = median() * math.exp(NORMAL.inv_cdf(share) * spread(0.08))
        assert life == pytest.approx(exact, rel=2e-3)  # of the table of strengths


@pytest.mark.parametrize("cause", ["cylinder_pressure", "boost"])
@pytest.mark.parametrize("strength", [0.08, 0.03])
def test_scatter_of_the_load_adds_to_that_of_the_strength(cause, strength):
    found = FirstFailure([place(by_gas=True)], Scatter(strength=strength, **{cause: 0.06}))
    for share in SHARES:
        life = found.of_rod(share)
        exact = median() * math.exp(NORMAL.inv_cdf(share) * spread(strength, 0.06))
        assert life.cycles == pytest.approx(exact, rel=QMC)
        # Within three standard errors of the sampling, and a part in 500 for tables of straight lines.
        assert abs(life.cycles / exact - 1) < 3 * life.error + 2e-3


def test_static_strength_acts_as_the_response_says():
    response = np.tile(-0.5 * deviation(0.05) * np.linspace(-4, 4, 9), (len(GAS), 1))
    found = FirstFailure([place(static=response)], Scatter(strength=0.08, static_strength=0.05))
    exact = median() * math.exp(NORMAL.inv_cdf(0.1) * K * math.hypot(deviation(0.08), deviation(0.05) / 2))
    assert found.of_rod(0.1).cycles == pytest.approx(exact, rel=QMC)


def test_small_shares_are_exact_too():
    found = FirstFailure([place(by_gas=True)], Scatter(strength=0.08, cylinder_pressure=0.03))
    for sigmas in (4.0, 5.0, 6.0):  # shares of 3e-5, 3e-7 and 1e-9
        cycles = median() * math.exp(-sigmas * spread(0.08, 0.03))
        least, most = found.failed(cycles)
        # Tables of straight lines move the strength by a part in 500, 0.02 standard deviations: at 6 of them
        # the share grows by 6.2 times that.
        assert least == pytest.approx(NORMAL.cdf(-sigmas), rel=0.15)
        assert most == pytest.approx(least, rel=1e-9)


def test_two_independent_places():
    """P = 1 − (1 − P₁)(1 − P₂); dependent ones fail as the worse does."""
    found = FirstFailure([place(300.0), place(310.0)], Scatter(strength=0.08))
    sigma = spread(0.08)

    def failed(cycles):
        each = (NORMAL.cdf(math.log(cycles / median(a)) / sigma) for a in (300.0, 310.0))
        return 1 - math.prod(1 - share for share in each)

    for share in SHARES:
        life = found.of_rod(share)
        exact = brentq(lambda log, share=share: failed(math.exp(log)) - share, 1.0, 40.0)
        assert life.cycles == pytest.approx(math.exp(exact), rel=QMC)
        alone = median(310.0) * math.exp(NORMAL.inv_cdf(share) * sigma)
        assert found.of_place(1, share).cycles == pytest.approx(alone, rel=QMC)
    least, most = found.failed(median(310.0))
    assert (least, most) == pytest.approx((0.5, failed(median(310.0))), rel=QMC)


@pytest.mark.parametrize("links", [2, 8, 100])
def test_a_chain_is_as_strong_as_its_weakest_link(links):
    """Weibull (1939): of n equal links 1 − (1 − P)ⁿ have failed, every one of `count` places counted."""
    chain = FirstFailure([place(count=links)], Scatter(strength=0.08))
    for share in SHARES:
        of_link = 1 - (1 - share) ** (1 / links)
        exact = median() * math.exp(NORMAL.inv_cdf(of_link) * spread(0.08))
        assert chain.of_rod(share).cycles == pytest.approx(exact, rel=QMC)
        alone = median() * math.exp(NORMAL.inv_cdf(share) * spread(0.08))
        assert chain.of_place(0, share).cycles == pytest.approx(alone, rel=QMC)


def test_an_engine_without_common_causes_fails_with_the_first_of_its_rods():
    found = FirstFailure([place()], Scatter(strength=0.08))
    of_rod = 1 - 0.9 ** (1 / 6)
    exact = median() * math.exp(NORMAL.inv_cdf(of_rod) * spread(0.08))
    assert found.of_engine(0.1, 6).cycles == pytest.approx(exact, rel=QMC)


def test_an_engine_whose_rods_are_all_alike_is_as_good_as_one_rod():
    """Where all scatter is of the batch, the step of each engine is averaged over 512 points: 2 %."""
    found = FirstFailure([place()], Scatter(strength=0.08, batch=0.08))
    assert found.of_engine(0.1, 6).cycles == pytest.approx(found.of_rod(0.1).cycles, rel=0.02)


def test_an_engine_averages_over_its_common_causes():
    """∫ 1 − (1 − P(t|c))⁶ φ(c) dc by quadrature."""
    batch, boost = 0.05, 0.04
    found = FirstFailure([place(by_gas=True)], Scatter(strength=0.08, batch=batch, boost=boost))
    cycles = found.of_engine(0.1, 6).cycles
    own = math.sqrt(deviation(0.08) ** 2 - deviation(batch) ** 2)
    common = math.hypot(deviation(batch), deviation(boost))

    def failed(c):
        away = math.log(cycles / median()) / K - common * c
        return (1 - (1 - NORMAL.cdf(away / own)) ** 6) * NORMAL.pdf(c)

    assert quad(failed, -8, 8)[0] == pytest.approx(0.1, rel=0.02)


def test_pressure_from_cycle_to_cycle_is_mean_damage_in_every_rod():
    """E[(1 + c z)^8] = 1 + 28 c² + 210 c⁴ + 420 c⁶ + 105 c⁸: it shortens lives and spreads none."""
    c = 0.05
    mean = 1 + 28 * c**2 + 210 * c**4 + 420 * c**6 + 105 * c**8
    found = FirstFailure([place(by_gas=True)], Scatter(strength=0.08, cycle_pressure=c))
    b10, b50 = (found.of_rod(share).cycles for share in (0.1, 0.5))
    assert b50 == pytest.approx(median() / mean, rel=QMC)
    assert b10 / b50 == pytest.approx(math.exp(NORMAL.inv_cdf(0.1) * spread(0.08)), rel=QMC)


def test_unlimited_is_asked_of_the_tail():
    """Three standard deviations of a cycle's pressure, 15 %, must stay below the limit."""
    for amplitude, endless in ((0.85 * LIMIT, True), (0.89 * LIMIT, False)):
        found = FirstFailure([place(amplitude, by_gas=True)], Scatter(strength=1e-6, cycle_pressure=0.05))
        assert math.isinf(found.of_rod(0.5).cycles) is endless
    steady = FirstFailure([place(0.99 * LIMIT, by_gas=True)], Scatter(strength=1e-6))
    assert math.isinf(steady.of_rod(0.5).cycles)
    soft = FirstFailure([place(0.9 * LIMIT)], Scatter(strength=0.08))
    assert math.isinf(soft.of_rod(0.5).cycles)
    assert soft.of_rod(0.01).cycles < 10 * KNEE  # of weak rods the limit is exceeded


def test_hard_steels_and_light_metals_have_no_unlimited_life():
    decades = math.log(0.9) / math.log(0.95)  # Sonsino (2007): 5 % a decade
    gentle = line(gentle=-1 / math.log10(0.95))
    hard = FirstFailure([replace(place(0.9 * LIMIT), line=gentle)], Scatter(strength=0.08))
    assert hard.of_rod(0.5).cycles == pytest.approx(KNEE * 10**decades, rel=QMC)
    light = replace(place(0.9 * LIMIT), line=line(gentle=None))
    found = FirstFailure([light], Scatter(strength=0.08))
    assert found.of_rod(0.5).cycles == pytest.approx(KNEE * 0.9 ** (1 - 2 * K), rel=QMC)


def test_causes_that_are_switched_off_leave_the_life_of_the_median():
    found = FirstFailure([place(by_gas=True)], Scatter())
    for share in SHARES:
        assert found.of_rod(share).cycles == pytest.approx(median(), rel=QMC)


def test_the_same_seed_gives_the_same_lives():
    scatter = Scatter(strength=0.08, cylinder_pressure=0.05)
    one, two, other = (FirstFailure([place(by_gas=True)], scatter, seed).of_rod(0.1) for seed in (0, 0, 5))
    assert one == two
    assert one.cycles != other.cycles


@pytest.mark.parametrize("share", SHARES)
def test_a_further_cause_acts_as_its_response_says(share):
    """A logarithm of the amplitude that grows by b a deviation adds b to the scatter of the strength."""
    b = 0.06
    found = FirstFailure([place(responses=b * np.array([AWAY]))], Scatter(strength=0.08))
    sigma = K * math.hypot(deviation(0.08), b)
    assert found.of_rod(share).cycles == pytest.approx(
        median() * math.exp(NORMAL.inv_cdf(share) * sigma), rel=QMC
    )
    of_rod = 1 - (1 - share) ** (1 / 6)  # of an engine without common causes
    exact = median() * math.exp(NORMAL.inv_cdf(of_rod) * sigma)
    life = found.of_engine(share, 6)
    assert abs(life.cycles / exact - 1) < 3 * life.error + 2e-3  # as of the strength above
    assert life.error < 0.02


def test_a_response_is_straight_between_its_values_and_beyond():
    """That of bolts under less preload has a bend: 1.5 at −2 deviations, 0 from the mean on."""
    response = np.array([1.5, 0.5, 0.0, 0.0])
    assert responded(np.array([-3.0, -2.0, -1.5, -0.5, 0.0, 1.5, 3.0]), response) == pytest.approx(
        [2.5, 1.5, 1.0, 0.25, 0.0, 0.0, 0.0]
    )
    found = FirstFailure([place(responses=0.1 * response[None])], Scatter(strength=0.08))
    cycles, spread_ = found.of_rod(0.1).cycles, deviation(0.08)

    def failed(z):
        demand = 0.1 * float(responded(np.array(z), response))
        return NORMAL.cdf((math.log(cycles / median()) / K + demand) / spread_) * NORMAL.pdf(z)

    assert quad(failed, -8, 8, points=[-2, -1, 0], limit=200)[0] == pytest.approx(0.1, rel=QMC)


def test_cycles_of_a_duty_count_as_often_as_they_occur():
    """Miner's sum on a block of a tenth at 300 MPa and nine tenths at 200 MPa; on a line without a knee."""
    both = np.tile([300.0, 200.0], (len(GAS), 1))
    often = np.tile([0.1, 0.9], (len(GAS), 1))
    block = Place("fillet", 1, line(), GAS, both, rate=often)
    exact = 1 / (0.1 / median(300.0) + 0.9 / median(200.0))
    assert FirstFailure([block], Scatter(strength=0.08)).of_rod(0.5).cycles == pytest.approx(exact, rel=QMC)
    # Below the knee of a hard steel the rare large cycle counts, a tenth of all.
    decades = math.log(0.9) / math.log(0.95)
    hard = replace(block, line=line(gentle=-1 / math.log10(0.95)), amplitude=both * 0.3 * LIMIT / 100)
    found = FirstFailure([hard], Scatter(strength=0.08))
    assert found.of_rod(0.5).cycles == pytest.approx(10 * KNEE * 10**decades, rel=QMC)
