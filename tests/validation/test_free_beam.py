"""Free–free beam of 1 × 0.02 × 0.03 m, against beam theory, and the rod's modes."""

import math

import numpy as np
import pytest

from fea.jobs.modes import modes_report, moves
from fea.material import Material
from fea.solid.eigen import RIGID, free_modes
from fea.solid.inertia import inertia
from fea.solid.mass import mass_matrix
from fea.study.flags import Flags
from fea.study.study import load_study
from geometry.bodies.shape import block
from geometry.invalid import InvalidValue
from mesh.body import mesh_body

STEEL = Material(youngs_modulus=207e3, poissons_ratio=0.3, density=7.8e-9, yield_strength=400.0)
LENGTH, THIN, THICK = 1000.0, 20.0, 30.0


@pytest.fixture(scope="module")
def mesh():
    return mesh_body(block(LENGTH, THIN, THICK), 25.0)


@pytest.fixture(scope="module")
def modes(mesh):
    return free_modes(mesh, STEEL, STEEL.density, 6)


def bending(height: float, root: float) -> float:
    """Hz of a free beam with shear and rotary inertia, to first order in (r/L)² (Goens 1931).

    (f_EB/f)² = 1 + (r/L)² (F² + 6F + (E/κG)(F² − 2F)) with F = βL (cosh βL − cos βL)/(sinh βL − sin βL),
    Euler and Bernoulli's f_EB = (βL)²/2πL² r √(E/ρ), and κ = 10(1 + ν)/(12 + 11ν) (Cowper 1966).
    """
    nu, radius = STEEL.poissons_ratio, height / math.sqrt(12)
    plain = root**2 / (2 * math.pi * LENGTH**2) * math.sqrt(STEEL.youngs_modulus / STEEL.density) * radius
    shape = (math.cosh(root) - math.cos(root)) / (math.sinh(root) - math.sin(root))
    stretch = shape * root
    kappa = 10 * (1 + nu) / (12 + 11 * nu)
    rotary = stretch**2 + 6 * stretch
    shear = 2 * (1 + nu) / kappa * (stretch**2 - 2 * stretch)
    return plain / math.sqrt(1 + (radius / LENGTH) ** 2 * (rotary + shear))


ROOTS = (4.730041, 7.853205, 10.995608)


def test_bending_frequencies_are_timoshenkos(modes):
    expected = sorted(bending(height, root) for height in (THIN, THICK) for root in ROOTS)
    # The theory is good to some 1e-4 for these slender modes; elements longer than the beam is thick add up
    # to 1.3e-3. Without shear and rotary inertia the third mode in the thick plane would be 1.8 % off.
    np.testing.assert_allclose(modes.frequencies[RIGID:], expected, rtol=2e-3)


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


def test_a_rods_first_mode_is_bending_far_above_the_speed():
    report = modes_report(Flags(size=14.0, rpm="6000").applied(load_study("leon-2001")), 2)
    figures = report.figures()
    first = figures["modes"][0]
    assert report.trusted
    assert first["orders"]["6000rpm"] == pytest.approx(first["frequency_Hz"] / 100)
    assert first["moves"] == moves(report.shapes["mode_1"]) == "sideways"  # the shank is thinnest that way
    assert np.linalg.norm(report.shapes["mode_1"], axis=1).max() == pytest.approx(1)


def test_a_count_beyond_reason_is_refused():
    with pytest.raises(InvalidValue, match="--count"):
        modes_report(load_study("leon-2001"), 0)
