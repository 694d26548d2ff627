"""The stress in a section against the forces beyond it, on bars whose stress is known in closed form."""

import dataclasses
from types import SimpleNamespace

import gmsh
import numpy as np
import pytest

from fea import run
from fea.analysis import prepared_rod as prepared
from fea.analysis.pipeline import prepare, solve_speed
from fea.base.checks import LIMITS
from fea.solid.inertia import SectionBalance
from fea.study.study import load_study
from geometry.bodies import block
from geometry.session import session
from loads.instants import in_motion
from mesh.generate import mesh_body

pytestmark = pytest.mark.slow


LENGTH, SIDE, DENSITY, FORCE = 100.0, 10.0, 7.8e-9, 2e4
AREA, INERTIA = SIDE**2, SIDE**4 / 12


@pytest.fixture(scope="module")
def bar():
    mesh = mesh_body(block(LENGTH, SIDE, SIDE), 3.0)
    mesh.points[:, 1:] -= SIDE / 2
    return mesh


REST = in_motion((0.0, 0.0))


def _stress(mesh, along, across=0.0, moment=0.0):
    """Of normal force, shear (in the mean) and −y σ_xx = `moment`, each (n_nodes,) or a number."""
    stress = np.zeros((len(mesh.points), 6))
    stress[:, 0] = along / AREA - moment * mesh.points[:, 1] / INERTIA
    stress[:, 3] = across / AREA
    return stress


def _case(axial, transverse=0.0, motion=REST):
    pin = np.array([axial, transverse])
    return dataclasses.replace(motion, pin=pin, crank=-pin)


@pytest.mark.parametrize("station", [20.0, 50.0, 71.3])
def test_a_pulled_and_bent_bar_balances(bar, station):
    """Exact stress of a cantilever (Timoshenko & Goodier 1970, art. 21), linear in y: rounding is left."""
    section = SectionBalance(bar, bar, DENSITY, LENGTH, station)
    case = _case(FORCE, 0.1 * FORCE)
    moment = 0.1 * FORCE * (LENGTH - station)
    assert section.error(case, _stress(bar, FORCE, 0.1 * FORCE, moment)) < 1e-9
    scale = FORCE * np.hypot(1, 0.1) + moment / np.sqrt(INERTIA / AREA)
    for wrong, off in (
        (_stress(bar, 1.1 * FORCE, 0.1 * FORCE, moment), 0.1 * FORCE),
        (_stress(bar, FORCE, 0, moment), 0.1 * FORCE),
        (_stress(bar, FORCE, 0.1 * FORCE, 0.9 * moment), 0.1 * moment / np.sqrt(INERTIA / AREA)),
    ):
        assert section.error(case, wrong) == pytest.approx(off / scale, rel=1e-6)


def test_a_moving_bar_balances(bar):
    """ρ A ∫ (a₀ + α × x − ω² x) beyond the section, in closed form; .3 %: Gauss points are in it or not."""
    station, (ax, ay), alpha, omega = 40.0, (-1e7, 2e7), 2e5, 300.0
    section = SectionBalance(bar, bar, DENSITY, LENGTH, station)
    mass, center = DENSITY * AREA * (LENGTH - station), (LENGTH + station) / 2
    along = -mass * (ax - omega**2 * center)
    across = -mass * (ay + alpha * center)
    own = mass * ((LENGTH - station) ** 2 + SIDE**2) / 12
    moment = across * (center - station) - own * alpha
    case = _case(FORCE, 0.0, in_motion((ax, ay), omega, alpha))
    gyration = np.sqrt(INERTIA / AREA)
    scale = FORCE + abs(moment) / gyration
    assert section.error(case, _stress(bar, FORCE + along, across, moment)) < 3e-3
    for wrong, missing in (
        (_stress(bar, FORCE, across, moment), along),
        (_stress(bar, FORCE + along, 0.0, moment), across),
        (_stress(bar, FORCE + along, across, 0.0), moment / gyration),
    ):
        assert section.error(case, wrong) == pytest.approx(abs(missing) / scale, abs=3e-3)


def test_a_run_with_first_order_elements_too_coarse_for_bending_is_marked(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bent.toml").write_text(
        '[rod]\npreset = "leon-2001"\n[material]\npreset = "leon-2001"\n[forces]\npin_N = [2000.0, 4000.0]\n'
        '[mesh]\nsize_mm = 12\nelement = "p1"\n[analysis]\nsupport = "clamped"\n'
    )
    checks = {name: run("bent.toml", element=name, out=name)["checks"] for name in ("p1", "p2")}
    assert not checks["p1"]["section_balance"]["pass"]
    assert checks["p2"]["section_balance"]["pass"]


def test_a_hole_amid_the_shank_is_no_reason_to_mark_a_run(tmp_path, monkeypatch):
    """A section through it errs by more than the limit; those beside it do not."""
    monkeypatch.chdir(tmp_path)
    with session():
        gmsh.model.add("drilled")
        occ = gmsh.model.occ
        tools = [(3, occ.addCylinder(x, 0, -9, 0, 0, 18, r)) for x, r in ((0, 12), (50, 7), (100, 8))]
        occ.cut([(3, occ.addBox(-25, -14, -6, 150, 28, 12))], tools)
        occ.synchronize()
        gmsh.write("drilled.step")
    (tmp_path / "drilled.toml").write_text(
        '[rod]\nstep = "drilled.step"\n[material]\npreset = "leon-2001"\n[forces]\npin_N = [2000.0, 0.0]\n'
        '[mesh]\nsize_mm = 9\nelement = "p1"\n'
    )
    analysis = prepare(load_study("drilled.toml"))
    through, *beside = (
        max(section.error(case.load, case.stress) for case in solve_speed(analysis, None).cases.values())
        for section in analysis.mid_sections
    )
    limit = LIMITS["section_balance"]
    assert through > limit > min(beside)
    assert solve_speed(analysis, None).checks["section_balance"].passed


@pytest.mark.parametrize(
    ("between", "middle"), [((40.0, 80.0), 60.0), ((60.0, 90.0), 75.0), ((5.0, 40.0), 22.5)]
)
def test_sections_lie_between_the_bores_of_a_rod_with_a_large_bore(monkeypatch, between, middle):
    """Midway between the pins (120 mm) where that is outside the bores, else midway between these."""
    monkeypatch.setattr(prepared, "SectionBalance", lambda *given: given[-1])
    bores = SimpleNamespace(between=between, rod_length=120.0)
    rod = SimpleNamespace(
        mesh=SimpleNamespace(bores=bores, whole=None, cell=None),
        model=SimpleNamespace(material=SimpleNamespace(density=7.8e-9)),
    )
    low, high = between
    stations = prepared.PreparedRod.mid_sections.func(rod)
    assert stations == pytest.approx((middle, (low + middle) / 2, (middle + high) / 2))
