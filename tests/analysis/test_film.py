"""The oil film of the big end in a run: coarse films on a coarse rod, for seconds."""

import json
import os
import re
from contextlib import nullcontext, redirect_stdout
from dataclasses import replace
from io import StringIO
from types import SimpleNamespace

import numpy as np
import pytest
import pyvista
from browser import browser, missing
from engines import LEON_ROD

from fea.__main__ import call
from fea.analysis.film import FilmResult, Regime, extreme_error, film_error, films_at
from fea.analysis.pipeline import prepare
from fea.apps.result import analyse
from fea.base.checks import LIMITS
from fea.base.note import NoteKind
from fea.film.grid import FilmGrid
from fea.machine.system import CAN_FORK
from fea.output.folder import read_columns
from fea.pins import lubrication
from fea.pins.yielding import End, YieldingBore
from fea.rod.loading import EngineLoading
from fea.solid.errors import FilmError
from fea.study.film_table import FilmTable
from fea.study.flags import Flags
from fea.study.study import load_study
from geometry.errors import InvalidValue

pytestmark = pytest.mark.slow


HEAD = '[rod]\npreset = "leon-2001"\n[engine]\npreset = "leon-2001"\n'


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """The folder of a run with its films and a report that solves them again, and what was said."""
    folder, said = tmp_path_factory.mktemp("film"), StringIO()
    out, study = folder / "run", folder / "study.toml"
    study.write_text(f"{HEAD}[speed]\nrpm = 6000\n[film]\nviscosity_mPas = 8.0\nlining_MPa = 60.0\n", "utf-8")
    asked = ["--size", "18", "--pressure", "bonded", "--elastic", "--out", str(out)]
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(said):
        patch.setattr(lubrication, "FINE", (32, 5, 72))
        patch.setattr(lubrication, "COARSE", (24, 4, 48))
        assert call(["run", str(study), *asked]) == 0
        assert call(["report", str(out)]) == 0
    return out, " ".join(said.getvalue().split())


def test_a_report_shows_the_film_at_every_crank_angle(ran):
    if why := missing("chromium"):
        pytest.skip(f"no chromium: {why}")
    out, _ = ran
    course = read_columns(out / "film.csv")
    slide = "(own.value = {}, own.dispatchEvent(new Event('input')))"
    slide = f"((own) => {slide})(document.getElementById('film-angle'))"
    shown = "Array.from(document.querySelectorAll('.film .now-value'), (own) => own.textContent)"
    with browser("chromium") as page:
        page.open(out / "report.html")
        assert page.run("window.feaReport.then((own) => own.films.length)") == 2
        for angle in (0, 200, 480):
            page.run(slide.format(angle))
            said = page.run(shown)
            most = [float(re.fullmatch(rf" {angle}°: at most ([\d.]+) MPa", text)[1]) for text in said]
            at = int(np.abs(course["crank_deg"] - angle).argmin())
            solved = [course[f"{end}p_max_MPa"][at] for end in ("", "small_end_")]
            assert most == pytest.approx(solved, rel=2e-3)
        assert page.complaints() == []


def pressed(grid):
    """Force of the pressure that is written, as VTK integrates: linear over each triangle."""
    corners = grid.points[grid.cells_dict[pyvista.CellType.TRIANGLE]].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    grid.cell_data["normal"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    grid.cell_data["pressure"] = grid.point_data_to_cell_data()["film_pressure"]
    grid.cell_data["pressing"] = grid["pressure"][:, None] * grid["normal"]
    return np.linalg.norm(grid.integrate_data()["pressing"])


def test_a_run_with_its_film(ran):
    out, said = ran
    assert "Oil film, big end: mixed, min. 0.9" in said
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert "film.csv" in summary["files"]
    found = summary["film"]["big_end"]
    # The trial model of the same bearing: 1.72 µm, 125 MPa, 1093 W, 0.34 l/min; with rigid bores 2.3 µm and
    # 185 MPa. Its gap is that of cells; at the edges of the bore there is less, here .97 µm, and 1.38 µm on
    # the grid of a run. This film is coarse, and so is the rod.
    assert found["h_min_um"] == pytest.approx(0.97, rel=0.1)
    assert found["p_max_MPa"] == pytest.approx(115, rel=0.15)
    assert found["power_W"] == pytest.approx(1093, rel=0.1)
    assert found["flow_l_min"] == pytest.approx(0.35, rel=0.25)
    assert found["lambda_min"] == pytest.approx(found["h_min_um"] / 0.4, rel=1e-5)
    small = summary["film"]["small_end"]
    assert set(small) == set(found)
    # On a rigid pin in a straight bore the trial model had .2 µm, with 162 MPa on asperities.
    assert small["verdict"] == "mixed"
    assert small["radial_clearance_um"] == 7.2
    assert small["lambda_min"] == pytest.approx(small["h_min_um"] / 0.4, rel=1e-5)
    assert small["power_W"] < 0.1 * found["power_W"]
    assert "Oil film, small end: mixed" in said
    checks = {name: check for name, check in summary["checks"].items() if name.startswith("film_")}
    assert set(checks) == {"film_repeats", "film_oil", "film_power", "film_force", "film_heat"}
    assert found["lining_factor"] == pytest.approx(60.0 / found["specific_load_MPa"], rel=1e-5)
    assert all(check["pass"] for check in checks.values())
    loads = read_columns(out / "loads.csv")
    for name, film in (("film", found), ("film_small_end", small)):
        assert {f"{name}.png", f"{name}_h_min.vtu", f"{name}_p_max.vtu"} <= set(summary["files"])
        # meshio takes one array for another where its own offsets meet those of the file, as in small ones.
        at = {key: pyvista.read(out / f"{name}_{key}.vtu") for key in ("h_min", "p_max")}
        centre = at["p_max"].points.mean(axis=0)
        assert centre == pytest.approx([141.0 if film is small else 0.0, 0.0, 0.0], abs=1e-3)
        assert 1e3 * at["h_min"]["film_thickness"].min() == pytest.approx(film["h_min_um"], rel=1e-5)
        end = "pin" if film is small else "crank"
        for key, grid in at.items():
            (row,) = np.flatnonzero(loads["crank_deg"] == film[f"{key}_deg"])
            force = [loads[f"{end}_{axis}_N"][row] for axis in ("axial", "transverse")]
            # The film carries its load to 1e-5 of the integral of its pressure.
            assert pressed(grid) == pytest.approx(np.linalg.norm(force), rel=1e-4)
        assert at["p_max"]["film_pressure"].max() == pytest.approx(film["p_max_MPa"], rel=1e-5)
    report = (out / "report.html").read_text(encoding="utf-8")
    assert "Oil films of the bearings" in report
    assert "chart-h_min_um" in report
    columns = read_columns(out / "film.csv")
    of_each = [
        "h_min_um", "p_max_MPa", "eccentricity_x", "eccentricity_y", "power_W", "asperity_percent",
        "filled_percent",
    ]  # fmt: skip
    assert list(columns) == ["crank_deg", *of_each, *(f"small_end_{name}" for name in of_each)]
    assert columns["small_end_h_min_um"].min() == pytest.approx(small["h_min_um"], rel=1e-5)
    assert columns["h_min_um"].min() == pytest.approx(found["h_min_um"], rel=1e-5)
    assert columns["crank_deg"][columns["p_max_MPa"].argmax()] == found["p_max_deg"]
    assert columns["power_W"].mean() == pytest.approx(found["power_W"], rel=1e-5)
    assert "oil film: assumed roughness 0.4 µm (film.roughness_um)" in str(summary["notes"])


@pytest.fixture(scope="module")
def bores():
    """The big end's bore from a quarter of the rod, and from all of it."""
    study = Flags(size=18.0, pressure="bonded").applied(load_study())
    return [
        YieldingBore.of(prepare(Flags(symmetry=which).applied(study)).structure)
        for which in ("quarter", "none")
    ]


def test_a_bore_yields_alike_on_a_part_of_the_rod_and_on_all_of_it(bores):
    quarter, whole = (bore.compliance for bore in bores)
    # Rigid motions depend on the restraints, and the meshes differ.
    kept = np.setdiff1d(np.arange(len(quarter)), bores[0].functions.translations)[:12]
    assert whole[np.ix_(kept, kept)] == pytest.approx(quarter[np.ix_(kept, kept)], abs=0.02 * quarter.max())


def test_the_functions_are_orthonormal_on_a_film(bores):
    grid = FilmGrid(25.0, 30.0, 64, 24)
    means = bores[0].functions.means(grid)
    products = np.tensordot(means, means, axes=((0, 1), (0, 1))) * grid.area[0] * grid.images
    # The means of a wave over cells are smaller than its peaks: of n waves by sin(πn/64)/(πn/64).
    assert products - np.diag(np.diag(products)) == pytest.approx(0.0, abs=0.03)
    waves = np.minimum(bores[0].functions.terms[:15, 0], 14)
    assert np.diag(products)[:15] == pytest.approx(np.sinc(waves / 64) ** 2, rel=1e-6)


@pytest.mark.parametrize(
    ("ratio", "share", "regime"),
    [(4.0, 0.0, "hydrodynamic"), (2.0, 0.5, "mixed"), (0.5, 0.05, "mixed"), (0.5, 0.5, "metal to metal")],
)
def test_the_regime_follows_from_the_roughness(ratio, share, regime):
    assert Regime.of(ratio, share) == regime


@pytest.mark.parametrize(
    ("regime", "bar", "verdict"),
    [
        (Regime.METAL, 100.0, "not determined"),
        (Regime.MIXED, 51.0, "not determined"),
        (Regime.MIXED, 50.0, "mixed"),
        (Regime.STARVED, 100.0, "starved"),  # says already that there is no verdict
    ],
)
def test_a_highest_pressure_with_a_wide_bar_gives_no_verdict(regime, bar, verdict):
    film = SimpleNamespace(
        regime=regime, sound=regime is not Regime.STARVED, _error=lambda _read, _error: bar
    )
    film.wide = FilmResult.wide.func(film)
    assert FilmResult.verdict.fget(film) == verdict


@pytest.mark.parametrize(
    ("study", "flags", "message"),
    [
        ("leon-2001-bolted", {"pressure": "cosine-180"}, r"cosine-180': .*\[assembly\], whose parts"),
        (
            "leon-2001",
            {"support": "clamped", "pressure": "oil-film"},
            "analysis.pressure = 'oil-film': .*clamped",
        ),
        ("leon-2001", {"film": True, "support": "clamped", "pressure": "cosine-180"}, "clamped"),
    ],
)
def test_where_no_film_can_be(study, flags, message):
    with pytest.raises(InvalidValue, match=message):
        Flags(**flags).applied(load_study(study))


@pytest.mark.parametrize(
    ("strokes", "rpm", "rollers", "why"),
    [
        (2, 1000, (), "presses on one side of the bore throughout the cycle"),
        (2, 9000, (), None),  # where inertia pulls before the gas pushes
        (4, 1000, (), None),  # at the dead centre of gas exchange
        (4, 1000, ("small end",), "it runs on rollers"),
    ],
)
def test_a_small_end_has_no_film_where_nothing_refills_it(strokes, rpm, rollers, why, monkeypatch):
    keys = {"gas": "otto", "compression_ratio": 10.0, "peak_pressure_bar": 60.0, "strokes": strokes}
    table = replace(load_study("leon-2001").engine, **keys, roller_bearings=rollers)
    loading = EngineLoading.of(table, 141.0)
    rod = SimpleNamespace(
        structure=None,
        engine=loading,
        crank_cycle=lambda rpm: loading.crank_cycle(LEON_ROD, rpm),
        small_end_films=SimpleNamespace(lubrication=None),
    )
    monkeypatch.setattr(End, "pressed_in", lambda *_: False)
    monkeypatch.setattr("fea.analysis.film.film_at", lambda *_: "film")
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    films, left_out = films_at(rod, rpm)
    assert len(films) == (2 if why is None else 1)
    assert [note.kind for note in left_out] == [NoteKind.OMISSION] * (why is not None)
    assert why is None or why in str(left_out[0])


class SmallEnd:
    """Its film is the number of the process that solves it, unless that process fails."""

    lubrication, known = None, None

    def __init__(self, fails=lambda: None):
        self.fails = fails

    def prepare(self, cycle):
        pass

    def at(self, cycle):
        self.fails()
        return os.getpid()

    def remember(self, cycle, found):
        self.known = found


def unsolved():
    raise FilmError("too thin")


@pytest.mark.skipif(not CAN_FORK, reason="processes cannot be copied")
@pytest.mark.parametrize("fails", [lambda: None, lambda: os._exit(3), unsolved])
def test_a_second_process_solves_the_film_of_the_small_end(fails, monkeypatch):
    small = SmallEnd(fails)
    rod = SimpleNamespace(
        structure=None,
        engine=EngineLoading.of(load_study("leon-2001").engine, 141.0),
        crank_cycle=lambda _: SimpleNamespace(engine=SimpleNamespace(strokes=4)),
        films=SmallEnd(),
        small_end_films=small,
        clock=lambda _: nullcontext(),
    )
    monkeypatch.setattr(End, "pressed_in", lambda *_: False)
    monkeypatch.setattr("fea.analysis.film.film_at", lambda *given: given[-1].known if given[2:] else "big")
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    films, left_out = films_at(rod, 6000.0)
    assert films[0] == "big"
    if fails is unsolved:
        assert (len(films), "too thin" in str(left_out[0])) == (1, True)
    else:  # where it crashed, nothing is known, and the film is solved here
        assert (films[1] is None) == (small.known is None)
        assert small.known != os.getpid()


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("radial_clearance_um = 1.0", "film.radial_clearance_um = 1: must lie between 2.5 and 250 µm"),
        ('oil = "5W-35"', "film.oil = '5W-35': is not an SAE grade"),
        (
            "viscosity_40C_mPas = 60.0",
            "film.viscosity_40C_mPas = 60: needs viscosity_100C_mPas, that",
        ),
        (
            "viscosity_100C_mPas = 8.0",
            "film.viscosity_100C_mPas = 8: needs viscosity_40C_mPas, that",
        ),
        ("viscosity_mPas = 0.0", "film.viscosity_mPas = 0: must be positive"),
        (
            "hole_diameter_mm = 28.0",
            "film.hole_diameter_mm = 28: leaves no land at the ends of the big end's",
        ),
        ("roughness_um = 8.0", "film.roughness_um = 8: must be less than the radial clearance of the small"),
        (
            "small_end_hole_diameter_mm = 40.0",
            "film.small_end_hole_diameter_mm = 40: leaves no land",
        ),
        ('piston_pin = "loose"', "film.piston_pin = 'loose': must be one of floating, fixed"),
        ("grooves_deg = [0.0]\ngroove_arc_deg = 20.0", "film.groove_width_mm is needed with"),
        (
            "grooves_deg = [0.0]\ngroove_arc_deg = 20.0\ngroove_width_mm = 28.0",
            "film.groove_width_mm = 28: leaves no land at its ends",
        ),
        (
            "grooves_deg = [0.0]\ngroove_arc_deg = 360.0\ngroove_width_mm = 18.0",
            "film.groove_width_mm = 18: lets the grooves cover 60% of the bore",
        ),
        (
            "grooves_deg = [0.0, 15.0]\ngroove_arc_deg = 20.0\ngroove_width_mm = 9.0",
            "film.groove_arc_deg = 20: must not exceed the 15°",
        ),
    ],
)
def test_a_clearance_or_hole_that_does_not_suit_the_bore(line, message, tmp_path, capsys):
    file = tmp_path / "tight.toml"
    file.write_text(
        f'{HEAD}[mesh]\nsize_mm = 18\n[analysis]\npressure = "bonded"\nunusual = true\n[film]\n{line}\n',
        encoding="utf-8",
    )
    assert call(["run", str(file)]) == 2
    assert message in capsys.readouterr().err


@pytest.fixture(scope="module")
def hot():
    """A run whose stress comes from the film of an oil that warms up."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lubrication, "FINE", (24, 4, 36))
        patch.setattr(lubrication, "COARSE", (16, 4, 24))
        study = replace(load_study(), film=FilmTable(oil="0W-40", inlet_C=100.0))
        yield analyse(study, rpm=6000, size=18.0, pressure="oil-film", cycle=True)


def test_stress_comes_from_the_film(hot):
    assert hot.trusted
    assert hot.summary.model.pressure == "oil-film"
    cosine = analyse(load_study(), rpm=6000, size=18.0, pressure="cosine-180")
    for name, case in cosine.cases.items():
        # On the shank both are the same load; at the eye of the big end the film gives another stress.
        x = hot.mesh.points[:, 0]
        middle = (x > 60) & (x < 90)
        near = np.abs(hot.cases[name].von_mises - case.von_mises)
        assert near[middle].max() < 0.03 * case.von_mises[middle].max()
    assert near[x < 30].max() < 0.02 * case.von_mises[x < 30].max()  # "gas": at rest the pressures agree
    eye = np.abs(hot.cases["tension"].von_mises - cosine.cases["tension"].von_mises)[x < 30].max()
    assert eye > 0.05 * cosine.cases["tension"].von_mises[x < 30].max()


def test_heat_balances(hot):
    found = hot.summary.film["big_end"]
    oil, cycle = hot.speed.film.lubrication.oil, hot.speed.film.cycle
    carried = oil.carried(found.temperature_C)  # 1.9 MPa/K of engine oils
    assert carried == pytest.approx(1.9, rel=0.05)
    rise = 0.8 * found.power_W * 1e3 / (carried * found.flow_l_min * 1e6 / 60)
    # What the heat balance may leave, by its check.
    assert found.temperature_C == pytest.approx(100.0 + rise, abs=LIMITS["film_heat"])
    assert cycle.bearing.reynolds.oil.viscosity == pytest.approx(oil.at(found.temperature_C).viscosity)


def test_a_hole_in_the_load_starves_the_film(monkeypatch):
    monkeypatch.setattr(lubrication, "FINE", (24, 4, 36))
    monkeypatch.setattr(lubrication, "COARSE", (16, 4, 24))
    table = FilmTable(viscosity_mPas=12.0, hole_deg=175.0, inlet_bar=3.6)
    found = analyse(replace(load_study(), film=table), rpm=6200, size=18.0, pressure="bonded", film=True)
    assert found.summary.film["big_end"].verdict == "starved"
    assert found.summary.film["big_end"].filled_percent < 33
    assert found.trusted
    assert "starved: the supply cannot keep the film full" in str(found.summary.notes)


def test_a_bar_is_of_first_order_and_never_more_than_all():
    ratio = lubrication.FINE[0] / lubrication.COARSE[0]
    fine, coarse = (5.0 + error for error in (0.1, 0.1 * ratio))  # the exact figure is 5.0
    assert film_error(fine, coarse - fine) == pytest.approx(100 * 0.1 / fine)
    assert film_error(5.0, 0.0, 0.1) == pytest.approx(2.0)
    assert film_error(5.0, 0.125, 0.1) == pytest.approx(film_error(5.0, 0.125) + 2.0)
    assert film_error(1e-30, 1.0) == pytest.approx(100.0)
    assert film_error(0.0, 0.0) == 100.0


def test_a_bar_of_an_extreme_counts_what_changes_beside_it():
    angle = 2 * np.pi * np.arange(144) / 144
    fine = 1 + 0.5 * np.cos(angle)
    coarse, ratio = 1 + 0.5 * np.cos(angle[::3]), lubrication.FINE[0] / lubrication.COARSE[0]
    assert extreme_error(np.max, fine, coarse, coarse) == pytest.approx(0.0, abs=0.2)
    for extreme in (np.min, np.max):  # of first order, and what a softer bore changes is added
        grid = extreme_error(extreme, fine, 1.02 * fine, 1.02 * fine)
        assert grid == pytest.approx(2.0 / (ratio - 1), rel=0.06)
        assert extreme_error(extreme, fine, fine, 0.97 * fine) == pytest.approx(3.0, rel=0.06)
    # The extreme is the same, and the course beside it is not.
    near = np.exp(-((angle - np.pi) ** 2) / 0.1)
    assert extreme_error(np.min, fine, fine + 0.05 * near * np.sin(angle), fine) > 1.0
    assert extreme_error(np.min, fine, 9 * fine, fine) == 100.0


def test_a_finer_mesh_softens_the_bore_as_estimated():
    bores = [
        YieldingBore.of(prepare(Flags(pressure="bonded", size=size).applied(load_study())).structure)
        for size in (10.0, 5.0)
    ]
    coarse, fine = bores
    softer = (fine.compliance - coarse.compliance).diagonal()
    kept = np.setdiff1d(np.arange(len(softer)), coarse.functions.translations)
    short = kept[coarse.functions.waves[kept] > 0.2]
    lacked, lacks = (bore.lacking * coarse.compliance.diagonal() for bore in bores)
    # The law has no more than the order and the size for all of them.
    assert 0.5 < np.exp(np.log((lacked - lacks)[short] / softer[short]).mean()) < 2.0
    afar = np.linalg.norm(fine.loaded - coarse.loaded) / np.linalg.norm(fine.loaded)
    assert 0.4 * afar < coarse.lacking[coarse.functions.oval] < 3 * afar


@pytest.mark.parametrize("end", ["big_end", "small_end"])
def test_first_order_elements_lack_as_much_compliance_as_estimated(end):
    linear, quadratic = (
        YieldingBore.of(prepare(Flags(size=8.0, element=element).applied(load_study())).structure, End(end))
        for element in ("p1", "p2")
    )
    kept = np.setdiff1d(np.arange(linear.functions.count), linear.functions.rigid)
    lacks = quadratic.compliance.diagonal()[kept] / linear.compliance.diagonal()[kept] - 1
    off = np.log(linear.lacking[kept] / lacks)
    shortest, oval = linear.functions.waves[kept].argsort()[-20:], kept == linear.functions.oval
    # What acts far from the bore deforms it as a wave twice around.
    for some in (off, off[shortest], off[oval]):
        assert 0.4 < np.exp(some.mean()) < 2.5


def test_a_film_beyond_the_hardness_of_its_metals_is_overloaded():
    cycle = SimpleNamespace(
        starved=False,
        too_hot=False,
        repeats=True,
        unbalanced=0.0,
        supplied=1.0,
        highest=np.array([50.0, 1001.0]),
        asperities=np.ones(2),
    )
    said = SimpleNamespace(asperities=None, end="big_end")
    overloaded = FilmResult(cycle, cycle, cycle, said, 1.0)
    assert (overloaded.verdict, overloaded.sound) == ("overloaded", False)
    others = dict.fromkeys(("filled_percent", "flow_l_min", "temperature_C"), 1.0)
    (doubt,) = overloaded._doubts(SimpleNamespace(p_max_MPa=1001.0, lining_factor=None, **others))
    assert doubt.startswith("overloaded: oil and asperities press with up to 1001 MPa")
    cycle.highest[1] = 999.0
    calm = FilmResult(cycle, cycle, cycle, SimpleNamespace(asperities=None), 1.0)
    assert (calm.verdict, calm.wide) == ("hydrodynamic", None)
