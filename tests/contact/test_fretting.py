"""Fretting of half-planes: partial slip, energy, shakedown of slip, a punch that sticks until it slides."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, quad
from scipy.optimize import brentq

from fea.contact.block import Guess, Places
from fea.contact.fretting import Rubbing, facets_across
from fea.contact.friction_system import ContactState, FrictionSystem, Load, Steps
from fea.contact.problem import CondensedInterface

# Composite modulus E*, MPa, of two half-planes of steel in plane strain: 1/E* = 2 (1 − ν²)/E.
E_STAR = 210e3 / (2 * (1 - 0.3**2))
RADIUS, FRICTION = 50.0, 0.3  # of the cylinder, mm


class HalfPlanes:
    """A cylinder or a flat punch on an equal half-plane, per mm of thickness, with the solver of the parts.

    Pressures and shear stresses are linear between vertices, `step` apart; their compliance is that of the
    half-planes (Johnson 1985, Contact Mechanics, section 2.4), integrated over both: the fourth difference of
    the fourth integral of ln x. Shear and normal stresses do not affect each other, as both are alike.
    """

    def __init__(self, x, step, gap):
        self.x, self.step, n = x, step, len(x)
        far = 1e3 * (x[-1] - x[0])  # a unit of length: what it adds moves the bodies as a whole
        k = np.abs(np.arange(n)[:, None] - np.arange(n)).astype(float)

        def integral(at):
            at = np.abs(at) * step
            safe = np.maximum(at, 1e-300)
            return at**4 / 24 * (np.log(safe / far) - 25 / 12)

        differences = sum(c * integral(k + m) for m, c in zip(range(-2, 3), (1, -4, 6, -4, 1), strict=True))
        C = -2 / (np.pi * E_STAR) * differences / step**2
        nothing = np.zeros_like(C)
        compliance = np.block([[C, nothing], [nothing, C]])
        moved = step * np.kron(np.eye(2), np.ones((n, 1)))  # along the normal, and along the surface
        shear = np.stack([np.full(n, -1), n + np.arange(n)], axis=1)
        places = Places(
            np.arange(n), shear, np.full(n, FRICTION), np.zeros(n, dtype=bool), np.ones(n, dtype=bool)
        )
        condensed = CondensedInterface.of(compliance, moved, np.zeros(0, dtype=np.int64))
        system = FrictionSystem(condensed, np.zeros((2 * n, 0)), places)
        self.steps, self.gap = Steps(system), np.concatenate([step * gap, np.zeros(n)])
        idle, none = Load(self.gap, np.zeros(0), np.zeros(2)), np.zeros(0)
        start = ContactState(idle, np.zeros(2 * n), self.gap, Guess.closed(0, n), none, 0.0, 0.0, 0)
        self.assembled = SimpleNamespace(
            vertices=SimpleNamespace(shear=shear, normal=np.arange(n), area=np.full(n, step)),
            tightened=start, system=system,
            slipped=lambda gap: np.stack([np.zeros(n), gap[n:] / step], axis=1),
        )  # fmt: skip
        self.state = start

    def go(self, pressed, pushed):
        """Press with a force, N/mm, and push along the surface with forces one after the other."""
        states = []
        for force in pushed:
            load = Load(self.gap, np.zeros(0), np.array([pressed, force]))
            self.state = self.steps.step(load, self.state)
            states.append(self.state)
        return states

    def rubbing(self, states):
        return Rubbing.of(self.assembled, states)

    def stresses(self, state):
        return np.split(state.values, 2)


PRESSED, SHARE = 400.0, 0.6  # N/mm; Q/μP
HALF_WIDTH = np.sqrt(4 * PRESSED * RADIUS / (np.pi * E_STAR))  # Hertz 1882
Q = SHARE * FRICTION * PRESSED
FACETS = 60  # over the half width: the edge of the slip zone is where a vertex is
TURN = np.concatenate([np.linspace(1, -1, 41)[1:], np.linspace(-1, 1, 41)[1:]])


@pytest.fixture(scope="module")
def cylinder():
    step = HALF_WIDTH / FACETS
    x = step * np.arange(-FACETS - 8, FACETS + 9)
    both = HalfPlanes(x, step, x**2 / (2 * RADIUS))
    both.go(PRESSED, [0.0])
    first = both.go(PRESSED, Q * np.linspace(0, 1, 11)[1:])[-1]
    turns = [[first, *both.go(PRESSED, Q * TURN)]]
    turns += [[turns[-1][-1], *both.go(PRESSED, Q * TURN)]]
    return SimpleNamespace(both=both, first=first, turns=turns)


def test_partial_slip_is_that_of_cattaneo_and_mindlin(cylinder):
    """Slip zone c < |x| < a with c = a √(1 − Q/μP), and the shear (Cattaneo 1938; Mindlin 1949)."""
    x, (pressure, shear) = cylinder.both.x, cylinder.both.stresses(cylinder.first)
    a, c = HALF_WIDTH, HALF_WIDTH * np.sqrt(1 - SHARE)
    highest, step = 2 * PRESSED / (np.pi * a), cylinder.both.step
    inside = (np.abs(x) < a - 2 * step) & (np.abs(np.abs(x) - c) > step)
    hertz, inner = (np.sqrt(np.maximum(1 - (x / width) ** 2, 0)) for width in (a, c))
    exact = FRICTION * highest * (hertz - c / a * inner)
    # 2 %, but at the edges of contact and of slip: there both are roots of the distance, and linear here.
    np.testing.assert_allclose(pressure[inside], highest * hertz[inside], atol=0.02 * highest)
    np.testing.assert_allclose(np.abs(shear)[inside], exact[inside], atol=0.02 * exact.max())
    guess = cylinder.first.guess
    sticks = ~guess.slipping & ~guess.opened
    assert np.abs(x[sticks]).max() == pytest.approx(c, abs=step)  # one vertex: 1.7 % of a


def test_the_energy_of_a_cycle_is_that_of_the_closed_form(cylinder):
    """By the principle of Jäger and Ciavarella (1998) and Masing's rule, per thickness, with q = Q/μP.

    W = (μP)²/(π E*) [4 (1 − q) ln(1 − q) + 4 q − 2 q²]: the shift under Q is μ times the difference of the
    approaches under P and P − Q/μ. Found within 0.3 %; 1 % leaves room for other meshes.
    """
    q, rub = SHARE, cylinder.both.rubbing(cylinder.turns[1])
    exact = (FRICTION * PRESSED) ** 2 / (np.pi * E_STAR) * (4 * (1 - q) * np.log(1 - q) + 4 * q - 2 * q**2)
    assert rub.energy.sum() * cylinder.both.step == pytest.approx(exact, rel=0.01)
    force = np.append(Q, Q * TURN)
    moved = [cylinder.both.steps._system.part_motion(state)[1] for state in cylinder.turns[1]]
    assert abs(np.trapezoid(force, moved)) == pytest.approx(exact, rel=0.01)
    # Ruiz's work is largest inside the zone of slip: neither where it ends nor at the edge of contact.
    worst = abs(cylinder.both.x[rub.work.max(axis=1).argmax()])
    assert HALF_WIDTH * np.sqrt(1 - SHARE) < worst < HALF_WIDTH


def test_slip_settles_after_the_first_cycle(cylinder):
    """Shakedown of slip in uncoupled contact (Klarbring, Ciavarella & Barber 2007)."""
    for turn in cylinder.turns:
        slip = cylinder.both.rubbing(turn)
        drift = np.abs(slip.slip[..., -1] - slip.slip[..., 0]).max()
        assert drift < 1e-6 * slip.range.max()
    stuck = [cylinder.both.rubbing(turn).range == 0 for turn in cylinder.turns]
    np.testing.assert_array_equal(*stuck)


class RoundedPunch:
    """A flat punch, half width a, with rounded edges that touch up to b (Ciavarella, Hills & Monno 1998).

    As indentation grows, contact of half width t takes up P'(t) dt as a flat, sharp punch (Jäger 1998):
    p(x) = ∫ P'(t)/(π √(t² − x²)) dt with P(t) = E* ∫ x h'(x)/√(t² − x²) dx = E* t² (π − 2φ − sin 2φ)/(4 R),
    sin φ = a/t, from the profile h = (|x| − a)²/(2 R) beyond a; its integral is the pressure below.
    """

    def __init__(self, flat, width, force):
        self.flat, self.width = flat, width
        self.radius = E_STAR * width**2 * self._shape(width) / (4 * force)

    def _shape(self, width):
        angle = np.arcsin(self.flat / width)
        return np.pi - 2 * angle - np.sin(2 * angle)

    def gap(self, x):
        return np.maximum(np.abs(x) - self.flat, 0.0) ** 2 / (2 * self.radius)

    def force(self, width):
        return E_STAR * width**2 * self._shape(width) / (4 * self.radius)

    def width_at(self, force):
        return brentq(lambda width: self.force(width) - force, self.flat, 2 * self.width)

    def pressure(self, x, width):
        """Closed form (n,) at places (n,) of a contact of some half width; 0 outside."""
        inside, at = np.abs(x) < width, np.arcsin(self.flat / width)
        f = np.arcsin(np.where(inside, x, 0.0) / width)
        apart = np.abs(np.sin(f + at) / np.sin(f - at)), np.abs(np.tan((f + at) / 2) * np.tan((f - at) / 2))
        bracket = (np.pi - 2 * at) * np.cos(f) + np.sin(f) * np.log(apart[0]) + np.sin(at) * np.log(apart[1])
        return np.where(inside, E_STAR * width / (2 * np.pi * self.radius) * bracket, 0.0)


FLAT = 0.503 * HALF_WIDTH  # its edge lies between vertices, where the closed form can be evaluated


@pytest.fixture(scope="module")
def rounded():
    step = HALF_WIDTH / FACETS
    x = step * np.arange(-FACETS - 8, FACETS + 9)
    punch = RoundedPunch(FLAT, HALF_WIDTH, PRESSED)
    both = HalfPlanes(x, step, punch.gap(x))
    both.go(PRESSED, [0.0])
    first = both.go(PRESSED, Q * np.linspace(0, 1, 11)[1:])[-1]
    both.go(PRESSED, Q * TURN)
    return SimpleNamespace(
        punch=punch, both=both, first=first, turn=[both.state, *both.go(PRESSED, Q * TURN)]
    )


@pytest.mark.parametrize("x", [0.0, 0.3, 0.6, 0.9])
def test_the_pressure_of_the_rounded_punch_is_the_sum_of_flat_ones(x):
    """The closed form is the integral over the growing contact, found by quadrature, to rounding."""
    punch = RoundedPunch(FLAT, HALF_WIDTH, PRESSED)
    x *= HALF_WIDTH

    def grown(s):  # s² = t² − x²
        return np.arccos(punch.flat / np.hypot(s, x))

    start, end = np.sqrt(max(punch.flat**2 - x**2, 0.0)), np.sqrt(HALF_WIDTH**2 - x**2)
    exact = E_STAR / (np.pi * punch.radius) * quad(grown, start, end)[0]
    assert punch.pressure(np.array([x]), HALF_WIDTH) == pytest.approx([exact], rel=1e-9)


def test_partial_slip_of_the_rounded_punch(rounded):
    """Shear μ (p of b − p of c), where P(c) = P − Q/μ: Jäger 1998, Ciavarella 1998. The flat never slips."""
    x, (pressure, shear) = rounded.both.x, rounded.both.stresses(rounded.first)
    punch, step = rounded.punch, rounded.both.step
    c = punch.width_at(PRESSED - Q / FRICTION)
    assert punch.flat < c < HALF_WIDTH
    full, stuck = punch.pressure(x, HALF_WIDTH), punch.pressure(x, c)
    exact = FRICTION * (full - stuck)
    inside = (np.abs(x) < HALF_WIDTH - 2 * step) & (np.abs(np.abs(x) - c) > 2 * step)
    # 2 %, but at the edges of contact and of slip, as of the cylinder; the curvature of the profile jumps.
    np.testing.assert_allclose(pressure[inside], full[inside], atol=0.02 * full.max())
    np.testing.assert_allclose(np.abs(shear)[inside], exact[inside], atol=0.02 * exact.max())
    guess = rounded.first.guess
    sticks = ~guess.slipping & ~guess.opened
    assert np.abs(x[sticks]).max() == pytest.approx(c, abs=step)


def test_the_energy_of_the_rounded_punch(rounded):
    """Masing's rule: W = 8 (Q u/2 − ∫ u dQ) with the shift u = μ ∫ C dP from P − Q/μ to P.

    C = −2 ln t/(π E*) and a constant, which leaves the loop as it is, is the compliance of a flat punch of
    the half width t at the load P; dP = E* t arccos(a/t) dt/R. 1 %, as of the cylinder.
    """
    punch = rounded.punch
    t = np.linspace(HALF_WIDTH, punch.width_at(PRESSED - Q / FRICTION), 20_001)
    pushed = FRICTION * (PRESSED - punch.force(t))
    slope = E_STAR / punch.radius * t * np.arccos(punch.flat / t)
    moved = FRICTION * cumulative_trapezoid(2 * np.log(t) / (np.pi * E_STAR) * slope, t, initial=0)
    exact = 8 * (pushed[-1] * moved[-1] / 2 - np.trapezoid(moved, pushed))
    rub = rounded.both.rubbing(rounded.turn)
    assert rub.energy.sum() * rounded.both.step == pytest.approx(exact, rel=0.01)
    assert np.abs(rub.slip[..., -1] - rub.slip[..., 0]).max() < 1e-6 * rub.range.max()
    assert (rub.range[np.abs(rounded.both.x) < FLAT] == 0).all()


def test_a_sharp_punch_sticks_until_it_slides():
    """Flat and sharp: the shear has the shape of the pressure, so that nothing slips below μP."""
    step = 0.05
    x = step * np.arange(-20, 21)
    both = HalfPlanes(x, step, np.zeros(len(x)))
    both.go(PRESSED, [0.0])
    states = both.go(PRESSED, FRICTION * PRESSED * np.array([0.5, 0.999, -0.999, 0.999]))
    rub = both.rubbing(states)
    assert (rub.range == 0).all()
    assert (rub.energy == 0).all()


def test_rubbing_over_a_path_by_hand():
    """A square of slip, 2 by 1 mm, under 10 MPa: diagonal, length of the path, and none while it is open."""
    corners = np.array([[0, 0], [2, 0], [2, 1], [0, 1], [0, 0]], float)
    pressure = np.full((2, 5), 10.0)
    pressure[1, 2:4] = 0.0  # two sides and what lies between them are passed while the parts are apart
    slip = np.stack([corners.T, corners.T])
    rub = Rubbing(slip, 0.5 * pressure, pressure, 0.5)
    assert rub.range == pytest.approx([np.sqrt(5), 2], rel=2e-3)
    assert rub.energy == pytest.approx([0.5 * 10 * 6, 0.5 * 10 * 2])
    np.testing.assert_allclose(rub.work[0], 5 * rub.range[0])


def test_the_width_of_a_zone_is_counted_in_facets():
    """A strip of nine squares of two facets each, of whose ten columns the last six slip."""
    corner = np.arange(20).reshape(10, 2)
    one, other = corner[:-1], corner[1:]
    facets = np.concatenate(
        [np.stack([one[:, 0], other[:, 0], one[:, 1]], 1), np.stack([other[:, 0], other[:, 1], one[:, 1]], 1)]
    )
    slips = np.repeat(np.arange(10) >= 4, 2)
    assert set(facets_across(slips, facets)[slips]) == {6}
    assert (facets_across(slips, facets)[~slips] == 0).all()
    assert facets_across(np.ones(20, dtype=bool), facets).min() >= 8  # where all of it slips
