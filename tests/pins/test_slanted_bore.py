"""A small end whose crown is narrower than its shank side: the pressure alone would leave a cross force."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cycles import superposition_errors
from studies import plain_study

from fea.analysis.pipeline import prepare
from fea.base.choices import Symmetry
from fea.pins.lubrication import Hole
from fea.pins.prescribed import SKEWED, _skewness
from fea.pins.yielding import End, unit_forces
from fea.study.flags import Flags


def slanted_rod(**holes):
    study = Flags(size=12.0, symmetry=Symmetry.QUARTER, cycle=True).applied(plain_study())
    crown = 0.6 * study.rod.dimensions.small_end_width
    rod = replace(study.rod.dimensions, small_end_crown_width=crown, **holes)
    return prepare(replace(study, rod=replace(study.rod, dimensions=rod)))


@pytest.fixture(scope="module")
def slanted():
    return slanted_rod()


@pytest.fixture(scope="module")
def drilled():
    return slanted_rod(oil_hole=5.0, oil_gallery=3.0)


def test_superposed_stress_is_the_directly_solved_one(slanted):
    # Without the harmonics of s(ψ) sin ψ: 2 % on the bores and 2 % elsewhere.
    angles = np.random.default_rng(3).uniform(0, 4 * math.pi, 12)
    on_bore, elsewhere = superposition_errors(slanted, 9000.0, angles)
    assert on_bore < 2e-3
    assert elsewhere < 2e-4


def test_only_the_bore_that_needs_them_has_more_harmonics(slanted):
    small, big = slanted.cycle.loads.bores
    assert set(big.orders) < set(small.orders)
    assert len(small.orders) - len(big.orders) == 3


def test_skewness_is_that_of_a_width_that_differs_around_the_bore(slanted):
    # Width w + t cos φ, force in the direction α: ∫ s (1 + (b/a) sin ψ) sin ψ (w + t cos(ψ + α)) dψ = 0 with
    # s = cos ψ, ∫ s sin² ψ = 2/3 and ∫ s sin² ψ cos ψ = π/8.
    small, big = slanted.cycle.loads.bores
    width, taper = slanted.mesh.bores.small_width, slanted.mesh.bores.small_taper
    alpha = np.linspace(0, math.pi, 1001)
    across = taper * np.sin(alpha) * 2 / 3 / (width * 2 / 3 + taper * np.cos(alpha) * math.pi / 8)
    assert _skewness(small.bore.facets, small.arcs[0]) == pytest.approx(np.abs(across).max(), rel=0.03)
    assert _skewness(big.bore.facets, big.arcs[0]) < SKEWED


@pytest.mark.parametrize("end", End)
def test_a_film_fits_displacements_to_what_slant_and_holes_leave_of_a_bore(drilled, end):
    """Moved by 1 mm along x, it has the weight of cos φ only; widened by P₂ over its width, that of P₂."""
    structure, small = drilled.structure, end is End.SMALL
    functions, bores = end.functions(structure), structure.bores
    facets, points = end.facets(structure), structure.mesh.points - [small * bores.rod_length, 0, 0]
    even, _ = unit_forces(functions, facets, len(points))
    angle = np.arctan2(points[:, 1], points[:, 0])
    width = functions.width + small * bores.small_taper * np.cos(angle)
    wider = 1.5 * (2 * points[:, 2] / width) ** 2 - 0.5
    (second,) = np.flatnonzero((functions.terms == [0, 2]).all(axis=1))
    for number, moved in (
        (functions.translations[0], [1, 0, 0] * np.ones_like(points)),
        (second, np.stack([wider * np.cos(angle), wider * np.sin(angle), 0 * angle], axis=-1)),
    ):
        weights = np.eye(len(even))[number] / functions.scales[number]
        found = facets.images * np.tensordot(even, moved, axes=2)
        assert found == pytest.approx(weights, abs=0.02 * weights.max())


def test_holes_of_the_bores_are_holes_of_their_films(drilled):
    big, small = (films.lubrication.holes for films in (drilled.films, drilled.small_end_films))
    assert big == (Hole(0.0, 3.0),)
    assert small == (Hole(0.0, 5.0), Hole(math.pi, 3.0, 0.4))
