"""One cell solved by parities is the whole rod: displacement, supports, silent traps."""

import numpy as np
import pytest
from strap import BIG_BORE, LENGTH, SMALL_BORE, WIDTH, strap

from fea.choices import Support
from fea.material import Material
from fea.solid.bore import bore_facets, bore_load
from fea.solid.errors import UnderconstrainedError
from fea.solid.inertia import inertia
from fea.solid.parity import Parity, Split
from fea.solid.solve import Model
from fea.solid.supports import plane_conditions, require_restrained, rigid_modes
from geometry.surfaces import Surface
from loads.bearing import BorePressure
from loads.cases import RodMotion
from mesh.mirror import reflect, unmirrored

STEEL = Material(207e3, 0.28, 7.7e-9, 620.4)
COSINE = BorePressure.parse("cosine-180").tension


def tilted_load(mesh):
    """A pin force, a motion and the crank force that balances them."""
    body = inertia(mesh, STEEL.density)
    rod = body.properties
    motion = RodMotion((-2e6, 1e6), angular_velocity=300.0, angular_acceleration=3e4)
    (a_x, a_y), omega, alpha = motion.acceleration, motion.angular_velocity, motion.angular_acceleration
    x, about_origin = rod.center[0], rod.inertia_z + rod.mass * rod.center[0] ** 2
    pin = np.array([-3000.0, (about_origin * alpha + rod.mass * x * a_y) / LENGTH])
    crank = rod.mass * np.array([a_x - omega**2 * x, a_y + alpha * x]) - pin
    parts = [body.forces(motion)]
    for surface, center, radius, force in (
        (Surface.SMALL_END_BORE, LENGTH, SMALL_BORE, pin),
        (Surface.BIG_END_BORE, 0.0, BIG_BORE, crank),
    ):
        peak = COSINE.peak(np.hypot(*force), radius, WIDTH)
        facets = bore_facets(mesh, surface, center)
        load = bore_load(facets, len(mesh.points), tuple(force), lambda psi, p=peak: p * COSINE(psi))
        parts.append(load.forces)
    odd = [part.antisymmetric for part in parts if part.antisymmetric is not None]
    return Split(sum(part.symmetric for part in parts), sum(odd) if odd else None)


def without_rigid_motion(points, u):
    modes, flat = rigid_modes(points).reshape(-1, 6), u.reshape(-1)
    return (flat - modes @ np.linalg.lstsq(modes, flat)[0]).reshape(-1, 3)


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
    with pytest.raises(UnderconstrainedError, match=r"slide along x.*Add a support"):
        require_restrained(mesh, plane_conditions(mesh, Parity.SYMMETRIC))
    with pytest.raises(UnderconstrainedError, match="turn about z"):
        require_restrained(mesh, plane_conditions(mesh, Parity.ANTISYMMETRIC))


def test_axial_loads_need_no_antisymmetric_part():
    mesh = strap()
    facets = bore_facets(mesh, Surface.SMALL_END_BORE, LENGTH)
    load = bore_load(facets, len(mesh.points), (1000.0, 0.0), COSINE).forces
    solution = Model(mesh, STEEL, Support.CLAMPED).solve([load])
    assert set(solution.displacement) == {Parity.SYMMETRIC}
