from dataclasses import replace

import numpy as np
import pytest
from strap import strap

from fea.analysis.meshing import mesh_study
from fea.study.study import load_study
from geometry.surfaces import Surface
from mesh.tetmesh import MeshError, outward, reflect, unmirrored


def enclosed(mesh):
    """The volume by Gauss's theorem: as large as the tetrahedra's only if every facet points outwards."""
    a, b, c = np.concatenate([facets[:, :3] for facets in mesh.facets.values()]).T
    return (mesh.points[a] * np.cross(mesh.points[b], mesh.points[c])).sum() / 6


def volume(mesh):
    corners = mesh.points[mesh.tets[:, :4]]
    return np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6


@pytest.mark.parametrize("order", [1, 2])
def test_facets_turned_at_random_are_turned_back(order):
    mesh = strap(order=order)
    turn = [0, 2, 1] if order == 1 else [0, 2, 1, 5, 4, 3]
    wrong = np.random.default_rng(1).random(len(mesh.facets[Surface.FREE])) < 0.5
    facets = np.where(wrong[:, None], mesh.facets[Surface.FREE][:, turn], mesh.facets[Surface.FREE])
    mended = outward(replace(mesh, facets=mesh.facets | {Surface.FREE: facets}))
    assert enclosed(mended) == pytest.approx(volume(mesh), rel=1e-12)


@pytest.mark.parametrize("corners", [[0, 1, 2], None])
def test_a_facet_that_bounds_no_element_or_two_is_refused(corners):
    mesh = strap(order=1)
    inner = corners or next(iter(inner_faces(mesh)))
    facets = np.vstack([mesh.facets[Surface.FREE], inner])
    with pytest.raises(MeshError, match="1 surface triangles do not bound exactly one"):
        outward(replace(mesh, facets=mesh.facets | {Surface.FREE: facets}))


def inner_faces(mesh):
    faces = np.sort(mesh.tets[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3), axis=1)
    found, counts = np.unique(faces, axis=0, return_counts=True)
    return found[counts == 2].tolist()


def test_the_rod_and_its_reflections_are_closed_by_outward_facets():
    found = mesh_study(load_study())
    whole = found.whole
    assert enclosed(found.drawn) == pytest.approx(volume(found.drawn), rel=1e-12)
    assert enclosed(whole) == pytest.approx(volume(whole), rel=1e-12)
    half = reflect(unmirrored(found.drawn), Surface.SYMMETRY_Y).mesh
    assert enclosed(half) == pytest.approx(volume(half), rel=1e-12)
