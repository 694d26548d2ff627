"""A rod without its cap, as a surface of triangles: closed by a cap of its own or an assumed one."""

from dataclasses import replace
from itertools import pairwise

import gmsh
import numpy as np
import pytest
from damage import write_surface

from geometry.imports import MissingCap, RodFile
from geometry.presets import PRESETS
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror
from mesh.creases import SurfaceMesh
from mesh.files import bore_pair, reading
from mesh.files.given import given_mesh, shells, with_assumed_cap, with_cap
from mesh.files.reading import crossings, require_closed, stl_surface
from mesh.tetmesh import MeshError

pytestmark = pytest.mark.slow


LEON_2001 = PRESETS["leon-2001"]

BOLTED = replace(
    LEON_2001,
    shank_section="rectangular",
    cap_bolt=9.0,
    cap_bolt_spacing=72.6,
    cap_boss_length=40.0,
    cap_boss_fillet=4.0,
)


def part(path, rod, low, high, around):
    """Write the part of a rod between two x as STL; return its volume."""
    with session():
        build(rod, Mirror.NONE)
        box = gmsh.model.occ.addBox(low, -100, -100, high - low, 200, 200)
        made, _ = gmsh.model.occ.intersect(gmsh.model.getEntities(3)[:1], [(3, box)])
        gmsh.model.occ.synchronize()
        write_surface(path, 12, around)
        return gmsh.model.occ.getMass(*made[0])


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    """Files of rod and cap with their volumes, the cap also with other triangles, and a rod without bolts."""
    folder = tmp_path_factory.mktemp("halves")
    plain = replace(LEON_2001, shank_section="rectangular")
    sizes = {
        "rod": part(folder / "rod.stl", BOLTED, 0, 300, 20),
        "cap": part(folder / "cap.stl", BOLTED, -100, 0, 20),
        "finer": part(folder / "finer.stl", BOLTED, -100, 0, 32),
        "plain": part(folder / "plain.stl", plain, 0, 300, 20),
        "ring": part(folder / "ring.stl", plain, -100, 0, 20),
    }
    return folder, sizes


@pytest.mark.parametrize("cap", ["cap", "finer"])
def test_a_cap_of_its_own_is_joined_whatever_its_triangles_are(parts, cap):
    folder, sizes = parts
    joined = with_cap(stl_surface(folder / "rod.stl"), stl_surface(folder / f"{cap}.stl"))
    require_closed(joined)
    # Chords of 18° lie within the arcs of the bore and of the ring.
    assert joined.volume == pytest.approx(sizes["rod"] + sizes["cap"], rel=0.01)
    assert not len(crossings(joined))


def test_an_assumed_cap_is_a_ring_of_the_section_at_the_joint(parts):
    folder, sizes = parts
    rod = stl_surface(folder / "plain.stl")
    for turn in ([1, -1, -1], [1, 1, 1]):
        closed = with_assumed_cap(SurfaceMesh(rod.points * np.array(turn), rod.facets))
        require_closed(closed)
        assert closed.volume == pytest.approx(sizes["plain"] + sizes["ring"], rel=0.01)
    assert with_assumed_cap(closed) is None
    bolted = with_assumed_cap(stl_surface(folder / "rod.stl"))
    require_closed(bolted)  # its bolt holes end at the joint
    assert bolted.volume > closed.volume


def test_two_files_are_one_rod(parts, monkeypatch):
    monkeypatch.setattr(reading, "PER_LENGTH", 30)
    folder, sizes = parts
    given = given_mesh(RodFile(folder / "rod.stl", cap=folder / "cap.stl"))
    assert given.bores[1].x == pytest.approx(141, rel=1e-3)
    assert "bonded at the joint" in given.imported.assumed[0]
    corners = given.mesh.points[given.mesh.tets[:, :4]]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 6
    assert volume == pytest.approx(sizes["rod"] + sizes["cap"], rel=0.02)


def test_two_bodies_of_one_file_are_one_rod_or_the_way_out_is_said(parts, tmp_path):
    folder, sizes = parts
    rod, cap = (stl_surface(folder / f"{name}.stl") for name in ("cap", "rod"))
    facets = np.concatenate([rod.facets, len(rod.points) + cap.facets])
    both = SurfaceMesh(np.concatenate([rod.points, cap.points]), facets)
    assert with_cap(*shells(both)).volume == pytest.approx(sizes["rod"] + sizes["cap"], rel=0.01)
    texts = [(folder / f"{name}.stl").read_text() for name in ("rod", "cap")]
    merged = texts[0][: texts[0].rindex("endsolid")] + texts[1][texts[1].index("\n") + 1 :]
    (tmp_path / "both.stl").write_text(merged)  # where the bodies have sides in common
    bodies = shells(stl_surface(tmp_path / "both.stl"))
    assert [body.volume for body in bodies] == pytest.approx([sizes["rod"], sizes["cap"]], rel=0.01)
    assert with_cap(*bodies).volume == pytest.approx(sizes["rod"] + sizes["cap"], rel=0.01)


@pytest.mark.parametrize(
    ("away", "said"), [(0.0, "cuts itself.*cross each other"), (500.0, "2 separate bodies")]
)
def test_two_bodies_of_which_neither_lacks_a_cap_are_not_joined(parts, tmp_path, away, said):
    folder, _ = parts
    plain = with_cap(*(stl_surface(folder / f"{name}.stl") for name in ("rod", "cap")))
    box = np.array([[x, y, z] for x in (70.0, 75.0) for y in (-99.0, 99.0) for z in (-2.0, 2.0)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    halves = np.array([[a, b, c] for a, *rest in sides for b, c in pairwise(rest)])
    corners = np.concatenate([plain.corners, (box + np.array([0.0, away, 0.0]))[halves]])
    lines = [" ".join(map(repr, map(float, corner))) for corner in corners.reshape(-1, 3)]
    facets = [
        "facet\nouter loop\n" + "".join(f"vertex {line}\n" for line in lines[k : k + 3])
        for k in range(0, len(lines), 3)
    ]
    text = "solid\n" + "".join(f"{facet}endloop\nendfacet\n" for facet in facets) + "endsolid\n"
    (tmp_path / "both.stl").write_text(text)
    with pytest.raises(MeshError, match=said):
        given_mesh(RodFile(tmp_path / "both.stl"))


def test_of_walls_seen_along_directions_a_little_apart_the_one_with_most_wall_is_the_half_bore(
    parts, monkeypatch
):
    surface = stl_surface(parts[0] / "rod.stl")
    along = bore_pair.open_wall(surface)
    oblique = replace(along, radius=1.02 * along.radius, area=0.4 * along.area)
    monkeypatch.setattr(bore_pair, "_walls", lambda _: [[along], [oblique]])
    assert bore_pair.open_wall(surface) is along


def test_what_is_not_a_cap_is_refused_with_the_way_out(parts):
    folder, _ = parts
    rod, cap = (stl_surface(folder / f"{name}.stl") for name in ("rod", "cap"))
    with pytest.raises(MeshError, match=r"faces the same way. Export both in the coordinates"):
        with_cap(rod, rod)
    away = SurfaceMesh(cap.points - [8.0, 0.0, 0.0], cap.facets)
    with pytest.raises(MeshError, match=r"plane faces, not 2.*--cap|is 8 away from it"):
        with_cap(rod, away)
    closed = with_cap(rod, cap)
    with pytest.raises(MeshError, match=r"closed: leave rod\.cap out"):
        with_cap(closed, cap)
    with pytest.raises(MeshError, match=r'is the cap missing\? .*--cap FILE.*"assumed"'):
        given_mesh(RodFile(folder / "rod.stl", cap=MissingCap.REFUSED))


def test_triangles_that_cross_are_counted():
    flat = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
    upright = np.array([[1.0, 1, -1], [1, 1, 1], [9, 9, 1]])
    aside = upright + np.array([20.0, 0, 0])
    surface = SurfaceMesh(np.concatenate([flat, upright, aside]), np.arange(9).reshape(3, 3))
    assert crossings(surface).tolist() == [[0, 1]]
