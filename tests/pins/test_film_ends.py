"""The films of both ends: how pins and bores yield, and where their oil comes from."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fea.analysis.film import films_at
from fea.analysis.pipeline import prepare
from fea.contact.elastic_pin import HALF_COSINE, ORDERS, Pin, bending
from fea.film.constitutive import Oil
from fea.film.cycle import JournalLoads, integrate
from fea.film.functions import BoreFunctions
from fea.film.grid import FilmGrid
from fea.film.journal import Bearing
from fea.film.reynolds import Conditions, Reynolds, Supply
from fea.pins import lubrication
from fea.pins.lubrication import Films, Grooves, Lubrication
from fea.pins.yielding import End, YieldingPin, unit_forces
from fea.solid.errors import FilmError
from fea.study.film_table import FilmTable
from fea.study.flags import Flags
from fea.study.study import load_study
from geometry.errors import InvalidValue
from geometry.rod import proportioned
from loads.gas import NoGas

pytestmark = pytest.mark.slow


E, NU = 206e3, 0.3


def test_a_hollow_pin_yields_as_a_tube_of_lame():
    outer, inner, width = 12.0, 7.0, 25.0
    functions = BoreFunctions(outer, width)
    pin = YieldingPin.of(functions, Pin(outer, inner, width / 2, None, E, NU))
    # Displacement of the outside under 1 MPa there, in plane strain (Timoshenko & Goodier, article 28).
    between = outer**2 - inner**2
    exact = (1 + NU) / E * outer * ((1 - 2 * NU) * outer**2 + inner**2) / between
    assert pin.compliance[0, 0] == pytest.approx(exact, rel=1e-3)


def test_a_pin_bends_between_bore_and_bosses():
    """Half a cosine of pressure all along the bore bends the pin as the relief of contact assumes."""
    radius, width, force = 12.0, 30.0, 4e4
    functions, whole = BoreFunctions(radius, width), Pin(radius, 7.2, width / 2, (16.5, 35.7), E, NU)
    pin = YieldingPin.of(functions, whole)
    n, m = functions.terms.T
    peak, weights = 2 * force / (math.pi * radius * width), np.zeros(functions.count)
    for number in np.flatnonzero((m == 0) & np.isin(n, ORDERS)):
        weights[number] = peak * HALF_COSINE[ORDERS.index(n[number])] / functions.scales[number]
    moved = pin.compliance @ weights + pin.carried(np.array([[force], [0.0]]))[0]
    even, _ = functions.at(np.zeros(2), np.array([0.0, width / 2]))
    middle, end = moved[: len(n)] @ even
    assert middle - end == pytest.approx(bending(whole, force), rel=0.05)
    # A force the other way bends it as much on the other side, and one across by the sines.
    back = pin.carried(np.array([[-force], [0.0]]))[0]
    ahead = pin.carried(np.array([[force], [0.0]]))[0]
    assert back[: len(n)] == pytest.approx((-1.0) ** n * ahead[: len(n)], rel=1e-9, abs=1e-12)
    across = pin.carried(np.array([[0.0], [force]]))[0]
    (second,) = np.flatnonzero((functions.terms == [2, 0]).all(axis=1))
    assert across[second] == pytest.approx(-ahead[second], rel=1e-9)


@pytest.fixture(scope="module")
def rod():
    return prepare(Flags(size=18.0, pressure="bonded").applied(load_study()))


@pytest.fixture(scope="module")
def whole():
    return prepare(Flags(size=18.0, pressure="bonded", symmetry="none").applied(load_study()))


def test_the_small_end_swings_on_its_pin_as_the_study_says(rod):
    def swing(**keys):
        structure = replace(rod.structure, film=FilmTable(**keys))
        films = Films(structure, End.SMALL)
        return films.lubrication

    assert swing(piston_pin="fixed").swing == 1.0
    floating = swing()
    assert floating.swing == 0.5
    assert "assumed a floating piston pin (film.piston_pin)" in str(floating.notes)
    # Nothing else says what the film assumes of the pin where that is not in contact.
    assert "assumed small-end clearance 0.0144 mm (contact.small_end_clearance_mm)" in str(floating.notes)
    assert "big-end" not in str(floating.notes)
    assert floating.temperature == 140.0
    assert swing(viscosity_mPas=6.0).temperature is None


def test_where_no_film_of_the_small_end_can_be(rod, monkeypatch):
    monkeypatch.setitem(films_at.__globals__, "film_at", lambda *_: None)
    pressed = replace(rod.structure.contact, small_end_clearance_mm=-0.01)
    one, (note,) = films_at(replace(rod, structure=replace(rod.structure, contact=pressed)), 6000.0)
    assert one == (None,)
    assert "the pin is pressed into the bore (contact.small_end_clearance_mm = -0.01)" in str(note)

    def failing(_rod, _rpm, films=None):
        if films is not None:
            raise FilmError("not solved within 60 steps")

    monkeypatch.setitem(films_at.__globals__, "film_at", failing)
    one, (note,) = films_at(rod, 6000.0)
    assert one == (None,)
    assert str(note) == "oil film of the small end: none was found: not solved within 60 steps"


def test_the_small_end_swings_on_a_fixed_pin_twice_as_fast_as_on_a_floating_one(rod, monkeypatch):
    monkeypatch.setattr(lubrication, "COARSE", (16, 4, 36))
    cycle = rod.crank_cycle(6000.0)
    films = {}
    for kind in ("floating", "fixed"):
        found = Films(replace(rod.structure, film=FilmTable(viscosity_mPas=8.0, piston_pin=kind)), End.SMALL)
        films[kind] = found.coarse(cycle)
    floating, fixed = (films[kind] for kind in ("floating", "fixed"))
    assert fixed.acting.speed == pytest.approx(2 * floating.acting.speed)
    instants = cycle.at(lubrication.crank_angles(36))
    assert fixed.acting.speed == pytest.approx(-12.0 * instants.angular_velocity)
    assert fixed.acting.load == pytest.approx(instants.pin.T)
    for film in films.values():
        assert film.repeats
        assert film.supplied == pytest.approx(film.leaked, rel=1e-3)
        assert film.driven == pytest.approx(film.dissipated, rel=1e-2)
    assert fixed.dissipated > floating.dissipated


def test_the_film_of_a_two_stroke_engine_is_that_of_one_revolution(rod, monkeypatch):
    # Without gas, both revolutions of a four-stroke cycle load the bearing as that of a two-stroke engine.
    films = Films(replace(rod.structure, film=FilmTable(viscosity_mPas=8.0)))
    four = replace(rod.crank_cycle(6000.0), gas=NoGas())
    two = replace(four, engine=replace(four.engine, strokes=2))
    found = []
    for cycle, steps in ((four, 72), (two, 36)):
        monkeypatch.setattr(lubrication, "COARSE", (16, 4, steps))
        found.append(films.coarse(cycle))
    twice, once = found
    assert once.acting.period == pytest.approx(0.01)  # one of 6000 revolutions a minute
    assert twice.acting.period == pytest.approx(0.02)
    assert once.acting.load == pytest.approx(twice.acting.load[36:], rel=1e-6, abs=1e-6)
    # Cycles repeat themselves to a part in a hundred or so.
    assert once.thinnest == pytest.approx(twice.thinnest[36:], rel=0.02)
    assert once.dissipated == pytest.approx(twice.dissipated, rel=0.01)


R, WIDTH, CLEARANCE = 12.0, 25.0, 0.01


def rigid(width=WIDTH, n=48, m=20):
    return Bearing(Reynolds(FilmGrid(R, width, n, m), Oil(8e-9)), CLEARANCE)


def test_flooded_ends_fill_a_film_at_rest_with_their_pressure():
    film = rigid()
    supply = Supply(np.zeros(film.reynolds.grid.shape), 0.1, outside=0.1)
    state = film.solve(film.start((0.3 * CLEARANCE, 0.0)), Conditions(0.0, supply))
    assert state.film.pressure == pytest.approx(0.1, rel=1e-9)
    assert state.balance.leaked == pytest.approx(0.0, abs=1e-9)


def test_a_film_that_is_squeezed_draws_its_oil_from_flooded_ends():
    film, count = rigid(m=4, n=16), 36
    swing = np.cos(2 * math.pi * np.arange(count) / count)
    load = np.stack([500 * swing, np.zeros(count)], axis=1)
    acting = JournalLoads(period=0.02, load=load, speed=np.zeros(count), inlet=0.1, flooded=True)
    cycle = integrate(film, acting, most=40)
    assert cycle.repeats
    # The oil in the gap, many times what a cycle exchanges, repeats within 1e-3.
    assert cycle.supplied == pytest.approx(cycle.leaked, rel=2e-2)
    assert cycle.leaked > 0
    assert cycle.driven == pytest.approx(cycle.dissipated, rel=1e-3)
    # Without oil around it, what is squeezed out never comes back. (A load that turns round would move the
    # pin through the empty half of the gap, where nothing resists it.)
    one_way = np.stack([500 + 250 * swing, np.zeros(count)], axis=1)
    dry = integrate(film, replace(acting, load=one_way, flooded=False), most=3)
    assert dry.supplied == 0 < dry.leaked
    assert dry.filled[-1] < dry.filled[0]


def test_a_groove_all_round_makes_two_bearings_of_one():
    whole, half = rigid(m=60), rigid(width=10.0, m=24)
    grooves = Grooves.of(FilmTable(grooves_deg=(90.0,), groove_arc_deg=360.0, groove_width_mm=5.0))
    share = grooves.share(whole.reynolds.grid)
    assert share.mean() == pytest.approx(5.0 / WIDTH)
    position, speed = (-0.6 * CLEARANCE, 0.0), 3000.0
    state = whole.solve(whole.start(position), Conditions(speed, Supply(share, 1e-3, outside=1e-3)))
    fed = Supply(np.zeros(half.reynolds.grid.shape), 1e-3, outside=1e-3)
    other = half.solve(half.start(position), Conditions(speed, fed))
    carried = [
        np.hypot(*film.reynolds.grid.resultants(each.pressure)[:2])
        for film, each in ((whole, state), (half, other))
    ]
    assert carried[0] == pytest.approx(2 * carried[1], rel=0.02)


def test_grooves_are_those_of_lund_and_thomsen():
    grid = FilmGrid(25.0, 25.0, 64, 8)
    table = FilmTable(grooves_deg=(90.0, 270.0), groove_arc_deg=20.0, groove_width_mm=20.0, grooves_in="pin")
    grooves = Grooves.of(table)
    both = sum(grid.groove(side * math.pi / 2, math.radians(20)) for side in (1, -1))
    across = np.clip((10.0 - grid.z) / grid.dz + 0.5, 0.0, 1.0)
    assert grooves.share(grid) == pytest.approx(both * across)
    assert grooves.share(grid, math.pi / 2) == pytest.approx(np.roll(both * across, 16, axis=0), abs=1e-9)
    assert grooves.turn
    assert Grooves.of(FilmTable()) is None


@pytest.mark.parametrize("end", End)
def test_on_all_of_a_symmetric_rod_the_film_is_that_of_the_half(rod, whole, end):
    """The meshes are mirror images: what is even about z = 0 is the same, and apart from what is odd."""
    half, both = (each.films.bore if end is End.BIG else each.small_end_films.bore for each in (rod, whole))
    shared = [
        np.flatnonzero(np.concatenate([degree, degree[harmonic > 0]]) % 2 == 0)
        for harmonic, degree in (bore.functions.terms.T for bore in (half, both))
    ]
    odd = np.setdiff1d(np.arange(both.functions.count), shared[1])
    for of_half, of_both in (
        (half.compliance, both.compliance),
        *([] if half.pin is None else [(half.pin.compliance, both.pin.compliance)]),
    ):
        largest = of_half.max()
        kept = [
            np.setdiff1d(some, bore.functions.rigid) for some, bore in zip(shared, (half, both), strict=True)
        ]
        one, other = (each[np.ix_(some, some)] for each, some in zip((of_half, of_both), kept, strict=True))
        assert other == pytest.approx(one, abs=1e-6 * largest)
        assert of_both[np.ix_(kept[1], odd)] == pytest.approx(0.0, abs=1e-6 * largest)
    assert both.relief[shared[1]] == pytest.approx(half.relief, rel=1e-6, abs=1e-12)
    instants = whole.crank_cycle(6000.0).at(np.array([0.0, 1.0, 6.5]))
    assert both.carried(instants)[:, :2] == pytest.approx(half.carried(instants))
    assert both.carried(instants)[:, 2:] == pytest.approx(0.0, abs=1e-6)


def test_bores_off_one_plane_turn_the_rod_on_its_pins(whole):
    """The film of either end takes the moments of inertia and of the force in the other bore."""
    shift, length = 0.4, whole.mesh.bores.rod_length
    cell = whole.mesh.cell
    points = cell.points + shift / length * cell.points[:, :1] * [0.0, 0.0, 1.0]
    rod = prepare(whole.study, mesh=replace(whole.mesh, cell=replace(cell, points=points)))
    instants = rod.crank_cycle(6000.0).at(np.array([0.0, 1.0, 6.5]))
    forces = np.array([rod.inertia.forces(each).symmetric[:, :2] for each in instants])
    for end, bore, straight in (
        (End.BIG, rod.films.bore, whole.films.bore),
        (End.SMALL, rod.small_end_films.bore, whole.small_end_films.bore),
    ):
        middle = end.middle(rod.structure)
        assert middle == pytest.approx(shift if end is End.SMALL else 0.0, abs=1e-9)
        force, moments = np.split(bore.carried(instants), 2, axis=1)
        assert force == pytest.approx(end.force(instants).T)
        others = np.tensordot(forces, points[:, 2] - middle, axes=((1,), (0,)))
        others += (end.other.middle(rod.structure) - middle) * end.other.force(instants).T
        assert moments * bore.functions.width / 2 == pytest.approx(-others, rel=1e-3, abs=1.0)
        kept = np.setdiff1d(np.arange(bore.functions.count), bore.functions.rigid)
        difference = (bore.compliance - straight.compliance)[np.ix_(kept, kept)]
        assert 1e-5 < np.abs(difference).max() / straight.compliance.max() < 0.05


def test_grooves_in_the_shell_and_in_the_pin_feed_the_big_end(rod, monkeypatch):
    """A groove all round feeds alike wherever it is; a longer one beside the hole raises the flow."""
    monkeypatch.setattr(lubrication, "COARSE", (16, 4, 36))
    plain = {"viscosity_mPas": 8.0, "hole_diameter_mm": 5.0}
    all_round = {**plain, "grooves_deg": (0.0,), "groove_arc_deg": 360.0, "groove_width_mm": 4.0}
    cycle, flows = rod.crank_cycle(6000.0), []
    for keys in (plain, all_round, {**all_round, "grooves_in": "pin"}):
        films = Films(replace(rod.structure, film=FilmTable(**keys)))
        films.__dict__["bore"] = rod.films.bore
        flows.append(films.coarse(cycle).leaked)
    without, shell, pin = flows
    assert shell == pytest.approx(pin, rel=1e-9)
    assert shell > 1.5 * without


def test_a_gallery_along_the_rod_feeds_the_small_end_from_the_big_one(rod, monkeypatch):
    """Without pressure, it is a hole in the oil around the small end, on the side of the shank."""
    monkeypatch.setattr(lubrication, "COARSE", (16, 4, 36))
    cycle, drawn, found = rod.crank_cycle(6000.0), rod.structure.drawn, {}
    hole = {"small_end_hole_diameter_mm": 3.5, "small_end_hole_deg": 180.0}
    for name, gallery, keys in (("hole", 0.0, hole), ("none", 3.5, {"inlet_bar": 0.01}), ("fed", 3.5, {})):
        film = FilmTable(viscosity_mPas=8.0, **keys)
        films = Films(replace(rod.structure, drawn=replace(drawn, oil_gallery=gallery), film=film), End.SMALL)
        films.__dict__["bore"] = rod.small_end_films.bore
        found[name] = films.coarse(cycle)
        assert ("hole of 3.5 mm along the rod full of oil" in str(films.lubrication.notes)) == (gallery > 0)
    assert found["none"].leaked == pytest.approx(found["hole"].leaked, rel=1e-2)
    fed = found["fed"]
    assert fed.leaked > 1.03 * found["hole"].leaked
    assert fed.supplied == pytest.approx(fed.leaked, rel=1e-3)
    assert fed.driven == pytest.approx(fed.dissipated, rel=1e-2)
    # Above the vapour's pressure, the atmosphere's 1 bar and the 4 bar of the big end's inlet.
    above = fed.acting.above
    assert set(fed.acting.inlet + above.ravel()) == {0.1, 0.5}
    assert (above > 0).tolist() == (fed.acting.grooves > 0).tolist()


def test_the_bore_of_a_tubular_shank_opens_into_the_film_of_the_big_end_alone(rod):
    drawn = proportioned(141.0, 50.0, 24.0, shank_section="tubular", shank_bore=8.0)
    structure = replace(rod.structure, drawn=drawn, film=FilmTable(viscosity_mPas=8.0, inlet_bar=5.0))
    big, small = (Films(structure, end).lubrication for end in (End.BIG, End.SMALL))
    assert big.holes == (lubrication.Hole(0.0, 8.0),)
    assert "the hole of 8 mm along the rod full of oil of 5 bar" in str(big.notes)
    assert small.holes == ()


def test_the_oil_hole_turns_with_the_crank_arm(rod, monkeypatch):
    """At top dead centre it is where the study puts it; then it turns with the crank, away from the rod."""
    seen = []
    monkeypatch.setattr(lubrication, "integrate", lambda _bearing, acting, **_: seen.append(acting))
    film = FilmTable(viscosity_mPas=8.0, hole_diameter_mm=5.0, hole_deg=30.0)
    cycle = rod.crank_cycle(6000.0)
    Films(replace(rod.structure, film=film)).coarse(cycle)
    (acting,) = seen
    crank = lubrication.crank_angles(len(acting.hole_angle))
    study = load_study()
    rod_angle = np.arcsin(study.engine.stroke_mm / 2 / study.rod.length * np.sin(crank))
    assert acting.hole_angle == pytest.approx(math.pi / 6 + crank + rod_angle, rel=1e-9)


def test_a_lubrication_refuses_what_does_not_suit_the_small_end(rod):
    tight = replace(rod.structure.contact, small_end_clearance_mm=0.001)
    structure = replace(rod.structure, contact=tight, film=FilmTable(viscosity_mPas=8.0))
    with pytest.raises(InvalidValue, match=r"small_end_clearance_mm = 0\.001: must lie between 0\.0024"):
        _ = Films(structure, End.SMALL).lubrication
    assert isinstance(Lubrication.of(structure), Lubrication)


def test_smooth_surfaces_that_meet_at_an_edge_are_refused(rod, monkeypatch):
    """The cells are open, but not the end of the bearing beyond the last of them."""
    films = Films(replace(rod.structure, film=FilmTable(viscosity_mPas=8.0, roughness_um=0.0)))
    film = SimpleNamespace(thinnest=np.array([1e-3, -1e-6]))
    monkeypatch.setattr(Films, "_integrated", lambda *_: film)
    with pytest.raises(FilmError, match=r"meet at an edge of the bore\. Give film\.roughness_um"):
        films.at(rod.crank_cycle(6000.0))


def test_a_rod_under_its_films_opens_the_gaps_that_they_have(monkeypatch):
    """Stress and film are of one rod: what it yields in a run is by what the films' gaps are wider."""
    # Means of cos φ over 48 cells lack 0.07 % of it: the film's weights miss as much of the load.
    monkeypatch.setattr(lubrication, "COARSE", (16, 4, 24))
    monkeypatch.setattr(lubrication, "FINE", (48, 4, 36))
    flags = Flags(size=18.0, pressure="oil-film")
    rod = prepare(replace(flags.applied(load_study()), film=FilmTable(viscosity_mPas=8.0)))
    cycle, structure, step = rod.crank_cycle(6000.0), rod.structure, 13
    instant = cycle.at(lubrication.crank_angles(36)[step : step + 1])
    moved = rod.equilibrium(instant).solution.displacement
    for end, films in ((End.BIG, rod.films), (End.SMALL, rod.small_end_films)):
        fine, *_ = films.at(cycle)
        facets, functions, bore = films.facets, films.functions, films.bore
        forces = unit_forces(functions, facets, len(structure.mesh.points))
        of_each = [
            facets.images * np.tensordot(own, each[..., 0], axes=2)
            for own, each in zip(forces, moved.values(), strict=True)
        ]
        found = np.concatenate(of_each)
        yields = fine.states[step].bulge - bore.relief
        if bore.pin is not None:
            yields = yields - bore.pin.compliance @ fine.weights[step]
            yields -= bore.pin.carried(end.force(instant))[0]
        kept = np.setdiff1d(np.arange(len(found)), functions.rigid)
        assert yields[kept] == pytest.approx(found[kept], abs=0.01 * np.abs(found[kept]).max()), end


def test_a_pin_that_is_pressed_in_has_no_film():
    study = Flags(size=18.0, pressure="oil-film").applied(load_study())
    rods = [
        prepare(replace(study, contact=replace(study.contact, small_end_clearance_mm=fit)))
        for fit in (0.01, -0.01)
    ]
    floats, pressed = (rod.pins for rod in rods)
    assert list(floats.films) == list(End)
    assert list(pressed.films) == [End.BIG]
    assert "cosine-180 presses on the small end, whose pin is pressed in" in str(pressed.notes)
    # At rest both press with half a cosine, of which the film's functions leave little out.
    gas = {case.name: case for case in rods[0].loading.at(rods[0].mass, 6000.0).cases}["gas"][None]
    one, other = (rod.equilibrium(gas).solution.displacement for rod in rods)
    for parity, moved in one.items():
        assert moved == pytest.approx(other[parity], abs=2e-3 * max(np.abs(u).max() for u in other.values()))
