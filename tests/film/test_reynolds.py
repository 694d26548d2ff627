import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import fsolve

from fea.film.constitutive import Asperities, Oil, WarmOil
from fea.film.cycle import JournalLoads, _Integration, integrate
from fea.film.functions import BoreFunctions
from fea.film.grid import FilmGrid
from fea.film.journal import Bearing, ElasticBore
from fea.film.reynolds import Conditions, FilmState, Reynolds, Supply
from fea.solid.errors import FilmError
from fea.study.film_table import grade

R, C, SPEED = 25.0, 0.025, 7500.0
THIN = Oil(1e-8)


def bearing(n=48, m=6, *, width=25.0, oil=THIN, halved=True):
    return Bearing(Reynolds(FilmGrid(R, width, n, m, halved), oil), C)


def turning(film, position=(-0.5 * C, 0.0), speed=SPEED, at=0.0):
    grid = film.reynolds.grid
    supply = Supply(grid.groove(at, 2 * math.pi / grid.n_angle), 1e-4)
    return film.solve(film.start(position), Conditions(speed, supply))


def force(film, state):
    return film.reynolds.grid.resultants(state.film.pressure)[:2]


def test_the_load_converges_with_the_square_of_the_cells():
    # The edge of the cavitated part moves from cell to cell, so that the order is not quite regular.
    coarse, middle, fine = (
        np.hypot(*force(each, turning(each))) for each in (bearing(n, n // 8) for n in (48, 96, 192))
    )
    assert 1.7 < math.log2((coarse - middle) / (middle - fine)) < 2.3


def test_half_the_width_stands_for_all_of_it():
    half, whole = bearing(), bearing(m=12, halved=False)
    one, other = turning(half), turning(whole)
    assert force(half, one) == pytest.approx(force(whole, other), rel=1e-9)
    assert one.balance.leaked == pytest.approx(other.balance.leaked, rel=1e-9)


def test_a_journal_tilts_under_a_moment_and_back_under_its_reverse():
    film = bearing(m=12, halved=False)
    straight, grid = turning(film), film.reynolds.grid
    load = np.concatenate([force(film, straight), 0.1 * force(film, straight)])
    conditions, states = straight.conditions, []
    around = np.stack([np.cos(grid.angle), np.sin(grid.angle)])
    levers = np.stack([np.ones_like(grid.z), grid.z / 12.5], axis=1)  # over half the width
    for sign in (1, -1):
        under = load * [1, 1, sign, sign]
        states.append(film.solve(straight, conditions, load=under))
        found = around @ (states[-1].pressure * grid.area) @ levers
        assert found.T.ravel() == pytest.approx(under, rel=1e-7)
    one, other = states
    assert other.gap == pytest.approx(one.gap[:, ::-1], rel=1e-6)
    assert other.edge == pytest.approx(one.edge[:, ::-1], rel=1e-6)
    assert other.position == pytest.approx(one.position * [1, 1, -1, -1], rel=1e-6)
    assert one.edge == pytest.approx(1.5 * one.gap[:, [0, -1]] - 0.5 * one.gap[:, [1, -2]], rel=1e-9)
    # The end that the force is moved to comes nearer where it presses.
    assert one.position[2:] @ load[:2] > 0.1 * C * np.hypot(*load[:2])
    assert one.thinnest < 0.8 * straight.thinnest
    alone = film.solve(straight, conditions, load=load[:2])
    assert alone.position[2:] == pytest.approx([0.0, 0.0], abs=1e-9 * C)


def test_a_journal_that_turns_backwards_has_the_mirror_image_of_the_film():
    film = bearing()
    one, other = turning(film), turning(film, speed=-SPEED)
    mirrored = np.roll(other.film.pressure[::-1], 1, axis=0)
    assert mirrored == pytest.approx(one.film.pressure, rel=1e-9, abs=1e-12)


def test_a_bore_yields_by_its_compliance_to_what_presses():
    """An ovalisation; and where something else bends the bore, that is added."""
    grid = FilmGrid(R, 25.0, 48, 6)
    around = np.stack([np.cos(2 * grid.angle), np.sin(2 * grid.angle)], axis=-1)[:, None]
    waves = around * np.ones((6, 1)) / math.sqrt(math.pi * R * 25.0)  # 1/mm
    compliance, loaded = np.array([[4e-3, 1e-3], [1e-3, 2e-3]]), np.array([0.0, 0.01])
    film = replace(bearing(), bore=ElasticBore(waves, waves[:, :1], compliance))
    supply = Supply(grid.groove(0.0, 0.3), 1e-4)
    state = film.solve(film.start((-0.5 * C, 0.0)), Conditions(SPEED, supply), loaded=loaded)
    pressed = 2 * np.einsum("am,m,amn->n", state.pressure, grid.area, waves)
    assert state.bulge == pytest.approx(compliance @ pressed + loaded, rel=1e-3)
    assert np.abs(waves @ (state.bulge - loaded)).max() > 0.03 * C
    assert state.gap[:, 0] == pytest.approx(C * (1 + 0.5 * np.cos(grid.angle)) + waves[:, 0] @ state.bulge)


def test_functions_of_a_bore_have_their_means_in_a_cell():
    functions, grid = BoreFunctions(R, 25.0), FilmGrid(R, 25.0, 24, 4)
    off = (np.arange(12) + 0.5) / 12 - 0.5
    angle = np.add.outer(grid.angle, off * 2 * math.pi / 24)[:, :, None, None]
    angle, z = np.broadcast_arrays(angle, grid.z[:, None] + np.multiply.outer(grid.dz, off))
    means = np.concatenate([each.mean(axis=(2, 4)) for each in functions.at(angle, z)])
    assert functions.means(grid) == pytest.approx(np.moveaxis(means, 0, -1), abs=0.01 * means.max())


def test_oil_is_conserved():
    film = bearing()
    balance = turning(film).balance
    assert balance.supplied == pytest.approx(balance.leaked, rel=1e-9)
    assert balance.supplied > 0


def test_what_the_journal_gives_is_what_the_film_dissipates():
    # At rest, torque times speed and the oil's own pressure are all there is.
    film = bearing()
    state = turning(film)
    pull, sheared = film.reynolds.friction(state.film, state.gap, SPEED)
    driven = pull * SPEED + 1e-4 * state.balance.supplied
    assert sheared + state.balance.pressed == pytest.approx(driven, rel=2e-3)


def test_flow_out_of_a_concentric_bearing_follows_poiseuille():
    # From a groove amid a wide bearing at rest: Q = 2 · 2πR h³ p/12μ over the length that is left.
    film = bearing(8, 64, width=100.0)
    share = np.zeros(film.reynolds.grid.shape)
    share[:, :1] = 1.0
    state = film.solve(film.start(), Conditions(0.0, Supply(share, 1.0)))
    left = 50.0 - film.reynolds.grid.dz[0]
    exact = 2 * 2 * math.pi * R * C**3 / (12 * THIN.viscosity) / left
    assert state.balance.leaked == pytest.approx(exact, rel=1e-4)


def test_a_step_of_second_order_in_time():
    # A load that rotates about a constant one.
    def place(count):
        film = bearing(24, 3)
        angle = 2 * math.pi * np.arange(count) / count
        load = np.stack([3000 + 1000 * np.cos(angle), 1000 * np.sin(angle)], axis=1)
        acting = JournalLoads(
            period=0.02,
            load=load,
            speed=np.full(count, SPEED),
            inlet=0.5,
            grooves=film.reynolds.grid.groove(math.pi, 0.3),
        )
        cycle = integrate(film, acting)
        assert cycle.unrepeated < 1e-3
        return cycle.eccentricity[0]

    one, two, four = place(24), place(48), place(96)
    assert 1.6 < math.log2(np.linalg.norm(one - two) / np.linalg.norm(two - four)) < 2.6


def test_smooth_surfaces_that_meet_are_named():
    """A journal that is pressed long enough without turning squeezes out the oil of a cell."""
    film, rate = bearing(24, 3), 0.1
    state = film.start()
    conditions = Conditions(0.0, rate=rate, before=rate * state.volume)
    with pytest.raises(FilmError, match="smooth surfaces meet"):
        film.solve(state, conditions, load=np.array([1e5, 0.0]))


class Refusing(JournalLoads):
    """Loads whose film is not solved over more than a third of one of the steps."""

    def solve(self, bearing, guess, place, rate, before):
        if 2 < place % self.count <= 3 and rate * self.period / self.count < 3:
            raise FilmError("refused")
        return super().solve(bearing, guess, place, rate, before)


def test_a_journal_that_nothing_holds_is_loaded_until_oil_presses():
    """The bearing is just filled without pressure, so that no pressure says where the load moves it."""
    film = bearing()
    start, none = film.start(), np.zeros(film.reynolds.grid.shape)
    start = replace(start, film=FilmState(none, none + 1.0, none > 0))
    conditions = Conditions(SPEED, rate=1e3, before=1.01e3 * start.volume)
    state = film.solve(start, conditions, load=np.array([500.0, 0.0]))
    assert film.reynolds.grid.resultants(state.pressure) == pytest.approx([500.0, 0.0], abs=0.05)


@pytest.mark.parametrize("load", [[10.0, -3.0], [100.0, 20.0], [1000.0, 300.0]])
def test_a_journal_crosses_an_empty_bearing_to_the_few_cells_that_hold_it(load):
    """In one short step, with a fifth of the oil: nothing holds the journal on its way."""
    film = bearing(48, 4)
    start, none = film.start((-0.8 * C, 0.1 * C)), np.zeros(film.reynolds.grid.shape)
    start = replace(start, film=FilmState(none, none + 0.2, none > 0))
    state = film.solve(start, Conditions(SPEED, None, 1e5, 1e5 * start.volume), load=np.array(load))
    assert film.reynolds.grid.resultants(state.pressure) == pytest.approx(load, rel=1e-3)
    assert 0 < state.film.full.sum() < 10
    assert film.reynolds.grid.total(state.volume - start.volume) == pytest.approx(0, abs=1e-2)


def test_a_hole_loses_no_oil_where_a_film_is_nearly_right():
    """Pressure of the hole alone is wrong: what is left of that after a step would be much of the flow."""
    film = bearing(oil=Oil(1e-8, 0.02))
    conditions = Conditions(SPEED, Supply(film.reynolds.grid.hole(math.pi, 6.0), 0.7))
    state = film.solve(film.start((0.9 * C, 0.0)), conditions)
    hole = conditions.supply.share > 0.9
    wrong = replace(state.film, pressure=np.where(hole, 0.0, state.film.pressure))
    found = film.solve(replace(state, film=wrong), conditions).balance
    assert found.supplied == pytest.approx(found.leaked, rel=1e-4)


def test_a_step_in_parts_keeps_the_oil():
    """Over a cycle as much comes in as leaves, although one step is of another method, in four parts."""
    film, angle = bearing(24, 3), 2 * math.pi * np.arange(12) / 12
    acting = Refusing(
        period=0.02,
        load=np.stack([500 + 6000 * np.cos(angle) ** 3, 6000 * np.sin(2 * angle)], axis=1),
        speed=np.full(12, SPEED),
        inlet=0.5,
        hole_diameter=6.0,
        hole_angle=2 * angle,
    )
    cycle = integrate(film, acting)
    assert [len(state.parts) for state in cycle.states] == [0, 0, 0, 3] + [0] * 8
    assert cycle.unrepeated < 1e-3
    assert cycle.supplied == pytest.approx(cycle.leaked, rel=1e-3)


class Filled(JournalLoads):
    """Loads whose film is not solved where a cell would have less than no oil."""

    def solve(self, bearing, guess, place, rate, before):
        if (before < 0).any():
            raise FilmError("refused")
        return super().solve(bearing, guess, place, rate, before)


def test_a_cell_that_drains_is_empty_where_less_is_not_solved_and_owes_the_rest():
    """What backward differences would take beyond all of its oil is taken where it fills again."""
    film, count = bearing(24, 3), 24
    acting = Filled(
        period=0.02,
        load=np.tile([3000.0, 0.0], (count, 1)),
        speed=np.full(count, SPEED),
        inlet=0.5,
        grooves=film.reynolds.grid.groove(math.pi, 0.3),
    )
    course, total = _Integration.begun(film, acting, None), film.reynolds.grid.total
    (state,) = [*course.states][-1:]
    emptiest = np.unravel_index(state.film.fill.argmin(), state.film.fill.shape)
    assert 0 < state.film.fill[emptiest] < 1
    course.oil[emptiest] -= 5 * state.volume[emptiest]
    before, flown = total(course.oil), 0.0
    for _ in range(5):
        course.advance()
        state = course.states[-1]
        assert not state.parts
        assert state.film.fill.min() > -1e-9
        flown -= np.subtract(*state.flows[1::-1]) * acting.period / count
    assert total(course.oil) - before == pytest.approx(flown, abs=1e-6 * before)


def test_a_hole_covers_its_area_wherever_it_is():
    grid = FilmGrid(R, 25.0, 64, 8, halved=False)
    areas = [grid.hole(angle, 5.0).sum() * grid.area[0] for angle in (0.0, 0.03, 1.0, -3.14)]
    assert areas == pytest.approx([math.pi * 5.0**2 / 4] * 4, rel=0.02)


def test_a_groove_covers_its_arc():
    grid = FilmGrid(R, 25.0, 64, 8)
    assert grid.groove(0.37, 0.5).mean() == pytest.approx(0.5 / (2 * math.pi), rel=1e-9)


def test_roelands_oil_thickens_under_pressure():
    oil, pressure = Oil(8e-9, 0.013), np.array([0.0, 1e-3, 50.0, 200.0])
    relative = oil.relative_viscosity(pressure)
    assert (relative[1] - 1) / 1e-3 == pytest.approx(0.013, rel=1e-4)
    assert relative[3] == pytest.approx(8.749, rel=1e-3)  # exp(αp) would be 13.5
    q, slope = oil.generalised(pressure)
    exact = [quad(lambda p: 1 / oil.relative_viscosity(np.array(p)), 0, top)[0] for top in pressure]
    assert q == pytest.approx(exact, rel=1e-9)
    assert slope == pytest.approx(1 / relative)


def test_no_oil_thickens_without_limit():
    oil = Oil(8e-9, 0.02)
    assert oil.relative_viscosity(np.array([200.0, 5e3])) == pytest.approx([41.07, 1e3], rel=1e-3)
    assert oil.relative_viscosity(np.array(oil.solid)) == pytest.approx(1e3)
    q, slope = oil.generalised(np.array([oil.solid, oil.solid + 4e3]))
    assert q[1] - q[0] == pytest.approx(4.0)
    assert slope == pytest.approx(1e-3)
    assert Oil(8e-9, 1e-6).solid == math.inf  # beyond numbers


def test_a_pressure_falls_as_the_flow_does():
    """Where oil hardly flows, a step leaves no cell without oil; solid oil loses its pressure at once."""
    oil, full = Oil(8e-9, 0.015), np.ones((1, 2), dtype=bool)
    film = FilmState(np.array([[oil.solid + 300.0, 5.0]]), np.ones((1, 2)), full)
    after = film.changed(np.array([[-1300.0, -10.0]]), oil)
    assert after.pressure == pytest.approx(np.array([[oil.solid - math.log(16) / 0.015, 0.0]]))
    assert after.full.tolist() == [[True, False]]
    near = film.changed(np.array([[-1e-3, 1e-3]]), oil).pressure
    assert near - film.pressure == pytest.approx(np.array([[-1e-3, 1e-3]]), abs=1e-7)


def test_a_cycle_begins_without_load_although_grooves_press():
    """The journal turns between two grooves while its loads are brought up from nothing."""
    film = Bearing(Reynolds(FilmGrid(60.0, 50.0, 64, 5), Oil(5e-9, 0.0135)), 0.095)
    grid, count = film.reynolds.grid, 24
    grooves = grid.groove(math.pi / 2, 0.35, 30.0) + grid.groove(-math.pi / 2, 0.35, 30.0)
    acting = JournalLoads(
        period=0.12, load=np.full((count, 2), 1e3), speed=np.full(count, 4e3), inlet=0.52, grooves=grooves
    )
    assert integrate(film, acting).repeats


def test_a_film_beyond_the_model_is_refused_by_name():
    acting = JournalLoads(
        period=0.02, load=np.full((12, 2), 1e7), speed=np.zeros(12), inlet=0.5, hole_diameter=0.0
    )
    with pytest.raises(FilmError, match=r"beyond \S+ µm at \S+ MPa under up to 1\.13e\+04 MPa of specific"):
        integrate(bearing(24, 3), acting)


def test_a_film_whose_steps_fail_again_and_again_is_refused():
    """Each is solved in four parts, so that the film would end after all."""

    class Failing(JournalLoads):
        def solve(self, bearing, guess, place, rate, before):
            if place >= 0 and rate * self.period / self.count < 3:
                raise FilmError("refused")
            return super().solve(bearing, guess, place, rate, before)

    acting = Failing(period=0.02, load=np.full((12, 2), 1e3), speed=np.full(12, SPEED), inlet=0.5)
    with pytest.raises(FilmError, match=r"not solved beyond .* refused"):
        integrate(bearing(24, 3), acting)


def test_pressure_of_an_oil_that_thickens_is_higher():
    plain, thick = bearing(), bearing(oil=Oil(1e-8, 0.02))
    position = (-0.8 * C, 0.0)
    one, other = (each.film.pressure.max() for each in (turning(plain, position), turning(thick, position)))
    assert other > 1.1 * one


def test_an_oil_thins_by_astm_d341_and_meets_its_grade():
    oil = WarmOil((40.0, 100.0), (68.0, 9.1), 860.0, 0.0)
    kelvin, nu = np.log10([313.15, 373.15]), np.log10(np.log10(np.array([68.0, 9.1]) + 0.7))
    chart = 10**10 ** np.polyval(np.polyfit(kelvin, nu, 1), math.log10(423.15)) - 0.7
    assert oil.at(150.0).viscosity / oil.density_at(150.0) == pytest.approx(chart, rel=1e-9)
    assert oil.at(40.0).viscosity == pytest.approx(68.0 * oil.density_at(40.0))
    kinematic, sheared = grade("SAE 10w-40")
    assert (kinematic, sheared) == (12.5, 3.5)
    assert grade("15W40") == grade("40") == (12.5, 3.7)
    dynamic = WarmOil.of([(40.0, 58.0), (100.0, 8.5)], 860.0, 0.0)
    assert dynamic.at(100.0).viscosity == pytest.approx(8.5e-9)


def test_asperities_follow_the_integrals_of_greenwood_and_tripp():
    rough = Asperities(4e-4, 42.0, 0.1)
    gap = np.array([-8e-4, 0.0, 4e-4, 1.2e-3, 3e-3])

    def mean(power, x):
        return quad(lambda s: (s - x) ** power * math.exp(-s * s / 2), x, x + 12)[0] / math.sqrt(2 * math.pi)

    pressure, slope = rough.pressure(gap)
    assert pressure == pytest.approx([*(42 * mean(2.5, h / 4e-4) for h in gap[:4]), 0.0], rel=1e-6)
    step = 1e-9
    assert slope == pytest.approx((rough.pressure(gap + step)[0] - pressure) / step, rel=1e-3)
    space, share = rough.space(gap)
    assert space == pytest.approx([4e-4 * mean(1, -h / 4e-4) for h in gap[:4]] + [3e-3], rel=1e-7)
    assert share == pytest.approx((rough.space(gap + step)[0] - space) / step, rel=1e-4)


def test_rough_surfaces_carry_what_the_film_cannot():
    """A journal that hardly turns sinks into the asperities until they carry it."""
    rough = replace(bearing(), asperities=Asperities(8e-4, 42.0, 0.1))
    state, load = rough.start(), np.array([2000.0, 0.0])
    supply = Supply(rough.reynolds.grid.groove(math.pi, 0.2), 1e-4)
    for speed in (SPEED, SPEED / 10, SPEED / 1e3, SPEED / 1e6):
        state = rough.solve(state, Conditions(speed, supply), load=load)
        assert rough.reynolds.grid.resultants(state.pressure) == pytest.approx(load, rel=1e-7, abs=1e-4)
    assert state.touching.sum() > 0.999 * state.pressure.sum() > 0
    assert state.gap.min() > 0
    force, power = state.friction
    pressed = rough.reynolds.grid.total(state.touching)
    assert force == pytest.approx(0.1 * pressed, rel=1e-3)
    assert power == pytest.approx(force * SPEED / 1e6, rel=1e-2)


def test_asperities_carry_nothing_over_a_hole():
    """A groove all round that covers half of the width leaves half of a bearing."""
    rough, load = replace(bearing(), asperities=Asperities(8e-4, 42.0, 0.1)), np.array([2000.0, 0.0])
    groove = Supply(rough.reynolds.grid.groove(0.0, 2 * math.pi, 12.5), 1e-7)
    assert set(groove.share.ravel()) == {0.0, 1.0}
    there, shares = [], []
    for supply, force_on_it in ((groove, load), (None, 2 * load)):
        state = rough.start((1.03 * C, 0.0))
        there.append(rough.solve(state, Conditions(SPEED / 1e9, supply), load=force_on_it))
        shares.append(there[-1].touching.sum() / there[-1].pressure.sum())
    assert shares == pytest.approx([1.0, 1.0], rel=1e-5)
    assert there[0].position == pytest.approx(there[1].position, rel=1e-6, abs=1e-9)
    assert there[0].thinnest == pytest.approx(there[1].thinnest, rel=1e-6)
    assert not there[0].touching[groove.share > 0].any()
    # What the hole itself leaves of the gap is no film.
    over = replace(there[0], planes=np.where(groove.share > 0, -1.0, there[0].planes))
    assert over.thinnest == there[0].thinnest


def test_what_bulges_into_a_hole_does_not_cut_it_off():
    rough = replace(bearing(), asperities=Asperities(8e-4, 42.0, 0.1))
    supply = Supply(rough.reynolds.grid.groove(0.0, 0.3, 12.5), 0.5)
    state = rough.solve(rough.start((C + 9 * 8e-4, 0.0)), Conditions(SPEED, supply))
    inside = supply.share == 1
    assert state.planes[inside].max() < -6 * 8e-4
    assert state.film.pressure[inside] == pytest.approx(0.5, rel=0.02)
    assert state.film.pressure.max() > 1.0


@pytest.mark.parametrize(("cells", "within"), [((96, 7), 0.05), ((192, 14), 0.015)])
def test_oil_flows_from_a_round_hole_to_the_ends_as_from_a_source_in_a_strip(cells, within):
    """A source in the middle of a strip of width B: −ln |tanh(π(x + iz)/2B)|/2π, on a rim −ln(πr/2B)/2π."""
    radius, width, clearance, viscosity, pressure = 26.0, 25.0, 0.02, 5e-9, 0.4
    grid = FilmGrid(radius, width, *cells, graded=1.0)
    film = Bearing(Reynolds(grid, Oil(viscosity)), clearance)
    for diameter in (5.0, 8.0):
        away = -math.log(math.pi * diameter / 4 / width)
        exact = 2 * math.pi * clearance**3 / (12 * viscosity) * pressure / away
        for turned in (0.0, 0.25, 0.5):  # of a cell
            supply = Supply(grid.hole(turned * 2 * math.pi / cells[0], diameter), pressure)
            state = film.solve(film.start(), Conditions(0.0, supply))
            assert state.balance.leaked == pytest.approx(exact, rel=within)
            assert state.balance.supplied == pytest.approx(state.balance.leaked, rel=1e-6)


def test_oil_flows_from_a_hole_to_ends_that_stand_in_oil_by_poiseuille():
    film, around = bearing(oil=THIN), 0.1
    grid = film.reynolds.grid
    share = grid.groove(0.0, 2 * math.pi, 12.5)
    for pressure in (0.5, 0.5 * share + around):  # the same in all cells, and of the groove alone
        groove = 0.5 if isinstance(pressure, float) else 0.6
        balance = film.solve(film.start(), Conditions(0.0, Supply(share, pressure, around))).balance
        exact = 2 * 2 * math.pi * R * C**3 / (12 * THIN.viscosity) * (groove - around) / (12.5 - 12.5 / 2)
        assert balance.supplied == pytest.approx(exact, rel=1e-3)
        assert balance.leaked == pytest.approx(exact, rel=1e-3)
        assert balance.brought == pytest.approx((groove - around) * exact, rel=1e-3)
        assert balance.pressed == pytest.approx(balance.brought, rel=1e-5)


def test_films_on_asperities_differ_by_their_distances_over_the_roughness():
    """Where next to no gap is left, what is left of it has no meaning."""
    rough = replace(bearing(), asperities=Asperities(8e-4, 42.0, 0.1))
    one, other = (rough.start((rough.clearance + sunk * 8e-4, 0.0)) for sunk in (5.0, 5.001))
    assert one.gap.min() < 1e-6 * 8e-4
    assert one.unlike(other) == pytest.approx(1e-3)


@pytest.mark.parametrize("yields", [0.0, 4e-3])  # mm³/N, of the ovalisation
def test_a_film_without_viscosity_is_dry_contact(yields):
    """The journal tends to where asperities carry it, at first order in the viscosity, on three grids."""
    rough, force, area = Asperities(8e-4, 42.0, 0.0), 2000.0, 2 * math.pi * R * 25.0
    angle, size = 2 * math.pi * np.arange(2000) / 2000, math.sqrt(math.pi * R * 25.0)
    wave = np.cos(2 * angle) / size

    def unbalanced(state):
        pressure, _ = rough.pressure(C * (1 - state[0] * np.cos(angle)) + state[1] * wave)
        weights = area * (pressure * np.stack([np.cos(angle), wave])).mean(axis=1)
        return weights[0] / force - 1, state[1] / 0.1 - yields * weights[1] / 0.1

    (dry, bulge), _, found, _ = fsolve(unbalanced, (0.95 + 0.15 * (yields > 0), 0.0), full_output=True)
    assert found == 1
    assert (abs(bulge) / size > 0.05 * C) == (yields > 0)
    for n in (24, 36, 48):
        film, off = replace(bearing(n, 4), asperities=rough), []
        waves = np.cos(2 * film.reynolds.grid.angle)[:, None, None] * np.ones((4, 1)) / size
        film = replace(film, bore=ElasticBore(waves, waves[:, :1], np.array([[yields]])))
        state, supply = film.start(), Supply(film.reynolds.grid.groove(math.pi, 0.3), 1e-7)
        for viscosity in (1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13):
            thin = film.with_oil(Oil(viscosity))
            state = thin.solve(state, Conditions(SPEED, supply), load=np.array([force, 0.0]))
            off.append(np.linalg.norm(state.position / C - [dry, 0.0]))
        assert math.log10(off[-3] / off[-2]) == pytest.approx(1.0, abs=0.05)
        assert off[-1] < 2e-4


def test_a_film_that_cannot_carry_the_load_is_an_error():
    film = bearing()
    with pytest.raises(FilmError, match="oil film"):
        film.solve(film.start(), Conditions(0.0), load=np.array([100.0, 0.0]))


def comsol(n=128):
    """Of COMSOL 6.4, 'Elastohydrodynamic Lubrication in a Cylindrical Journal Bearing', where it is rigid.

    200 by 67 mm, 0.2 mm of clearance, 40 kN, 75 mPa·s, 25 1/GPa, grooves of 10 mm across the load with 2 bar.
    Pressures in the middle plane are read from its chart of the rigid bearing, as in the tests of
    mboct-mbdyn-pkg, MPa by degrees. Of the elastic one, no figures are known.
    """
    grid = FilmGrid(100.0, 67.0, n, 10)
    film = Bearing(Reynolds(grid, Oil(75e-9, 25e-3)), 0.2)
    share = np.maximum(grid.groove(0.0, 0.1), grid.groove(math.pi, 0.1))
    load = np.array([0.0, -40e3])
    return film, load, lambda rpm: Conditions(rpm * math.pi / 30 * 100.0, Supply(share, 0.2))


def test_an_oil_that_thickens_between_two_grooves_is_that_of_comsol():
    """At 10 000 rpm within 4 % of the largest pressure, where they fall steeply, too."""
    film, load, at = comsol()
    grid = film.reynolds.grid
    state = film.solve(film.start((0.0, -0.1)), at(1e4), load=load)
    chart = {200: 1.0, 220: 2.4, 240: 4.0, 260: 6.0, 280: 7.8, 287.6: 7.9, 300: 6.7, 320: 1.8}
    computed = np.interp(np.radians(list(chart)), grid.angle, state.film.pressure[:, 0])
    assert computed == pytest.approx(list(chart.values()), abs=0.04 * 7.9)
    highest = math.degrees(grid.angle[state.film.pressure[:, 0].argmax()])
    assert highest == pytest.approx(287.6, abs=4.0)  # within 0.5 % of the largest over 10°


def under_tension(film, conditions, load, position):
    """Position, over the clearance, and pressure of a full film whose tension is cut off (Gümbel 1921)."""
    grid, oil, steps = film.reynolds.grid, film.reynolds.oil, np.linspace(0.0, 100.0, 1001)
    ones, q = np.ones(grid.shape), oil.generalised(steps)[0]
    plain = Reynolds(grid, Oil(oil.viscosity))  # of q, in which the flow is linear

    def pressure(position):
        gap = film.planes(film.clearance * position, np.zeros(0))
        balance = plain.balance(FilmState(0 * ones, ones, ones > 0), gap, conditions)
        solved = plain.stencil.solver(balance.by_film)(-balance.excess.reshape(-1, 1))
        return np.interp(solved.reshape(grid.shape), q, steps)

    position = fsolve(lambda place: (grid.resultants(pressure(place)) - load) / 1e4, position, xtol=1e-5)
    return position, pressure(position)


def test_low_speeds_of_comsol_are_those_of_a_film_whose_tension_is_cut_off():
    """The chart does not conserve oil, by which its largest pressure at 316 rpm is a tenth above ours.

    With tension cut off all its points are met as mboct-mbdyn-pkg asks: within 7 % of the largest, no more
    than 5° beside their place. The film that conserves oil is 14 and 19 % off.
    """
    film, load, at = comsol(192)
    angle, position, ours = (
        np.degrees(film.reynolds.grid.angle),
        np.array([0.3, -0.4]),
        film.start((0.0, -0.1)),
    )
    charts = {
        316.23: {289: 0.0, 280: 21.4, 271: 15.0, 260: 6.0, 240: 1.6, 220: 0.6, 200: 0.4},
        100.0: {282: 0.0, 280: 20.0, 271: 20.0, 260: 4.8, 240: 0.9, 220: 0.4, 200: 0.2},
    }

    def off(chart, pressure):
        beside = np.array(list(chart))[:, None] + np.linspace(-5, 5, 21)
        found = np.abs(np.interp(beside, angle, pressure[:, 0]) - np.array(list(chart.values()))[:, None])
        return found.min(axis=1).max() / max(chart.values())

    for rpm in (1e4, 3162.3, 1e3, 316.23, 100.0):
        position, cut = under_tension(film, at(rpm), load, position)
        ours = film.solve(ours, at(rpm), load=load)
        if rpm in charts:
            assert off(charts[rpm], cut) < 0.07
            assert 0.12 < off(charts[rpm], ours.film.pressure) < 0.21
            assert cut.max() / ours.film.pressure.max() == pytest.approx(1.11, abs=0.02)


def test_derivatives_are_those_of_the_balance():
    film = bearing(12, 3, oil=Oil(1e-8, 0.013))
    reynolds, rng = film.reynolds, np.random.default_rng(0)
    state = turning(film)
    supply = Supply(reynolds.grid.hole(0.3, 9.0), 0.4)
    conditions = Conditions(SPEED, supply, rate=50.0, before=0.4)
    at, gap = state.film, state.gap
    balance = reynolds.balance(at, gap, conditions)
    by, small = rng.uniform(-1, 1, (2, *gap.shape)), 1e-6
    pressed = replace(at, pressure=at.pressure + small * by[0] * at.full)
    moved = replace(pressed, fill=at.fill + small * by[0] * ~at.full)
    for entries, change, other in (
        (balance.by_film, by[0], reynolds.balance(moved, gap, conditions)),
        (balance.by_gap, by[1], reynolds.balance(at, gap + small * C * by[1], conditions)),
    ):
        scale = 1.0 if entries is balance.by_film else C
        matrix = reynolds.stencil.matrix(entries, np.full(gap.shape, scale))
        predicted = (matrix @ change.ravel()).reshape(gap.shape)
        found = (other.excess - balance.excess) / small
        assert found == pytest.approx(predicted, abs=1e-4 * np.abs(predicted).max())
