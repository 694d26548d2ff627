"""Parts that touch, against solutions that share only the mesh: scikit-fem with penalties, and CalculiX."""

import shutil

import calculix
import numpy as np
import pytest
from direct_contact import DirectContact, Screw, Touching

from fea.solid.recovery import ElementStress
from fea.solid.traction import traction_forces
from fea.solvers.static import displacement
from fea.verify.assembled_body import AssembledBody, bars, parted, pulled
from fea.verify.assembled_body import along_x as measure
from fea.verify.body import STEEL, held
from fea.verify.cases import friction
from fea.verify.cases.assemblies import EDGE, HALF_WIDTH, PRELOAD, SIDES, STIFFNESS, bolted_block
from fea.verify.cases.assemblies import joint as joint_of
from geometry.surfaces import Surface
from mesh.generate import mesh_body
from mesh.tetmesh import numbered, separated

pytestmark = pytest.mark.slow


MODULI = (STEEL.youngs_modulus, STEEL.poissons_ratio)


def along_x(places):
    return np.stack([np.ones_like(places[0]), 0 * places[0], 0 * places[0]])


def corner(mesh, part, *place):
    own = np.unique(mesh.tets[mesh.part == part])
    return own[np.linalg.norm(mesh.points[own] - place, axis=1).argmin()]


def supported(mesh):
    """Degrees of freedom that hold the lower block, and the other one across."""
    fixed = held(mesh, {})
    first, last, half = 0.0, 40.0, HALF_WIDTH
    fixed[corner(mesh, 0, first, -half, 0), :2] = True
    fixed[corner(mesh, 0, first, half, 0), 0] = True
    fixed[corner(mesh, 1, last, -half, 0), 1] = True
    return fixed


@pytest.fixture(scope="module")
def block():
    return bolted_block(5.0)


@pytest.fixture(scope="module")
def unit(block):
    """Nodal forces of the eccentric load of 1 N, and of the half of the bolt that the mesh holds."""
    bolt = block.problem.bolts[0]
    return block._loads[:, 1].reshape(-1, 3), bolt.nodal_forces.reshape(-1, 3) / bolt.share


def test_a_joint_that_opens_from_its_edge_is_that_of_a_penalty(block, unit):
    # The pressures of a penalty of 1e9 MPa/mm are off by about E / (l 1e9) = 5e-6 of the overlap's own scale.
    load, pull = unit
    touching = [Touching("joint", "joint_cap", along_x)]
    screw = Screw(pull, STIFFNESS / 2)
    direct = DirectContact(block.mesh, [MODULI] * 2, touching, supported(block.mesh), screws=[screw])
    tight = direct.solve(0 * load, tension=[PRELOAD / 2])
    for times in (1.5, 2.0):
        other = direct.solve(times * EDGE * load, state=tight, locked=tight)
        state = block.step([0.0, times * EDGE])
        pressure = block.stresses(state)[0]
        assert state.guess.opened.sum() > 3
        assert block.tension(state)[0] == pytest.approx(2 * other.tension[0], rel=1e-5)
        assert np.abs(pressure - other.pressure[0]).max() < 5e-4 * pressure.max()


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_a_joint_that_opens_from_its_edge_is_that_of_calculix(block, unit, tmp_path):
    # Contact there ends within a facet, here at vertices: with elements of 5 mm on a joint of 16 mm that
    # makes 0.6 % of the bolt's force.
    load, pull = unit
    mesh, fixed = block.mesh, supported(block.mesh)
    pairs, half = [calculix.Pair("joint_cap", "joint")], STIFFNESS / 2
    first = calculix.Load(0 * load, (PRELOAD / 2,))
    closed = calculix.solve(tmp_path, mesh, [MODULI] * 2, pairs, fixed, [first], [calculix.Bolt(pull)])
    locked = closed.shortened[0][0]
    second = calculix.Load(1.5 * EDGE * load, (PRELOAD / 2 + half * locked,))
    bolts = [calculix.Bolt(pull, half)]
    opened = calculix.solve(tmp_path, mesh, [MODULI] * 2, pairs, fixed, [second], bolts)
    theirs = PRELOAD / 2 - half * (opened.shortened[0][0] - locked)
    found = block.tension(block.step([0.0, 1.5 * EDGE]))[0]
    assert found == pytest.approx(2 * theirs, rel=1e-2)
    assert found > 1.1 * PRELOAD


def test_without_friction_the_order_of_loads_does_not_matter(block):
    high = 1.8 * EDGE
    straight = block.step([500.0, high])
    around = block.start
    for weights in ([4000.0, 0.0], [0.0, 0.4 * high], [-2000.0, high], [500.0, high]):
        around = block.step(weights, around)
    scale = block.stresses(straight)[0].max()
    assert np.abs(block.stresses(straight)[0] - block.stresses(around)[0]).max() < 1e-9 * scale
    assert block.tension(straight) == pytest.approx(block.tension(around), rel=1e-10)


def test_the_stresses_of_a_pin_in_friction_are_those_of_a_penalty():
    body = friction.pin_in_sheet(14.0)
    mesh = body.mesh
    fixed = held(mesh, {})
    fixed[mesh.facets[Surface.CLAMPED][0, 0], 0] = True

    def inwards(places):
        return -np.stack([places[0], places[1], 0 * places[0]]) / np.hypot(places[0], places[1])

    def around(places):
        return np.stack([-places[1], places[0], 0 * places[0]]) / np.hypot(places[0], places[1])

    def upwards(places):
        return np.stack([0 * places[0], 0 * places[0], np.ones_like(places[0])])

    touching = Touching(
        "shell_seat", "shell_back", inwards, 0.0, friction.FRICTION, (upwards, around), odd=(2, 1)
    )
    moduli = [(m.youngs_modulus, m.poissons_ratio) for m in body.materials]
    direct = DirectContact(mesh, moduli, [touching], fixed, penalty=1e8)
    load = friction.FORCE * body._loads.reshape(-1, 3)
    # Neat fits answer in proportion: one step is as good as many.
    other = direct.solve(load, state=direct.at_rest())
    pressure, *shear = body.stresses(body.step([friction.FORCE]))
    assert np.abs(pressure - other.pressure[0]).max() < 2e-3 * pressure.max()
    assert np.abs(np.stack(shear, axis=1) + other.shear[0]).max() < 2e-3 * pressure.max()


def test_a_joint_tied_by_a_huge_preload_leaves_the_stresses_of_a_solid_block():
    # Bending and shear pass through the joint by pressure and friction. Its stresses are linear over each
    # facet, those of the solid are not: that is felt at the joint, and not at the distance of its width.
    ends, half = (0.0, 30.0, 60.0), HALF_WIDTH
    solid = mesh_body(bars(ends, (-half, half), half), 4.0)
    mesh = numbered(separated(parted(solid, ends[1:-1], measure), {(0, 1): SIDES})[0])[0]
    area, moment = 4 * half * half, 2 * half * (2 * half) ** 3 / 12

    def bent(body):
        def clamped(places, _):
            bending = ends[-1] * places[..., 1] / moment
            return np.stack([bending, np.full_like(bending, -1 / area), 0 * bending], axis=-1)

        def sheared(places, _):
            return np.broadcast_to([0.0, 1 / area, 0.0], places.shape)

        seats = ((Surface.BOLT_THREAD, clamped), (Surface.BOLT_HEAD, sheared))
        return sum(traction_forces(body, surface, stress) for surface, stress in seats)

    joint = joint_of(mesh, friction=True)
    bolt = pulled(mesh, 1e-3, share=0.5)
    preload, force = 1e6, 1e3
    body = AssembledBody(
        mesh, (STEEL, STEEL), [joint], [bolt], bent(mesh)[..., None], friction=0.5, preload=[preload]
    )
    loaded = body.displacement(body.step([force]), [force]) - body.displacement(body.start)
    fixed = held(solid, {})
    for place, axes in (((0, -half, 0), (0, 1)), ((0, half, 0), (0,))):
        fixed[np.linalg.norm(solid.points - place, axis=1).argmin(), axes] = True
    whole = displacement(solid, STEEL, force * bent(solid), fixed)
    stress, exact = body.gauss_stress(loaded), ElementStress(solid)(whole, STEEL)[..., 0]
    middles = solid.points[solid.tets[:, :4], 0].mean(axis=1)
    np.testing.assert_allclose(mesh.points[mesh.tets[:, :4], 0].mean(axis=1), middles)
    far = np.abs(middles - ends[1]) > 2 * half
    assert np.abs(stress - exact)[far].max() < 1e-3 * np.abs(exact).max()
