import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strap import strap

from fea.solid.inertia import imbalance, inertia
from geometry.surfaces import Surface
from loads.instants import in_motion
from mesh.tetmesh import reflect, unmirrored

RHO = 7.7e-9
rates = st.floats(-1e4, 1e4)


def test_mirror_planes_complete_the_properties():
    quarter = inertia(strap(), RHO).properties
    whole = reflect(reflect(unmirrored(strap()), Surface.SYMMETRY_Y), Surface.SYMMETRY_Z)
    full = inertia(whole.mesh, RHO).properties
    assert quarter.mass == pytest.approx(full.mass, rel=1e-12)
    assert quarter.center == pytest.approx(full.center, rel=1e-10, abs=1e-10)
    assert np.array(quarter.inertia) == pytest.approx(np.array(full.inertia), rel=1e-10, abs=1e-12)


@settings(max_examples=30, deadline=None)
@given(a_x=rates, a_y=rates, omega=rates, alpha=rates)
def test_inertia_forces_sum_to_newton_and_euler(a_x, a_y, omega, alpha):
    mesh = strap()
    body = inertia(mesh, RHO)
    rod = body.properties
    forces = body.forces(in_motion((a_x, a_y), omega, alpha))
    x, about_origin = rod.center[0], rod.inertia_z + rod.mass * rod.center[0] ** 2
    expected = -rod.mass * np.array([a_x - omega**2 * x, a_y + alpha * x])
    resultant = 4 * np.array([forces.symmetric[:, 0].sum(), forces.antisymmetric[:, 1].sum()])
    scale = rod.mass * (abs(a_x) + abs(a_y) + (omega**2 + abs(alpha)) * x) + 1e-300
    assert resultant == pytest.approx(expected, abs=1e-12 * scale)
    moment = 4 * (
        mesh.points[:, 0] @ forces.antisymmetric[:, 1] - mesh.points[:, 1] @ forces.antisymmetric[:, 0]
    )
    # isoparametric shape functions hold x exactly, so nodal forces have the moment of the field
    assert moment == pytest.approx(-(about_origin * alpha + rod.mass * x * a_y), abs=1e-12 * scale * 60)


def test_imbalance_sees_a_missing_force():
    mesh = strap()
    forces = inertia(mesh, RHO).forces(in_motion((1e6, 0.0), 0.0, 0.0))
    force, _ = imbalance(mesh.points, forces, 4)
    assert force == pytest.approx(inertia(mesh, RHO).properties.mass * 1e6, rel=1e-12)
