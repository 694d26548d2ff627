"""Plastic flow against closed forms of a hollow sphere, and against the same body without a mirror plane."""

from dataclasses import replace

import numpy as np
import pytest

from fea.plastic import cycling
from fea.plastic.cycling import YIELD_TOLERANCE, PlasticAnswer, cycled
from fea.plastic.increment import BALANCED, ElasticBody, NoEquilibriumError, at_rest, increment, nodal_force
from fea.plastic.zone import Zone, equivalent_strain
from fea.solid.assembly import gauss_places, pattern, shape_functions, stiffness
from fea.solid.parity import Parity
from fea.solid.supports import plane_conditions
from fea.solid.traction import traction_forces
from fea.solvers.direct import factorise
from fea.verify.body import STEEL, held, rectangle, uniform
from fea.verify.cases.plasticity import BALL, CAVITY, SPHERE_LIMIT, YIELD, FlowingSphere
from geometry.bodies import Prism
from geometry.surfaces import Surface
from mesh.generate import mesh_body
from mesh.tetmesh import reflect, unmirrored

#: Twice the pressure at first yield: b/a = 2 (Hill 1950, chapter V; Melan 1938).
SHAKEDOWN = 4 / 3 * YIELD * (1 - (CAVITY / BALL) ** 3)


@pytest.fixture(scope="module")
def sphere():
    return FlowingSphere(4.0)


def carries(sphere, pressure):
    state = at_rest(sphere.zone, 1)
    try:
        for share in (0.5, 0.7, 0.85, 1.0):
            state = increment(sphere.zone, sphere.body, share * pressure * sphere.unit, state)
    except NoEquilibriumError:
        return False
    return True


@pytest.mark.parametrize("size", [6.0, 4.0])
def test_a_sphere_carries_its_limit_load_and_no_more(size):
    sphere = FlowingSphere(size)
    assert carries(sphere, 0.95 * SPHERE_LIMIT)
    assert not carries(sphere, 1.02 * SPHERE_LIMIT)


@pytest.mark.parametrize(
    ("share", "answer"),
    [
        (0.4, PlasticAnswer.ELASTIC),
        (0.95, PlasticAnswer.SHAKES_DOWN),
        (1.12, PlasticAnswer.CYCLIC),  # Gauss points lie inside, where stress is 5 % less
        (1.25, PlasticAnswer.COLLAPSES),
    ],
)
def test_a_pulsating_pressure(sphere, share, answer):
    loads = [share * SHAKEDOWN * sphere.unit, 0 * sphere.unit]
    assert cycled(sphere.zone, sphere.body, loads).answer is answer


def test_what_flows_is_in_equilibrium_at_yield_and_dissipates(sphere):
    zone, load = sphere.zone, 1.0 * YIELD * sphere.unit
    flow = cycled(zone, sphere.body, [load, 0 * load])
    assert flow.answer is PlasticAnswer.SHAKES_DOWN
    assert flow.turns == 1
    assert flow.cases == (0,)
    assert flow.unbalanced <= BALANCED
    assert flow.least_dissipation >= 0
    assert flow.beyond_yield <= YIELD_TOLERANCE
    state = flow.state
    assert zone.usage(state.moved, state.plastic).max() < 1
    # Plastic strain keeps the volume.
    assert np.abs(state.plastic[..., :3].sum(axis=-1)).max() < 1e-12
    assert flow.strain.max() > 1e-3


def test_both_halves_of_a_cell_flow_as_in_the_whole_body():
    sides = (Surface.SYMMETRY_Y, Surface.LOADED, Surface.FREE, Surface.CLAMPED)
    cell = mesh_body(Prism(rectangle((0.0, 12.0), (0.0, 2.0), sides), (0.0, 2.0)), 2.5)
    whole = reflect(unmirrored(cell), Surface.SYMMETRY_Y)

    def pulled_and_bent(mesh):
        return [
            traction_forces(mesh, Surface.LOADED, uniform(*load)) for load in ((300.0, 0, 0), (0, 15.0, 0))
        ]

    def solver(mesh, parity=None):
        fixed = np.zeros(mesh.points.shape, dtype=bool)
        fixed[mesh.facets[Surface.CLAMPED]] = True
        fixed = fixed.ravel() if parity is None else fixed.ravel() | plane_conditions(mesh, parity).ravel()
        fixed |= np.isin(np.arange(fixed.size), 3 * np.unique(mesh.facets[Surface.SYMMETRY_Z]) + 2)
        K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
        return fixed, factorise(K.constrained(fixed))

    def strain(mesh, halves, solvers, loads):
        every = np.tile(np.arange(len(mesh.tets)), halves)
        half = np.repeat(np.arange(halves), len(mesh.tets))
        zone = Zone.of(mesh, STEEL, half, every, np.full(len(every), YIELD))
        body = ElasticBody(zone, solvers)
        state = at_rest(zone, halves)
        for share in (0.7, 1.0):
            state = increment(zone, body, share * body(loads), state)
        return equivalent_strain(state.plastic)

    pull, bend = pulled_and_bent(cell)
    by_halves = strain(
        cell, 2, {parity: solver(cell, parity) for parity in Parity}, np.stack([pull + bend, pull - bend])
    )
    # The bending load is odd: along +y on both halves, which is −y of the second one mirrored to the cell.
    pull, bend = pulled_and_bent(whole.mesh)
    in_whole = strain(whole.mesh, 1, {Parity.SYMMETRIC: solver(whole.mesh)}, (pull + bend)[None])
    assert by_halves.max() > 1e-4
    assert np.abs(by_halves[: len(cell.tets)] - by_halves[len(cell.tets) :]).max() > 1e-4
    assert by_halves.max(axis=1) == pytest.approx(in_whole.max(axis=1), abs=2 * BALANCED * by_halves.max())


def test_the_volumetric_strain_is_projected_to_continuous_linear_fields(sphere):
    zone, x = sphere.zone, sphere.mesh.points[:, 0]
    values, _ = shape_functions(4, gauss_places(10).T)
    linear = 3 + 2 * (values @ x[sphere.mesh.tets[:, :4]][..., None])[..., 0]
    assert zone.smooth(linear) == pytest.approx(linear)
    # What it takes away has no part in any such field, and what is left is not changed again.
    field = np.random.default_rng(61).normal(0, 1, zone.volumes.shape)
    kept = zone.smooth(field)
    assert zone.smooth(kept) == pytest.approx(kept, abs=1e-9)
    assert (zone.volumes * (field - kept) * linear).sum() == pytest.approx(0, abs=1e-6)
    assert np.abs(field - kept).max() > 0.1


def test_both_halves_have_one_field_across_the_plane_between_them():
    sides = (Surface.SYMMETRY_Y, Surface.LOADED, Surface.FREE, Surface.CLAMPED)
    cell = mesh_body(Prism(rectangle((0.0, 4.0), (0.0, 2.0), sides), (0.0, 2.0)), 2.0)
    every, count = np.tile(np.arange(len(cell.tets)), 2), len(cell.tets)
    zone = Zone.of(cell, STEEL, np.repeat([0, 1], count), every, np.full(2 * count, YIELD))
    on_plane = np.isin(cell.tets[:, :4], cell.facets[Surface.SYMMETRY_Y])
    shared = zone.vertices[:count] == zone.vertices[count:]
    assert (shared == on_plane).all()
    assert on_plane.any()


def test_tolerance_of_balance_belongs_to_each_node(sphere):
    # Where elements are eight times smaller, so are forces, by the square: their balance counts as much.
    near, far = np.linalg.norm(sphere.mesh.points, axis=1).argsort()[[0, -1]]
    scale = nodal_force(sphere.zone)[:, 0]
    assert scale[near] < 0.5 * scale[far]


def test_the_forces_on_the_elastic_body_are_those_of_the_stress(sphere):
    # ∫ ∇N · σ dV of the stress with its projection is K u less the forces that stand for plastic strain.
    zone, mesh = sphere.zone, sphere.mesh
    u = np.random.default_rng(62).normal(0, 1e-3, (1, *mesh.points.shape))
    plastic = np.random.default_rng(63).normal(0, 1e-3, (*zone.volumes.shape, 6))
    plastic[..., :3] -= plastic[..., :3].mean(axis=-1, keepdims=True)
    K = stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points)))
    wanted = zone.forces(zone.stress(0 * u, u, plastic), 1)
    found = (K @ u.ravel()).reshape(u.shape) - zone.initial_forces(zone.strain(u)[1], plastic, 1)
    assert found == pytest.approx(wanted, abs=1e-9 * np.abs(wanted).max())


def test_a_material_that_is_too_strong_never_flows(sphere):
    zone = replace(sphere.zone, strength=1e3 * sphere.zone.strength)
    assert cycled(zone, sphere.body, [YIELD * sphere.unit]).answer is PlasticAnswer.ELASTIC


def test_combinations_of_known_forces_are_not_solved_for_again(sphere):
    zone, mesh, solved = sphere.zone, sphere.mesh, list[int]()
    fixed = held(mesh, {}).ravel()
    solve = factorise(stiffness(mesh, STEEL, pattern(mesh.tets, len(mesh.points))).constrained(fixed))

    def counted(sides):
        solved.append(sides.shape[1])
        return solve(sides)

    body = ElasticBody(zone, {Parity.SYMMETRIC: (fixed, counted)})
    one, other = np.random.default_rng(64).normal(0, 1, (2, 1, len(zone.nodes), 3))
    for forces in (one, other, 2 * one - 3 * other):
        near, moved = body.near(forces, 1e-9)
        assert near == pytest.approx(forces, abs=1e-6)
        assert moved == pytest.approx(sphere.body(forces), rel=1e-6, abs=1e-12)
    assert len(solved) == 2
    # What is left out of forces is left out of those that are returned, too.
    unknown = one + 1e-3 * np.random.default_rng(65).normal(0, 1, one.shape)
    near, moved = body.near(unknown, 1.0)
    assert len(solved) == 2
    assert moved == pytest.approx(sphere.body(near), rel=1e-6, abs=1e-12)


def test_an_increment_begins_where_least_is_out_of_balance(sphere):
    load, rest = 1.0 * YIELD * sphere.unit, at_rest(sphere.zone, 1)
    found, steps = increment(sphere.zone, sphere.body, load, rest), sphere.body.steps
    again = increment(sphere.zone, sphere.body, load, rest, [rest, found])
    assert sphere.body.steps == steps
    assert again.plastic == pytest.approx(found.plastic, abs=1e-15)


def test_flow_that_never_fades_is_named_after_fewer_turns(sphere):
    loads = [1.12 * SHAKEDOWN * sphere.unit, 0 * sphere.unit]
    long, short = (cycled(sphere.zone, sphere.body, loads, endless=endless) for endless in (False, True))
    assert (long.answer, short.answer) == (PlasticAnswer.CYCLIC, PlasticAnswer.CYCLIC)
    assert short.turns < 4 <= long.turns
    # What flows in a turn still changes by less than the share that counts as reversed.
    assert short.per_turn == pytest.approx(long.per_turn, rel=0.05)


def test_what_takes_too_many_steps_is_undecided(sphere, monkeypatch):
    monkeypatch.setattr(cycling, "_MOST_STEPS", 0)
    loads = [1.12 * SHAKEDOWN * sphere.unit, 0 * sphere.unit]
    found = cycled(sphere.zone, sphere.body, loads)
    assert (found.answer, found.turns) == (PlasticAnswer.UNDECIDED, 1)
