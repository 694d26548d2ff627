"""Bores found on meshes of rods whose dimensions are known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from tet_blocks import deck

from fea.analysis.meshing import mesh_study
from fea.base.choices import Element, Symmetry
from fea.study.flags import Flags
from fea.study.study import load_study
from geometry.imports import RodFile
from geometry.surfaces import Surface
from mesh.creases import SurfaceMesh
from mesh.files.bore_pair import find_bore_pair
from mesh.files.given import given_mesh
from mesh.files.tets import TetFile
from mesh.tetmesh import MeshError, TetMesh, boundary_facets

BORES = (Surface.BIG_END_BORE, Surface.SMALL_END_BORE)


def meshed(element="p1", size=16.0, **dimensions):
    study = load_study("leon-2001").with_rod(shank_section="rectangular", **dimensions)
    flags = Flags(size=size, element=Element(element), symmetry=Symmetry.NONE)
    return mesh_study(flags.applied(study))


@pytest.fixture(scope="module")
def coarse():
    bolts = {"cap_bolt_mm": 8.0, "cap_bolt_spacing_mm": 72.0, "cap_boss_length_mm": 40.0}
    return meshed(oil_hole_mm=3.0, cap_boss_fillet_mm=4.0, **bolts)


@pytest.fixture(scope="module")
def curved():
    return meshed("p2", size=16.0)


def skin(mesh):
    return SurfaceMesh(mesh.points, boundary_facets(mesh.tets)[:, :3])


def pair_of(mesh, *named):
    return find_bore_pair(skin(mesh), named or (None, None))


@settings(max_examples=3)
@given(st.integers(0, 10_000), st.floats(0.5, 3.0))
def test_bores_are_found_wherever_the_rod_lies_and_however_large_it_is(coarse, seed, scale):
    turn = Rotation.random(random_state=np.random.default_rng(seed))
    moved = replace(coarse.whole, points=scale * turn.apply(coarse.whole.points) + [200.0, -30.0, 5.0])
    pair = pair_of(moved)
    sizes = coarse.bores.big_radius, coarse.bores.small_radius
    assert [bore.radius / scale for bore in pair] == pytest.approx(sizes, rel=1e-5)
    assert pair[0].apart(pair[1]) / scale == pytest.approx(coarse.bores.rod_length, rel=1e-5)
    for bore, surface in zip(pair, BORES, strict=True):
        facets = boundary_facets(coarse.whole.tets)[bore.facets]
        known = {tuple(sorted(facet)) for facet in coarse.whole.facets[surface][:, :3].tolist()}
        assert {tuple(sorted(facet)) for facet in facets[:, :3].tolist()} == known


def test_a_mesh_from_a_file_stands_in_the_rod_frame_with_its_bores_named(curved, tmp_path):
    turn = Rotation.from_rotvec([0.4, -1.1, 2.0])
    whole = curved.whole
    file = TetFile(
        turn.apply(whole.points) + np.array([7.0, 8.0, 9.0]), whole.tets, np.arange(1, len(whole.tets) + 1)
    )
    (tmp_path / "rod.inp").write_text(deck(file))
    found = given_mesh(RodFile(tmp_path / "rod.inp"))
    big, small = found.bores
    bores = curved.bores
    assert (big.radius, small.radius, small.x) == pytest.approx(
        (bores.big_radius, bores.small_radius, bores.rod_length), rel=1e-9
    )
    assert (big.width, small.width) == pytest.approx((bores.big_width, bores.small_width), rel=1e-9)
    # The frame is the rod's own but for a turn about x, which the file cannot tell.
    np.testing.assert_allclose(np.abs(found.mesh.points), np.abs(whole.points), atol=1e-9)
    for surface in BORES:
        places = found.mesh.points[found.mesh.facets[surface][:, 3:]]
        center = 0.0 if surface is BORES[0] else bores.rod_length
        radius = bores.big_radius if surface is BORES[0] else bores.small_radius
        np.testing.assert_allclose(np.hypot(places[..., 0] - center, places[..., 1]), radius, rtol=2e-3)
    assert sum(map(len, found.mesh.facets.values())) == len(boundary_facets(whole.tets))


@pytest.mark.parametrize(
    ("scale", "unit", "said"),
    [(1e-3, None, "m"), (1e-3, "m", ""), (1 / 25.4, None, "in"), (1 / 25.4, "in", "")],
)
def test_the_unit_is_recognised_by_the_length_of_the_rod_or_given(coarse, tmp_path, scale, unit, said):
    whole = coarse.whole
    (tmp_path / "rod.inp").write_text(
        deck(TetFile(scale * whole.points, whole.tets, np.arange(len(whole.tets))))
    )
    found = given_mesh(RodFile(tmp_path / "rod.inp", unit=unit))
    assert found.bores[1].x == pytest.approx(coarse.bores.rod_length, rel=1e-9)
    assert [note.split(",")[0] for note in found.imported.assumed] == [
        f"the unit of length of the mesh is taken to be {said}"
    ] * bool(said)


def part(mesh, keep):
    centers = mesh.points[mesh.tets[:, :4]].mean(axis=1)
    return TetMesh(mesh.points, mesh.tets[keep(centers)])


def test_a_rod_without_its_cap_is_refused_with_the_question(coarse):
    half = part(coarse.whole, lambda places: places[:, 0] > 0)
    with pytest.raises(MeshError, match=r"half open: is the cap missing\?|no two parallel round bores"):
        pair_of(half)


def test_bolt_holes_alone_are_no_bores(coarse):
    """The cap: both bolt holes are there, the bore is half."""
    cap = part(coarse.whole, lambda places: places[:, 0] < -2.0)
    with pytest.raises(MeshError, match=r"half open: is the cap missing\?|no two parallel round bores"):
        pair_of(cap)


def test_bores_can_be_named_by_their_diameters(coarse):
    big, small = (2 * radius for radius in (coarse.bores.big_radius, coarse.bores.small_radius))
    assert pair_of(coarse.whole, big, small)[0].radius == pytest.approx(big / 2, rel=1e-5)
    assert pair_of(coarse.whole, small, big)[0].radius == pytest.approx(small / 2, rel=1e-5)
    with pytest.raises(MeshError, match="no two parallel round bores") as caught:
        pair_of(coarse.whole, 77.0, small)
    assert f"diameter {big:.4g} mm" in str(caught.value)


def test_bores_that_are_not_round_are_refused_with_how_far_they_are_off(coarse, tmp_path):
    whole = coarse.whole
    random = np.random.default_rng(0)
    rough = whole.points * np.array([1.0, 1.06, 1.0])  # the bores are ellipses now
    (tmp_path / "rod.inp").write_text(deck(TetFile(rough, whole.tets, random.permutation(len(whole.tets)))))
    with pytest.raises(MeshError, match=r"not round: .* % of the radius|no two parallel round bores"):
        given_mesh(RodFile(tmp_path / "rod.inp"))
