import dataclasses

import numpy as np
import pytest
from strap import BIG_BORE, LENGTH, SMALL_BORE, WIDTH, strap

from fea.base.choices import Support
from fea.pins.prescribed import PressedPins
from fea.rod.meshed_rod import Bores
from fea.solid.inertia import Tilt, inertia, resultants
from fea.solvers.static import Model
from fea.verify.body import STEEL
from geometry.surfaces import Surface
from loads.instants import given
from mesh.tetmesh import reflect, unmirrored

RHO = 7.7e-9
AXIAL = 3000.0  # N


def whole(shift=0.0):
    """The strap entire; its bores' middles off z = 0 by a shear of `shift` mm from one to the other."""
    mesh = reflect(reflect(unmirrored(strap()), Surface.SYMMETRY_Y), Surface.SYMMETRY_Z).mesh
    points = mesh.points.copy()
    points[:, 2] += shift * points[:, 0] / LENGTH
    return dataclasses.replace(mesh, points=points)


def of(mesh):
    """What loads ask for beside the mesh."""
    bores = Bores(LENGTH, BIG_BORE, WIDTH, SMALL_BORE, WIDTH)
    return bores, inertia(mesh, RHO), Support.INERTIA_RELIEF, "cosine-180"


def test_what_tilts_is_balanced_and_nothing_else_is_changed():
    mesh = whole(shift=1.0)
    tilt = Tilt.of(mesh.points, inertia(mesh, RHO))
    forces = np.random.default_rng(0).normal(size=mesh.points.shape)
    scale = np.repeat([1.0, LENGTH], 3) * np.abs(forces).sum()
    before, after = (resultants(mesh.points, each) / scale for each in (forces, tilt.balanced(forces)))
    assert after[[2, 3, 4]] == pytest.approx([0, 0, 0], abs=1e-14)
    assert after[[0, 1, 5]] == pytest.approx(before[[0, 1, 5]], abs=1e-14)


@pytest.mark.parametrize("shift", [0.0, 0.5])
def test_a_rod_whose_bores_are_off_one_plane_is_left_without_reactions(shift):
    """The moment is force times what the pins are off one line, where half-cosines press: 8R / 3π."""
    mesh = whole(shift)
    (case,) = PressedPins(mesh, *of(mesh)).respond(given(AXIAL)[None])
    solution = Model(mesh, STEEL, Support.INERTIA_RELIEF).solve([case.forces])
    reach = LENGTH + 8 / (3 * np.pi) * (BIG_BORE + SMALL_BORE)
    assert case.tilt == pytest.approx(shift * reach / LENGTH**2, rel=1e-3, abs=1e-12)
    assert max(found.reaction for found in solution.residuals.values()) < 1e-8 * AXIAL


def test_the_unit_loads_of_a_cycle_do_not_tilt_either():
    mesh = whole(shift=1.0)
    loads = [load for fields in PressedPins(mesh, *of(mesh)).span([]).fields() for load in fields.nodal]
    sums = np.array([resultants(mesh.points, load) for load in loads])
    sizes = np.array([np.abs(load).sum() * LENGTH for load in loads])
    assert np.abs(sums[:, [2, 3, 4]]).max(axis=1) == pytest.approx(
        np.zeros(len(loads)), abs=1e-13 * sizes.max()
    )
