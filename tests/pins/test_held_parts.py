"""How the big end of a rod with a bolted cap yields, for its oil film."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from assemblies import EVERY, SIMPLE, study
from scipy import sparse
from scipy.sparse.linalg import spsolve

from fea.analysis.pipeline import prepare
from fea.pins import lubrication
from fea.pins.lubrication import Films
from fea.pins.yielding import End, HeldParts, YieldingBore, unit_forces
from fea.solid.parity import Parity
from fea.solid.supports import plane_conditions
from fea.study.film_table import FilmTable
from fea.study.flags import Flags
from fea.study.option_tables import MeshTable
from fea.study.study import load_study
from geometry.errors import InvalidValue
from geometry.surfaces import Surface

pytestmark = [pytest.mark.usefixtures("coarse_bores"), pytest.mark.slow]

ROD = replace(SIMPLE, bushing=0.0, oil_hole=0.0)
BARE = replace(EVERY, bushing_interference_mm=None, shell_thickness_mm=None, shell_interference_mm=None)
SIZE = MeshTable(size_mm=24.0)
# Of moments of gaps, MPa per mm³: what it lets open falls like one over it.
PENALTY = 1e9


def made(mesh=None, **keys):
    return prepare(replace(study(replace(BARE, **keys), rod=ROD), mesh=SIZE), mesh=mesh)


@pytest.fixture(scope="module")
def rod():
    return made()


@pytest.fixture(scope="module")
def parts(rod):
    return rod.assembly_contact.assembly.assembled


@pytest.fixture(scope="module")
def clamped(rod, parts):
    return YieldingBore.of(rod.structure, End.BIG, parts)


def kept(bore):
    """Functions that are no rigid translation: of one piece and in parts, other nodes stop these."""
    return np.setdiff1d(np.arange(bore.functions.count), bore.functions.translations)


def loaded(rod, bore):
    """Weights (n, n_functions) of the whole displacement, of cosines that balance what else acts."""
    instants = rod.crank_cycle(6000.0).at(np.linspace(0.0, 4 * np.pi, 9)[:-1])
    pressed = np.zeros((len(instants), bore.functions.count))
    # ∫ φ cos φ dA of the translations is the square root of ∫ cos² φ dA.
    resultant = np.sqrt(np.pi * bore.functions.radius * bore.functions.width)
    pressed[:, bore.functions.translations] = End.BIG.force(instants).T / resultant
    return (pressed @ bore.compliance.T + bore.caused(instants))[:, kept(bore)]


@pytest.fixture(scope="module")
def whole():
    own = replace(load_study(), rod=replace(load_study().rod, dimensions=ROD), mesh=SIZE)
    return prepare(Flags(pressure="bonded").applied(own))


def test_a_clamped_big_end_yields_as_one_of_one_piece(rod, whole, clamped):
    """Linear stresses tie the joint's quadratic facets a little more loosely, and the bolts tie it, too."""
    one = whole.films.bore
    some = np.ix_(kept(one), kept(one))
    difference = (clamped.compliance - one.compliance)[some]
    assert np.linalg.norm(difference) < 0.02 * np.linalg.norm(one.compliance[some])
    assert np.abs(loaded(rod, clamped) - loaded(whole, one)).max() < 0.03 * np.abs(loaded(whole, one)).max()


def test_its_film_is_that_of_a_rod_of_one_piece(rod, whole, clamped, monkeypatch):
    monkeypatch.setattr(lubrication, "COARSE", (16, 4, 36))
    found = []
    for each, bore in ((rod, clamped), (whole, whole.films.bore)):
        films = Films(replace(each.structure, film=FilmTable(viscosity_mPas=8.0)))
        films.__dict__["bore"] = bore
        found.append(films.coarse(each.crank_cycle(3000.0)))
    parts, one = found
    assert parts.thinnest.min() == pytest.approx(one.thinnest.min(), rel=0.02)
    assert parts.highest == pytest.approx(one.highest, abs=0.03 * one.highest.max())


def test_a_patch_of_pressure_moves_the_bore_as_in_a_direct_solution(rod, parts, clamped):
    """Both sides of the joint tied and bolts as springs, by penalties on the whole stiffness at once."""
    functions, mesh, problem = clamped.functions, rod.mesh.cell, parts.problem
    facets = End.BIG.facets(rod.structure)
    even, _ = unit_forces(functions, facets, len(mesh.points))
    patch = np.exp(-(((facets.angle - 2.0) / 0.3) ** 2))  # and its image across y = 0
    at, _ = functions.at(facets.angle, facets.corners[..., 2] @ facets.shape_values.T)
    weights = facets.images * np.einsum("ifq,fq,fq->i", at, patch, facets.areas)
    along = even[..., 0].sum(axis=1)
    (moved,) = functions.translations[functions.translations < len(even)]
    weights[moved] -= weights @ along / along[moved]  # balanced
    forces = np.tensordot(weights, even, axes=1).ravel()
    stiff = np.full(problem.forces.shape[1], PENALTY)
    stiff[problem.starts[len(problem.bores) + len(problem.faces)] :] = [
        bolt.stiffness / bolt.share if number < problem.pulls else 0.0  # they do not bear on their holes
        for number, bolt in enumerate(problem.bolts)
    ]
    stiff[: problem.starts[len(problem.bores)]] = 0.0  # no pins
    K = rod.model.stiffness.full() + problem.forces @ sparse.diags_array(stiff) @ problem.forces.T
    free = ~plane_conditions(mesh, Parity.SYMMETRIC).ravel()
    free[3 * np.flatnonzero(free[::3])[0]] = False  # it slides along x
    u = np.zeros(len(forces))
    u[free] = spsolve(sparse.csc_array(K)[free][:, free], forces[free])
    direct = facets.images * even.reshape(len(even), -1) @ u
    found = clamped.compliance[: len(even), : len(even)] @ weights
    same = np.setdiff1d(np.arange(len(even)), moved)
    assert found[same] == pytest.approx(direct[same], abs=1e-4 * np.abs(direct[same]).max())


def test_a_joint_that_is_open_lets_the_bore_yield_more(rod, parts, clamped):
    """As at the largest tension: what is open there moves freely, and has lost its clamping stress."""
    cases = rod.loading.at(rod.mass, 6000.0).cases
    (tension,) = (case for case in cases if case.name == "tension")
    (state,) = rod.pins.states(tension[None])
    assert state.guess.opened.any()
    open_joint = clamped.with_joint(state)
    softer = (open_joint.compliance - clamped.compliance)[np.ix_(kept(clamped), kept(clamped))]
    values = np.linalg.eigvalsh(softer)
    assert values[0] > -1e-3 * values[-1]
    assert np.trace(softer) > 0.01 * np.trace(clamped.compliance)
    assert np.abs(clamped.relief).max() < 1e-9 < np.abs(open_joint.relief).max()


def test_a_warm_rod_widens_with_its_pin(rod):
    """Of one metal, bore and pin grow by α ΔT of their radii: what remains is that of the clearance."""
    warm = made(rod.mesh, temperature_C=120.0)
    parts = warm.assembly_contact.assembly.assembled
    _, growth = parts.warming.pins
    bore = YieldingBore.of(warm.structure, End.BIG, parts)
    pin = bore.functions.radius - warm.pins.fits.big_clearance
    wider = growth / pin * warm.pins.fits.big_clearance
    assert bore.relief == pytest.approx(
        wider * bore.functions.widening, rel=0.01, abs=1e-3 * bore.relief.max()
    )


def test_a_joint_without_friction_holds_no_cap(parts):
    class Sliding:
        """A motion of the cap that nothing but the pin resists."""

        problem, system = parts.problem, SimpleNamespace(pin_held=np.ones((1, 3)))

    with pytest.raises(InvalidValue, match=r"joint_friction = 0: leaves a part that nothing but the pins"):
        HeldParts.under(Sliding, {}, {})


@pytest.fixture(scope="module")
def on_film(rod):
    """The same rod, whose stress comes from the film of its big end."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lubrication, "FINE", (24, 4, 48))
        patch.setattr(lubrication, "COARSE", (16, 4, 36))
        loaded_by = Flags(pressure="oil-film").applied(replace(rod.study, film=FilmTable(viscosity_mPas=8.0)))
        film = prepare(loaded_by, mesh=rod.mesh)
        _ = film.films.at(film.crank_cycle(6000.0))
        yield film


def test_film_loads_the_parts_while_the_joint_is_closed(rod, on_film):
    """The joint opens under tension alone, where the pin presses as under contact."""
    cycle = on_film.crank_cycle(6000.0)
    cases = {case.name: case for case in on_film.loading.at(on_film.mass, 6000.0).cases}
    assert list(on_film.films.openings(cycle)) == ["tension"]
    for name, case in cases.items():
        (under_film,), (touched,) = (each.pins.respond(case[None]) for each in (on_film, rod))
        films, contacts = (
            each.pressure[Surface.BIG_END_BORE].symmetric.max() for each in (under_film, touched)
        )
        total = under_film.forces.symmetric.sum(axis=0)[0]
        assert abs(total) < 1e-6 * touched.largest
        assert (films == pytest.approx(contacts, rel=1e-6)) == (name in ("tension", "gas"))
        clamp, clamped = (each.assembly.joint.force for each in (under_film, touched))
        assert clamp == pytest.approx(clamped, rel=0.06)


def test_its_bore_follows_the_joint(on_film):
    """A film that held it closed all the time would be thinner than the joint's bending allows."""
    cycle = on_film.crank_cycle(6000.0)
    _, coarse, _ = on_film.films.at(cycle)
    assert coarse.acting.compliance.shape == (36, *on_film.films.bore.compliance.shape)
    softness = np.trace(coarse.acting.compliance, axis1=1, axis2=2)
    softer = softness > 1.05 * np.trace(on_film.films.bore.compliance)
    assert 0 < softer.sum() < 12
    assert softness.argmax() in (0, 1, 35)  # about the top dead centre of gas exchange
    assert abs(coarse.driven / coarse.dissipated - 1) < 0.02


def test_superposed_film_is_that_of_a_direct_solution(on_film):
    cycle = on_film.crank_cycle(6000.0)
    instants = cycle.at(np.radians([0.0, 60.0, 370.0, 480.0]))
    loads = on_film.pins.span([cycle])
    weights = loads.weights(instants, cycle)
    even, odd = loads.fields()
    for number, found in enumerate(on_film.pins.respond(instants, cycle)):
        for fields, own, parity in ((even, weights.even, 0), (odd, weights.odd, 1)):
            every = slice(0, fields.count)
            forces = np.tensordot(own[:, number], np.stack(fields.forces(every)), axes=1)
            traction = fields.traction(every)[Surface.BIG_END_BORE] @ own[:, number]
            direct = found.forces, found.traction[Surface.BIG_END_BORE]
            for summed, split in zip((forces, traction), direct, strict=True):
                one = (split.symmetric, split.antisymmetric)[parity]
                assert summed == pytest.approx(one, abs=5e-3 * np.abs(split.symmetric).max())
