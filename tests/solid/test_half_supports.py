"""A half model without nodes on its axis: a lever with forked ends whose bores have no seam there."""

import numpy as np
import pytest
from cad_files import drawn_study

from fea.analysis.pipeline import prepare, solve_speed
from fea.solid.parity import Parity
from fea.solid.supports import determinate_restraints, plane_conditions, require_restrained
from geometry.surfaces import Mirror


def draw(occ):
    """The ends nearest to z = 0 are cut away; a hole makes it lopsided about y = 0."""
    bores = [(3, occ.addCylinder(x, 0, -50, 0, 0, 100, r)) for x, r in ((0, 10), (100, 5))]
    occ.rotate(bores[:1], 0, 0, 0, 0, 0, 1, 1.0)
    occ.rotate(bores[1:], 100, 0, 0, 0, 0, 1, 2.0)
    forks = [(3, occ.addBox(x, -50, -2, 3, 100, 4)) for x in (-26, 123)]
    hole = (3, occ.addCylinder(50, 12, -50, 0, 0, 100, 3))
    occ.cut([(3, occ.addBox(-25, -17, -6, 150, 40, 12))], [*bores, *forks, hole])


@pytest.fixture(scope="module")
def rod(tmp_path_factory):
    return prepare(drawn_study(tmp_path_factory.mktemp("lever"), "lever", draw, 20.0))


def test_held_points_lie_on_the_mirror_plane_and_hold_just_what_it_does_not(rod):
    cell = rod.mesh.cell
    assert rod.mesh.symmetry is Mirror.HALF
    assert np.count_nonzero(np.hypot(*cell.points[:, 1:].T) < 1e-9) < 2
    held = determinate_restraints(cell)
    assert np.abs(cell.points[held.any(axis=1), 2]).max() == 0
    plane = plane_conditions(cell, Parity.SYMMETRIC)
    assert np.count_nonzero(held & ~plane) == 3  # x, y, and turning about z
    require_restrained(cell, held | plane)


def test_it_is_in_equilibrium(rod):
    checks = solve_speed(rod, None).checks
    assert checks["reactions"].value < 1e-9
    assert all(check.passed for check in checks.values())
