"""Free vibration: the free–free beam of `fea verify`, and the rod's modes."""

import numpy as np
import pytest

from fea.analysis.modes import modes_report, moves
from fea.solid.inertia import inertia, mass_matrix
from fea.solvers.vibration import RIGID, free_modes
from fea.study.flags import Flags
from fea.study.study import load_study
from fea.verify.cases.dynamics import BEAM
from fea.verify.cases.dynamics import BEAM_STEEL as STEEL
from geometry.bodies import block
from geometry.errors import InvalidValue
from mesh.generate import mesh_body

LENGTH, THIN, THICK = BEAM


@pytest.fixture(scope="module")
def mesh():
    return mesh_body(block(LENGTH, THIN, THICK), 25.0)


@pytest.fixture(scope="module")
def modes(mesh):
    return free_modes(mesh, STEEL, STEEL.density, 1)


def test_a_free_body_has_six_modes_without_frequency(modes):
    assert modes.frequencies[:RIGID].max() < 1e-4 * modes.frequencies[RIGID]
    assert modes.frequencies[RIGID] > 0
    assert modes.backward_error < 1e-10


def test_modes_are_orthogonal_in_mass(mesh, modes):
    shapes = modes.shapes.reshape(-1, modes.frequencies.size)
    gram = shapes.T @ (mass_matrix(mesh, STEEL.density) @ shapes)
    np.testing.assert_allclose(gram, np.eye(len(gram)), atol=1e-8)


def test_mass_matrix_moves_the_whole_mass(mesh):
    M = mass_matrix(mesh, STEEL.density)
    along = np.zeros((len(mesh.points), 3))
    along[:, 0] = 1
    assert along.ravel() @ (M @ along.ravel()) == pytest.approx(STEEL.density * LENGTH * THIN * THICK)
    turning = np.stack([-mesh.points[:, 1], mesh.points[:, 0], np.zeros(len(mesh.points))], axis=1)
    properties = inertia(mesh, STEEL.density).properties
    x, y, _ = properties.center
    about_origin = properties.inertia_z + properties.mass * (x**2 + y**2)
    assert turning.ravel() @ (M @ turning.ravel()) == pytest.approx(about_origin)


def test_a_rods_modes_lie_far_above_the_speed():
    report = modes_report(
        Flags(size=18.0, rpm="6000", pressure="cosine-180").applied(load_study("leon-2001")), 2
    )
    figures = report.figures()
    first = figures.modes[0]
    assert report.trusted
    assert first.orders["6000rpm"] == pytest.approx(first.frequency_Hz / 100)
    ways = [mode.moves for mode in figures.modes]
    assert ways == ["twisting", "sideways"]  # an I-section is weakest in torsion, then sideways
    assert np.linalg.norm(report.shapes["mode_1"], axis=1).max() == pytest.approx(1)


def test_a_count_beyond_reason_is_refused():
    with pytest.raises(InvalidValue, match="--count"):
        modes_report(load_study("leon-2001"), 0)


def test_a_twisting_rod_is_told_from_a_bending_one(mesh):
    places = mesh.points - [LENGTH / 2, THIN / 2, THICK / 2]
    x, y, z = places.T
    twist, bend, nothing = x / LENGTH, (x / LENGTH) ** 2, np.zeros_like(x)
    assert moves(places, np.stack([nothing, -z * twist, y * twist], axis=1)) == "twisting"
    assert moves(places, np.stack([nothing, nothing, 100 * bend], axis=1)) == "sideways"
    assert moves(places, np.stack([-y * twist, 100 * bend, nothing], axis=1)) == "in the plane of motion"
