from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tet_blocks import block

from mesh.creases import SurfaceMesh
from mesh.files.tets import mended
from mesh.quality import scaled_jacobian
from mesh.tetmesh import MeshError, boundary_facets

# Vertices and mid-side nodes of an element whose second and third vertex have changed places.
INSIDE_OUT = {4: [0, 2, 1, 3], 10: [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]}


def volume(mesh):
    return SurfaceMesh(mesh.points, boundary_facets(mesh.tets)[:, :3]).volume


@pytest.mark.parametrize("order", [1, 2])
def test_a_sound_mesh_stays_as_it_is(order):
    file = block(order=order)
    found = mended(file)
    assert found.notes == ()
    np.testing.assert_array_equal(found.mesh.tets, file.tets)
    np.testing.assert_array_equal(found.mesh.points, file.points)
    assert volume(found.mesh) == pytest.approx(2.0, rel=1e-12)


@settings(max_examples=30)
@given(turned=st.sets(st.integers(0, 11)), order=st.sampled_from([1, 2]))
def test_elements_that_are_inside_out_are_turned_over(turned, order):
    file = block(order=order)
    tets = file.tets.copy()
    tets[list(turned)] = tets[list(turned)][:, INSIDE_OUT[tets.shape[1]]]
    found = mended(replace(file, tets=tets))
    assert (scaled_jacobian(found.mesh) > 0).all()
    assert volume(found.mesh) == pytest.approx(2.0, rel=1e-12)
    assert [
        note for note in found.notes if "inside out" in note and note.endswith(str(len(turned)))
    ] or not turned


@settings(max_examples=30)
@given(order=st.sampled_from([1, 2]), seed=st.integers(0, 99))
def test_doubled_nodes_orphans_and_doubled_elements_go(order, seed):
    file = block(order=order)
    random = np.random.default_rng(seed)
    own = np.concatenate([file.points, file.points, [[9.0, 9.0, 9.0], [np.nan, 0.0, 0.0]]])
    doubled = file.tets + len(file.points) * random.integers(2, size=file.tets.shape)
    found = mended(
        replace(
            file, points=own, tets=np.vstack([doubled, file.tets[:1]]), numbers=np.append(file.numbers, 99)
        )
    )
    assert len(found.mesh.points) == len(file.points)
    assert len(found.mesh.tets) == len(file.tets)
    assert volume(found.mesh) == pytest.approx(2.0, rel=1e-12)
    assert any("occurred twice, dropped: 1" in note for note in found.notes)


def test_mid_side_nodes_off_their_straight_edges_are_kept():
    file = block(order=2)
    points = file.points.copy()
    points[-1] += [0.0, 0.0, 0.05]
    assert (mended(replace(file, points=points)).mesh.points == points).all()


def test_the_numbering_of_gmsh_is_recognised():
    file = block(order=2)
    found = mended(replace(file, tets=file.tets[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]))
    np.testing.assert_array_equal(found.mesh.tets, file.tets)
    assert any("exchanged" in note for note in found.notes)


def tets_changed(file, row, column, value):
    tets = file.tets.copy()
    tets[row, column] = value
    return replace(file, tets=tets)


def moved(file, node, place):
    points = file.points.copy()
    points[node] = place
    return replace(file, points=points)


def crack(file):
    """An edge with a second mid-side node."""
    points = np.vstack([file.points, file.points[file.tets[3, 4]] + [0.01, 0.0, 0.0]])
    return tets_changed(replace(file, points=points), 3, 4, len(points) - 1)


FIRST, SECOND = block(first_number=101), block(order=2, first_number=101)
WRONG = {
    "a node that does not exist": (tets_changed(FIRST, 2, 1, 99), "nodes that do not exist .number 103"),
    "a negative node": (tets_changed(FIRST, 2, 1, -1), "nodes that do not exist .number 103"),
    "NaN": (moved(FIRST, 0, [np.nan, 0, 0]), "coordinates are no usable numbers .number 101, 102"),
    "an overflow": (moved(FIRST, 0, [1e300, 0, 0]), "coordinates are no usable numbers"),
    "a collapsed element": (tets_changed(FIRST, 4, 1, FIRST.tets[4, 0]), "the same node twice .number 105"),
    "a flat element": (
        replace(FIRST, points=np.where([False, False, True], 0.5, FIRST.points)),
        "nodes|no volume|same node",
    ),
    "a face of three": (
        replace(
            FIRST,
            points=np.vstack([FIRST.points, [0.2, 0.3, 5.0]]),
            tets=np.vstack([FIRST.tets, [*FIRST.tets[0, [0, 1, 3]], len(FIRST.points)]]),
            numbers=np.append(FIRST.numbers, 999),
        ),
        "more than two elements: they overlap",
    ),
    "a misplaced node": (
        moved(FIRST, 6, [3.0, 1.0, 0.0]),
        "a neighbour on the same side of their common face",
    ),
    "two bodies": (
        replace(
            FIRST,
            points=np.vstack([FIRST.points, FIRST.points + np.array([0, 5, 0])]),
            tets=np.vstack([FIRST.tets, FIRST.tets + len(FIRST.points)]),
            numbers=np.arange(24),
        ),
        "2 bodies that share no nodes: 12 elements",
    ),
    "mid-side nodes elsewhere": (
        replace(SECOND, tets=SECOND.tets[:, [0, 1, 2, 3, 9, 8, 7, 6, 5, 4]]),
        "mid-side nodes that do not stand on their edges .number 101, 102",
    ),
    "a crack along an edge": (crack(SECOND), "other elements have another mid-side node"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_be_mended_is_refused_by_number(name):
    file, message = WRONG[name]
    with pytest.raises(MeshError, match=message):
        mended(file)
