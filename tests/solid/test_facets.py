"""What flat facets in place of a curved surface may change."""

from dataclasses import replace

import gmsh
import numpy as np
import pytest

from fea.solid.singular import BoundaryEdges
from geometry.session import session
from geometry.surfaces import Surface
from mesh.generate import mesh_of_model
from mesh.tetmesh import boundary_facets, raised


def bored_plate(around):
    """A plate with a hole of that many facets."""
    with session():
        plate, hole = gmsh.model.occ.addRectangle(-9, -9, 0, 18, 18), gmsh.model.occ.addDisk(0, 0, 0, 3, 3)
        (face, *_), _ = gmsh.model.occ.cut([(2, plate)], [(2, hole)])
        gmsh.model.occ.extrude([face], 0, 0, 4, numElements=[2])
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 6)
        for _, curve in gmsh.model.getEntities(1):
            if gmsh.model.getType(1, curve) in {"Circle", "Ellipse"}:
                gmsh.model.mesh.setTransfiniteCurve(curve, around + 1)
        gmsh.model.mesh.generate(3)
        mesh = mesh_of_model({}, 1)
    return replace(mesh, facets={Surface.FREE: boundary_facets(mesh.tets)})


@pytest.mark.parametrize("around", [12, 24, 40])
def test_the_share_of_flat_facets_is_that_of_gao_1991_between_their_edges(around):
    """2 t ln 2 / pi on the hole, where t is the angle between its facets; none on the plane sides."""
    mesh = raised(bored_plate(around))
    share = BoundaryEdges(mesh).facet_share()
    on_hole = np.isclose(np.hypot(*mesh.points[:, :2].T), 3)
    assert share[on_hole] == pytest.approx(2 * np.log(2) / np.pi * 2 * np.pi / around, rel=1e-6)
    corner = np.isclose(np.abs(mesh.points[:, 0]), 9) & np.isclose(np.abs(mesh.points[:, 1]), 9)
    assert not share[corner].any()  # turned by 90 degrees, which the solid does itself


def test_neither_curved_facets_nor_elements_of_first_order_have_a_share():
    first = bored_plate(16)
    assert not BoundaryEdges(first).facet_share().any()
    curved = raised(first)
    radius = np.hypot(*curved.points[:, :2].T)
    inside = radius < 3 - 1e-9  # the middles of chords
    curved.points[inside, :2] *= 3 / radius[inside, None]
    assert not BoundaryEdges(curved).facet_share().any()
