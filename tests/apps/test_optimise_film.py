"""The oil film as a limit of the search: what it takes of two grids, and what it refuses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fea.__main__ import call
from fea.analysis.film import film_at
from fea.analysis.pipeline import prepare
from fea.apps.optimise.designs import Designs
from fea.apps.optimise.problem import FILM, MinimumFilm, required, variables
from fea.apps.optimise.run_optimise import search_study
from fea.pins import lubrication
from fea.study.film_table import FilmTable
from fea.study.flags import Flags
from fea.study.option_tables import OptimiseTable
from fea.study.study import load_study
from geometry.errors import InvalidValue

pytestmark = pytest.mark.slow


RPM = 6000.0


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    monkeypatch.setattr(lubrication, "FINE", (32, 5, 72))
    monkeypatch.setattr(lubrication, "COARSE", (24, 4, 54))


def study(least, **film):
    asked = Flags(size=20.0, pressure="bonded").applied(load_study())
    table = OptimiseTable(free={"big_end_ring_mm": (8.0, 12.0)}, min_film_um=least)
    return replace(asked, optimise=table, film=FilmTable(viscosity_mPas=8.0, **film))


def test_the_coarse_film_is_corrected_by_what_the_fine_one_changed():
    rod = prepare(study(1.0))
    result = film_at(rod, RPM)
    found, whole, again = result.figures, MinimumFilm.of(result), MinimumFilm.corrected(rod, RPM, (1.5, 7.0))
    limit = whole.constraint(1.0)
    assert (limit.factor, limit.error_percent) == pytest.approx((found.h_min_um, found.h_min_error_percent))
    # Beside a fine film, a coarse one repeats itself ten times less exactly.
    assert again.coarse == pytest.approx(whole.coarse, rel=3e-3)
    assert again.constraint(1.0).factor == pytest.approx(1.5 * again.coarse, rel=1e-6)
    assert whole.constraint(0.99 * limit.low).margin == pytest.approx(0.01)
    assert replace(whole, sound=False).constraint(0.1).margin < 0 < whole.constraint(0.1).margin


def test_a_stiffer_ring_moves_the_film_of_a_design():
    designs = Designs(variables(search_study(study(1.0))))
    first = designs.begin(designs.variables.start)
    moved = designs.at(np.array([0.75]))
    assert not moved.remeshed
    one, other = (
        next(limit for limit in design.constraints if limit.name == FILM) for design in (first, moved)
    )
    assert one.required == other.required == required(designs.variables.study)[FILM] == 1.0
    assert other.error_percent == pytest.approx(one.error_percent)
    rod = prepare(designs.variables.study_at(moved.x))
    assert other.factor == pytest.approx(film_at(rod, RPM).figures.h_min_um, rel=0.1)
    assert other.factor != pytest.approx(one.factor, rel=1e-3)


def test_a_rod_whose_film_starves_is_not_sought():
    asked = study(1.0, hole_deg=-90.0, inlet_bar=0.2)
    designs, rod = Designs(variables(search_study(asked))), prepare(asked)
    with pytest.raises(InvalidValue, match=r"optimise.min_film_um = 1.*at 6000 rpm, is starved"):
        designs._films(rod, [SimpleNamespace(rpm=RPM, film=None)], ())


OF_FORCES = "[forces]\npin_N = [4e4, 0.0]"
CLAMPED = '[engine]\npreset = "leon-2001"\n[analysis]\nsupport = "clamped"\npressure = "cosine-180"'


@pytest.mark.parametrize(
    ("tables", "why"), [(OF_FORCES, "no crank cycle"), (CLAMPED, "replaces the crank pin")]
)
def test_a_film_that_cannot_be_is_refused(tables, why, tmp_path):
    asked = f'[rod]\npreset = "leon-2001"\n{tables}\n[optimise]\nmin_film_um = 1.0'
    (tmp_path / "own.toml").write_text(asked, "utf-8")
    with pytest.raises(InvalidValue, match=rf"optimise.min_film_um = 1.*{why}"):
        search_study(load_study(tmp_path / "own.toml"))


def test_a_film_that_no_engine_has_is_refused(capsys):
    assert call(["optimise", "leon-2001", "--min-film-um", "1000"]) == 2
    assert "optimise.min_film_um = 1000: it is outside 0.2 to 20" in capsys.readouterr().err
