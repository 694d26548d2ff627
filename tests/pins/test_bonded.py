"""The load of a bonded pin: exact resultants, the cycle, scikit-fem's own assembly, whole runs."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from skfem import Functional, LinearForm, condense, solve
from skfem.models.elasticity import lame_parameters, linear_elasticity
from strap import BIG_BORE, LENGTH, SMALL_BORE, WIDTH, strap
from studies import plain_study

from fea.analysis.pipeline import prepare, solve_speed
from fea.apps.result import analyse
from fea.base.choices import Element, Support, Symmetry
from fea.pins.bonded import BondedBore, BondedPins
from fea.rod.meshed_rod import Bores
from fea.solid.bore import bore_facets
from fea.solid.inertia import imbalance, inertia
from fea.solid.scikit_fem import basis
from fea.study.flags import Flags
from fea.study.study import load_study
from geometry.surfaces import Surface
from loads.instants import in_motion
from mesh.tetmesh import reflect, unmirrored

BORES = Bores(LENGTH, BIG_BORE, WIDTH, SMALL_BORE, WIDTH)


def slanted(mesh):
    """The mesh with a small end that is wider towards the shank: its bore's centroid is off the axis."""
    points = mesh.points.copy()
    points[:, 2] *= 1 - 0.3 * np.clip((points[:, 0] - LENGTH) / SMALL_BORE, -1, 1)
    return dataclasses.replace(mesh, points=points)


def lopsided(mesh):
    """The mesh with bores whose centroids are off the plane y = 0 too."""
    points = mesh.points.copy()
    points[:, 2] *= 1 + 0.2 * np.clip(points[:, 1] / SMALL_BORE, -1, 1)
    return dataclasses.replace(mesh, points=points)


QUARTER = strap()
HALF = reflect(unmirrored(QUARTER), Surface.SYMMETRY_Y).mesh
WHOLE = reflect(unmirrored(HALF), Surface.SYMMETRY_Z).mesh
CELLS = {
    "quarter": QUARTER,
    "half": HALF,
    "whole": WHOLE,
    "slanted": slanted(QUARTER),
    "lopsided": lopsided(slanted(HALF)),
}


def bond(mesh):
    return BondedBore.of(bore_facets(mesh, Surface.SMALL_END_BORE, LENGTH), len(mesh.points))


def images(mesh):
    return 2 ** sum(plane in mesh.facets for plane in (Surface.SYMMETRY_Y, Surface.SYMMETRY_Z))


@settings(max_examples=40, deadline=None)
@given(
    cell=st.sampled_from(sorted(CELLS)), direction=st.floats(-np.pi, np.pi), magnitude=st.floats(1e-3, 1e6)
)
def test_the_resultant_is_the_force_and_passes_through_the_axis(cell, direction, magnitude):
    mesh = CELLS[cell]
    force = magnitude * np.array([np.cos(direction), np.sin(direction)])
    load = bond(mesh).load(tuple(force), 1.0)
    even = load.forces.symmetric
    odd = even if load.forces.antisymmetric is None else load.forces.antisymmetric
    resultant = images(mesh) * np.array([even[:, 0].sum(), odd[:, 1].sum()])
    assert resultant == pytest.approx(force, abs=1e-12 * magnitude)
    x, y = mesh.points[:, 0] - LENGTH, mesh.points[:, 1]
    moment = images(mesh) * (x @ odd[:, 1] - y @ odd[:, 0])
    assert abs(moment) < 1e-12 * magnitude * LENGTH


@pytest.mark.parametrize("cell", ["quarter", "whole"])
def test_on_a_plain_bore_the_traction_is_uniform(cell):
    mesh = CELLS[cell]
    load = bond(mesh).load((300.0, -400.0), 2 * np.pi * SMALL_BORE * WIDTH)
    parts = [load.traction.symmetric, load.traction.antisymmetric]
    traction = sum(part for part in parts if part is not None)[mesh.facets[Surface.SMALL_END_BORE]]
    mean = 500 / (2 * np.pi * SMALL_BORE * WIDTH)
    assert load.scale == pytest.approx(1, abs=2e-3)
    assert traction[..., 0] == pytest.approx(0.6 * mean, rel=2e-3)
    assert traction[..., 1] == pytest.approx(-0.8 * mean, rel=2e-3)
    assert not traction[..., 2].any()


@pytest.mark.parametrize("cell", sorted(CELLS))
@pytest.mark.parametrize("support", list(Support))
def test_the_unit_loads_of_a_cycle_span_every_instant(cell, support):
    mesh = CELLS[cell]
    body = inertia(mesh, 7.7e-9)
    pin, crank = np.array([3000.0, -500.0]), np.array([-2500.0, 800.0])
    case = dataclasses.replace(in_motion((-2e6, 1e6), 300.0, 3e4), pin=pin, crank=crank)
    pins = BondedPins(mesh, BORES, body, support)
    (direct,), loads = pins.respond(case[None]), pins.span([])
    weights = loads.weights(case[None])
    parts = [
        np.tensordot(weight[:, 0], fields.forces(slice(None)), axes=1)
        for weight, fields in zip(weights, loads.fields(), strict=True)
    ]
    if direct.forces.antisymmetric is None:
        parts = [parts[0] + parts[1]]
    exact = [part for part in (direct.forces.symmetric, direct.forces.antisymmetric) if part is not None]
    for found, part in zip(parts, exact, strict=True):
        assert np.abs(found - part).max() <= 1e-12 * np.abs(part).max()


def test_displacements_are_those_of_scikit_fem():
    """A clamped rod under a tilted force on its pin bore, assembled and solved by scikit-fem as a whole."""
    flags = Flags(size=24.0, element=Element.P1, pressure="bonded", symmetry=Symmetry.QUARTER)
    rod = prepare(flags.applied(load_study("leon-2001-as-published")))
    found = rod.equilibrium(rod.loading.at(rod.mass, None).cases)
    ours = rod.fields.displacement(found.solution)[..., 0]
    mesh, force, steel = rod.mesh.whole, (-45914.89, 10321.14), rod.materials[0]
    cells = basis(mesh)
    bore = cells.boundary("small_end_bore")
    area = Functional(lambda w: 1 + 0 * w.x[0]).assemble(bore)
    x, y = (Functional(lambda w, k=k: w.x[k]).assemble(bore) / area for k in (0, 1))
    polar = Functional(lambda w: (w.x[0] - x) ** 2 + (w.x[1] - y) ** 2).assemble(bore)
    # On a faceted bore the centroid is a little off the axis.
    turn = -((x - rod.mesh.bores.rod_length) * force[1] - y * force[0]) / polar

    def work(v, w):
        along = force[0] / area - turn * (w.x[1] - y), force[1] / area + turn * (w.x[0] - x)
        return along[0] * v[0] + along[1] * v[1]

    f = LinearForm(work).assemble(bore)
    lame = lame_parameters(steel.youngs_modulus, steel.poissons_ratio)
    K = linear_elasticity(*lame).assemble(cells)
    held = cells.get_dofs("big_end_bore").all()
    theirs = solve(*condense(K, f, D=held)).reshape(-1, 3)
    assert np.abs(ours - theirs).max() < 1e-8 * np.abs(theirs).max()


@pytest.fixture(scope="module")
def cycled():
    return analyse(plain_study(), size=20, pressure="bonded", cycle=True)


def test_a_whole_cycle_can_be_trusted(cycled):
    assert cycled.trusted
    assert cycled.summary.model.pressure == "bonded"
    assert cycled.summary.envelope.unit_solutions == 8
    # Exact: no series, as the load has the same shape at every instant. Single precision of the stresses.
    assert cycled.checks["superposition"].value < 1e-6


def test_the_solved_part_makes_no_difference():
    study = load_study("leon-2001-as-published")
    flags = [
        Flags(size=24.0, element=Element.P1, pressure="bonded", symmetry=part)
        for part in (Symmetry.QUARTER, Symmetry.NONE)
    ]
    found = [solve_speed(prepare(each.applied(study)), None) for each in flags]
    one, other = (result.cases["given"].von_mises.max() for result in found)
    assert other == pytest.approx(one, rel=1e-6)


def test_a_rod_in_motion_is_in_balance_without_symmetry():
    mesh = CELLS["lopsided"]
    body = inertia(mesh, 7.7e-9)
    rod, accelerated = body.properties, 1e6
    pull = rod.mass * accelerated
    case = dataclasses.replace(in_motion((accelerated, 0.0)), crank=np.array([pull, 0.0]))
    (response,) = BondedPins(mesh, BORES, body, Support.INERTIA_RELIEF).respond(case[None])
    force, _ = imbalance(mesh.points, response.forces, images(mesh))
    assert force < 1e-10 * pull
