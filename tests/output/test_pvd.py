"""The load cases and the crank cycle as series for ParaView."""

from dataclasses import replace

import numpy as np
import pytest
import pyvista
from reports import RPM, reported_rod, solved_at

from fea.analysis.result import InstantFields
from fea.output.run_files import case_times
from fea.output.vtu import write_pvd
from fea.solid.stress import von_mises
from fea.study.flags import Flags
from fea.study.study import load_study
from geometry.errors import InvalidValue


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    rod, result, _, _ = reported_rod()
    played = replace(result, instants=InstantFields(rod, RPM, 240.0))
    return played.write(tmp_path_factory.mktemp("pvd") / "run")


def test_the_cases_stand_at_their_crank_angles(written):
    _, result, _, _ = reported_rod()
    reader = pyvista.PVDReader(written / "cases.pvd")
    angles = sorted(load.crank_deg for load in result.summary.loads.values())
    assert reader.time_values == pytest.approx(angles)
    reader.set_active_time_value(reader.time_values[0])
    (mesh,) = reader.read()
    assert mesh["von_mises"].max() == pytest.approx(result.cases["tension"].von_mises.max(), rel=2.5e-4)


def test_the_cycle_holds_what_is_solved_at_each_angle(written):
    rod, result, _, _ = reported_rod()
    reader = pyvista.PVDReader(written / "cycle.pvd")
    assert reader.time_values == [0, 240, 480]
    stress, moved = solved_at(rod, [240])
    reader.set_active_time_value(240)
    (mesh,) = reader.read()
    peak = result.summary.envelope.max_von_mises_MPa
    np.testing.assert_allclose(mesh["von_mises"], von_mises(stress[..., 0]), atol=1e-3 * peak)
    np.testing.assert_allclose(mesh["displacement"], moved[..., 0], atol=1e-6 * np.abs(moved).max())
    assert (mesh["principal_1"] >= mesh["principal_2"]).all()
    files = {entry.name for entry in written.iterdir()}
    assert {"cycle-000.vtu", "cycle-240.vtu", "cycle-480.vtu", "cycle.pvd", "cases.pvd"} <= files


def test_a_case_without_a_crank_angle_stands_before_the_others():
    """ParaView shows one file of a time: no two have the same."""
    angles = {"assembly.vtu": None, "tension.vtu": 3.5, "level_2.vtu": None, "gas.vtu": 3.5}
    times = {"assembly.vtu": -1.0, "tension.vtu": 3.5, "level_2.vtu": -2.0, "gas.vtu": 3.501}
    assert case_times(angles) == times


def test_no_name_is_an_array_of_the_nodes_and_of_the_elements(written):
    _, result, _, _ = reported_rod()
    grids = {path.name: pyvista.read(path) for path in written.glob("*.vtu")}
    grids |= {f"{name} in memory": result.to_pyvista(name) for name in ("tension", "envelope")}
    for name, grid in grids.items():
        assert not set(grid.point_data.keys()) & set(grid.cell_data.keys()), name
    tension = grids["tension.vtu"]
    assert {"von_mises_max", "safety_factor", "error_percent"} == set(tension.cell_data.keys())
    nodes = tension.cells_dict[pyvista.CellType.QUADRATIC_TETRA]
    for of_cells, of_nodes in (
        (tension["von_mises_max"], tension["von_mises"][nodes].max(axis=1)),
        (tension["safety_factor"], tension["safety_factor_node"][nodes].min(axis=1)),
    ):
        np.testing.assert_allclose(of_cells, of_nodes, rtol=2.5e-4)
    assert "masked" not in tension.point_data  # nothing is left out


def test_names_are_quoted(tmp_path):
    write_pvd(tmp_path / "a.pvd", {'a"<&.vtu': 1.0})
    assert "file='a\"&lt;&amp;.vtu'" in (tmp_path / "a.pvd").read_text()


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (Flags(pvd_step=10.0), "has no effect without the crank cycle"),
        (Flags(cycle=True, pvd_step=0.5), "must lie between 1 and 360"),
    ],
)
def test_a_step_needs_the_cycle_and_a_size(flags, says):
    with pytest.raises(InvalidValue, match=says):
        flags.applied(load_study("leon-2001"))
