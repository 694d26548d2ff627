"""Surfaces of flat triangles, whose inside is meshed."""

from dataclasses import replace

import pytest
from damage import write_surface

from geometry.imports import RodFile
from geometry.presets import PRESETS
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror
from mesh.files import reading
from mesh.files.given import given_mesh
from mesh.files.reading import read_tets
from mesh.tetmesh import MeshError

LEON_2001 = PRESETS["leon-2001"]


@pytest.fixture(scope="module")
def surface(tmp_path_factory):
    path = tmp_path_factory.mktemp("stl") / "leon.stl"
    with session():
        volume = build(replace(LEON_2001, shank_section="rectangular"), Mirror.NONE).mass.mass
        write_surface(path, 10, 20)
    return path, volume


def test_the_inside_of_a_closed_surface_is_meshed(surface, monkeypatch):
    monkeypatch.setattr(reading, "PER_LENGTH", 30)
    path, volume = surface
    given = given_mesh(RodFile(path))
    corners = given.mesh.points[given.mesh.tets[:, :4]]
    sides = corners[:, 1:] - corners[:, :1]
    meshed = abs((sides[:, 0] * _cross(sides[:, 1], sides[:, 2])).sum()) / 6
    assert meshed == pytest.approx(volume, rel=0.01)
    assert given.mesh.order == 2
    assert [2 * bore.radius for bore in given.bores] == pytest.approx([50, 24], rel=0.01)
    assert given.bores[1].x == pytest.approx(141, rel=1e-3)


def _cross(a, b):
    return (a[:, [1, 2, 0]] * b[:, [2, 0, 1]]) - (a[:, [2, 0, 1]] * b[:, [1, 2, 0]])


def test_an_open_surface_is_refused(surface, tmp_path):
    path, _ = surface
    text = path.read_text()
    first = text.index("facet normal", 2000)
    last = text.index("endfacet", first) + len("endfacet")
    (tmp_path / "open.stl").write_text(text[:first] + text[last:])
    with pytest.raises(MeshError, match="not closed: 3 sides do not belong"):
        read_tets(tmp_path / "open.stl")
    (tmp_path / "none.stl").write_text("solid none\nendsolid none\n")
    with pytest.raises(MeshError, match=r"holds no triangles|could not be meshed"):
        read_tets(tmp_path / "none.stl")
