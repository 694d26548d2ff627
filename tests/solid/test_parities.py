"""One cell solved by parities is the whole rod: displacement, supports, silent traps."""

import numpy as np
import pytest
from strap import COSINE, LENGTH, strap, tilted_load, without_rigid_motion

from fea.base.choices import Support
from fea.base.material import Material
from fea.solid.bore import bore_facets, bore_load
from fea.solid.errors import UnderconstrainedError
from fea.solid.parity import Parity
from fea.solid.supports import plane_conditions, require_restrained
from fea.solvers.static import Model
from geometry.surfaces import Surface
from mesh.tetmesh import reflect, unmirrored

STEEL = Material(207e3, 0.28, 7.7e-9, 620.4)


@pytest.mark.parametrize("support", list(Support))
def test_quarter_and_half_equal_the_whole(support):
    quarter = unmirrored(strap())
    half = reflect(quarter, Surface.SYMMETRY_Y)
    whole = reflect(half, Surface.SYMMETRY_Z)
    found = []
    for cell, planes in (
        (quarter.mesh, (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z)),
        (half.mesh, (Surface.SYMMETRY_Z,)),
        (whole.mesh, ()),
    ):
        solution = Model(cell, STEEL, support).solve([tilted_load(cell)])
        image = unmirrored(cell)
        for plane in planes:
            image = reflect(image, plane)
        u = image.vector(
            solution.displacement[Parity.SYMMETRIC], solution.displacement.get(Parity.ANTISYMMETRIC)
        )
        found.append(without_rigid_motion(whole.mesh.points, u))
        for residuals in solution.residuals.values():
            assert residuals.backward_error < 1e-14
            assert support is Support.CLAMPED or residuals.reaction < 1e-8 * 3000
    largest = np.abs(found[2]).max()
    # 1e-10: rounding times a condition number of about 1e6
    assert found[0] == pytest.approx(found[2], abs=1e-10 * largest)
    assert found[1] == pytest.approx(found[2], abs=1e-10 * largest)


def test_the_antisymmetric_plane_holds_the_out_of_plane_displacement_too():
    mesh = strap()
    fixed = plane_conditions(mesh, Parity.ANTISYMMETRIC)
    on_plane = np.unique(mesh.facets[Surface.SYMMETRY_Y])
    assert fixed[on_plane][:, [0, 2]].all()
    off_z = on_plane[mesh.points[on_plane, 2] > 0]
    assert not fixed[off_z, 1].any()


def test_a_free_rod_is_refused_with_its_motions():
    mesh = strap()
    with pytest.raises(UnderconstrainedError, match=r"translation along x.*Add a support"):
        require_restrained(mesh, plane_conditions(mesh, Parity.SYMMETRIC))
    with pytest.raises(UnderconstrainedError, match="rotation about z"):
        require_restrained(mesh, plane_conditions(mesh, Parity.ANTISYMMETRIC))


def test_axial_loads_need_no_antisymmetric_part():
    mesh = strap()
    facets = bore_facets(mesh, Surface.SMALL_END_BORE, LENGTH)
    load = bore_load(facets, len(mesh.points), (1000.0, 0.0), COSINE.unbounded, COSINE.angle / 2).forces
    solution = Model(mesh, STEEL, Support.CLAMPED).solve([load])
    assert set(solution.displacement) == {Parity.SYMMETRIC}
