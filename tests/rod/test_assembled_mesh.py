"""The mesh of an assembled rod: parts with nodes of their own, whose facets match where they touch."""

import math
from dataclasses import replace

import numpy as np
import pytest
from assemblies import SCREWS, SIMPLE

from fea.base.choices import Symmetry
from fea.machine.clock import Clock
from fea.rod.discretise import MeshRequest, discretise
from fea.rod.places import place_name
from fea.solid.singular import BoundaryEdges, mask_radius, masked_nodes, rim_masks
from fea.solid.supports import components
from fea.study.study import load_study
from geometry.assembly import Assembly
from geometry.surfaces import INTERFACES, PLANE_AXIS, Surface
from mesh.creases import rims
from mesh.sizing import SizeField
from mesh.tetmesh import FACET_TURN, scikit_fem_order

EVERY = Assembly(bushing=True, shell=1.5, bolt=SCREWS)


def meshed(assembly=EVERY, **request):
    study = load_study("leon-2001")
    table = replace(study.rod, dimensions=SIMPLE)
    return discretise(table, study.materials, MeshRequest(size=14.0, assembly=assembly, **request), Clock())


@pytest.fixture(scope="module")
def rod():
    return meshed(order=2)


def volumes(mesh):
    a, b, c, d = mesh.points[mesh.tets[:, :4]].transpose(1, 0, 2)
    size = ((b - a) * np.cross(c - a, d - a)).sum(axis=1) / 6
    return np.bincount(mesh.part, size)


def area(mesh, facets):
    a, b, c = mesh.points[facets[:, :3]].transpose(1, 0, 2)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def test_every_part_is_a_body_of_its_own(rod):
    assert list(rod.parts) == ["rod", "cap", "bushing", "upper shell", "lower shell"]
    for mesh in (rod.cell, rod.whole):
        body = components(mesh)
        of_part = [np.unique(body[mesh.tets[mesh.part == number]]) for number in range(5)]
        assert sorted(np.concatenate(of_part).tolist()) == [0, 1, 2, 3, 4]
    assert components(rod.drawn).max() == 0
    assert len(rod.bolts) == 2


def test_facets_match_row_by_row_on_the_whole_rod(rod):
    for mesh in (rod.cell, rod.whole):
        for one, other in INTERFACES:
            near, far = mesh.facets[one], mesh.facets[other][:, FACET_TURN[6]]
            np.testing.assert_array_equal(mesh.points[near], mesh.points[far])
            assert not np.intersect1d(near, far).size


def test_four_quarters_make_the_whole(rod):
    assert volumes(rod.whole) == pytest.approx(4 * volumes(rod.cell), rel=1e-12)
    for one, other in INTERFACES:
        assert area(rod.whole, rod.whole.facets[one]) == pytest.approx(
            4 * area(rod.cell, rod.cell.facets[other])
        )
    for plane in rod.symmetry.planes:
        assert not rod.cell.points[rod.cell.facets[plane], PLANE_AXIS[plane]].any()
    for mesh in (rod.cell, rod.whole):
        np.testing.assert_array_equal(
            scikit_fem_order(mesh.tets, len(mesh.points)), np.arange(len(mesh.points))
        )
    np.testing.assert_array_equal(np.abs(rod.whole.points), np.abs(rod.drawn.points[rod.drawn_node]))


def test_a_larger_cell_is_the_same_mesh():
    half, rod = (meshed(order=1, symmetry=cell) for cell in (Symmetry.HALF, Symmetry.AUTO))
    assert len(half.cell.points) > len(rod.cell.points)
    np.testing.assert_array_equal(np.unique(half.whole.points, axis=0), np.unique(rod.whole.points, axis=0))


def test_sizes_wanted_on_what_was_drawn_refine_it(rod):
    size = np.where(np.hypot(*rod.drawn.points[:, :2].T) < 27, 1.5, np.inf)
    wanted = SizeField(rod.drawn.points, rod.drawn.tets[:, :4], np.minimum(size, 1e3))
    finer = meshed(order=2, wanted=[wanted])
    shells = [len(mesh.drawn.tets[mesh.drawn.part >= 3]) for mesh in (rod, finer)]
    assert shells[1] > 2 * shells[0]


def test_parts_do_not_multiply_the_elements():
    one_piece, parts = (len(meshed(assembly, order=1).whole.tets) for assembly in (None, EVERY))
    assert parts < 2 * one_piece


def test_rims_are_found_with_their_length_on_both_sides(rod):
    mesh = rod.whole
    found = {rim.surface: rim for rim in rims(mesh) if rim.name != "rim of the joint at the bore"}
    at_bore = [rim for rim in rims(mesh) if rim.name == "rim of the joint at the bore"]

    def length(rim):
        a, b = mesh.points[rim.edges].transpose(1, 0, 2)
        return np.linalg.norm(a - b, axis=1).sum()

    chord = 0.01  # the edges of elements of 14 mm are chords
    bore, back = SIMPLE.small_end_bore + 2 * SIMPLE.bushing, SIMPLE.big_end_bore + 2 * EVERY.shell
    assert length(found[Surface.BUSHING_SEAT]) == pytest.approx(
        2 * math.pi * bore + math.pi * SIMPLE.oil_hole, rel=3 * chord
    )
    along_shells = 2 * math.pi * back
    for side in (Surface.BUSHING_BACK, Surface.SHELL_BACK, Surface.JOINT_CAP):
        opposite = next(one for one, other in INTERFACES if other is side)
        assert length(found[side]) == pytest.approx(length(found[opposite]), rel=1e-12)
    assert length(found[Surface.SHELL_SEAT]) > along_shells * (1 - chord)
    head = 2 * math.pi * (SCREWS.head_diameter + SIMPLE.cap_bolt)
    assert length(found[Surface.BOLT_HEAD]) == pytest.approx(head, rel=5 * chord)
    thread = 4 * math.pi * SIMPLE.cap_bolt
    assert length(found[Surface.BOLT_THREAD]) == pytest.approx(thread, rel=5 * chord)
    assert [rim.surface for rim in at_bore] == [Surface.JOINT, Surface.JOINT_CAP]
    straight = 2 * (SIMPLE.big_end_width - 2 * SIMPLE.big_end_chamfer)
    assert [length(rim) for rim in at_bore] == pytest.approx([straight, straight], rel=1e-9)
    of_cell = {(rim.name, rim.surface): rim for rim in rims(rod.cell)}
    for rim in rims(mesh):  # none lies along a mirror plane
        a, b = rod.cell.points[of_cell[rim.name, rim.surface].edges].transpose(1, 0, 2)
        assert 4 * np.linalg.norm(a - b, axis=1).sum() == pytest.approx(length(rim), rel=1e-12)


def test_a_crease_between_two_parts_belongs_to_either(rod):
    edges = rod.cell_creases.find(rims(rod.cell)[0].edges)
    assert (edges >= 0).all()


def test_rims_are_left_out_of_peaks_but_no_thin_part_with_them(rod):
    cell = rod.cell
    found = {mask.name: mask for mask in rim_masks(cell, mask_radius(cell))}
    assert found.keys() == {rim.name for rim in rims(cell)}
    assert found["rim of the bushing's seat"].radius < 0.3 * 1.5
    assert found["rim of the shells' seat"].radius < 0.3 * 1.5
    assert max(mask.radius for mask in found.values()) <= mask_radius(cell)
    masked = masked_nodes(
        cell, BoundaryEdges(cell).singular_nodes((), rod.cell_creases), tuple(found.values())
    )
    for rim in rims(cell):
        assert masked[rim.nodes].all()
    for number in range(len(rod.parts)):
        own = np.unique(cell.tets[cell.part == number])
        assert 0.5 < (~masked[own]).mean() < 1
    of_whole = masked_nodes(
        rod.whole, BoundaryEdges(rod.whole).singular_nodes(), rim_masks(rod.whole, mask_radius(rod.whole))
    )
    assert of_whole.mean() == pytest.approx(masked.mean(), rel=0.2)


def test_a_mesh_of_one_piece_has_no_rims():
    mesh = meshed(assembly=None, order=1).cell
    assert rim_masks(mesh, mask_radius(mesh)) == ()


def test_places_have_names(rod):
    whole, length = rod.whole, rod.bores.rod_length
    named = {
        Surface.BIG_END_BORE: "bore of the bearing shells",
        Surface.SMALL_END_BORE: "bore of the bushing",
        Surface.BOLT_HEAD: "seat of a bolt head",
        Surface.BUSHING_BACK: "seat of the bushing",
    }
    for surface, name in named.items():
        assert {place_name(rod, node) for node in np.unique(whole.facets[surface])[:5]} == {name}

    def nearest(x, y):
        return place_name(rod, int(np.linalg.norm(whole.points - [x, y, 0.0], axis=1).argmin()))

    outer = whole.points[:, 0].max()
    assert nearest(outer, 0.0) == "small end"
    assert nearest(whole.points[:, 0].min(), 0.0) == "cap"
    assert nearest(0.5 * length, 0.0) == "middle of the shank"
    assert nearest(2 * length - outer - 1.0, 0.0) == "shank at the small end"
