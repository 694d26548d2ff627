"""A rod with unfilleted joints: what is said of its sharp edges."""

import dataclasses
import io
from functools import partial
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from cad_files import drawn_study
from printed import require_brief
from rich.console import Console
from scipy.spatial import KDTree

from fea.analysis.meshing import mesh_study
from fea.analysis.summary import _bar_notes
from fea.apps.result import analyse
from fea.judge.case_result import Governing
from fea.judge.sharp_places import SharpPlaces
from fea.output.json_file import as_dict
from fea.output.pictures.shown import described_by
from fea.output.terminal.run import print_runs
from fea.solid.sharp_edges import SharpEdges
from fea.solid.singular import BoundaryEdges, masked_nodes
from fea.study.option_tables import MeshTable
from geometry.bodies import Prism, Side, block, polygon
from geometry.bodies import draw as draw_body
from geometry.segments import Arc, Line
from geometry.session import session
from geometry.surfaces import Surface
from mesh.creases import creases
from mesh.generate import tetrahedralise
from mesh.sizing import Sizing
from mesh.tetmesh import TetMesh

pytestmark = pytest.mark.slow


LENGTH = 140.0


def draw(occ, *, joined):
    """A ring, a bar and a ring: fused into one solid, or three that touch."""
    rings = [(3, occ.addCylinder(x, 0, -12, 0, 0, 24, r)) for x, r in ((0, 38), (LENGTH, 20))]
    bar = [(3, occ.addBox(0, -7, -6, LENGTH, 14, 12))]
    if joined:
        solids, _ = occ.fuse(bar, rings)
    else:
        solids = occ.cut(bar, rings, removeTool=False)[0] + rings
    bores = [(3, occ.addCylinder(x, 0, -12, 0, 0, 24, r)) for x, r in ((0, 26), (LENGTH, 12))]
    for solid in solids:
        occ.cut([solid], bores, removeTool=False)
    occ.remove(bores, recursive=True)


@pytest.fixture(scope="module")
def studies(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sharp")
    return {
        name: drawn_study(
            folder, name, partial(draw, joined=name == "fused"), 6.0, "[analysis]\nmin_safety = 2.0\n"
        )
        for name in ("fused", "touching")
    }


@pytest.fixture(scope="module")
def result(studies):
    return analyse(studies["fused"])


@pytest.fixture(scope="module")
def edges(result):
    return result.summary.results["given"].sharp_edges


def test_the_same_edges_are_sharp_however_the_solids_are_joined_and_meshed(studies):
    found = []
    for name, size in (("fused", 8.0), ("touching", 8.0), ("fused", 14.0)):
        mesh = mesh_study(dataclasses.replace(studies[name], mesh=MeshTable(size_mm=size)))
        on = BoundaryEdges(mesh.cell).singular_nodes((), mesh.cell_creases)
        x, y, z = mesh.cell.points[on].T
        ring = np.minimum(abs(np.hypot(x, y) - 38), abs(np.hypot(x - LENGTH, y) - 20))
        assert ring.max() < 1e-6
        assert np.minimum(abs(y - 7), abs(z - 6)).max() < 1e-6
        found.append(
            {
                (bool(x > 70), bool(abs(y - 7) < 1e-6), bool(abs(z - 6) < 1e-6))
                for x, y, z in mesh.cell.points[on]
            }
        )
    every = {(far, *edge) for far in (False, True) for edge in ((True, False), (False, True), (True, True))}
    assert all(places == every for places in found)


def test_a_facet_that_was_straightened_makes_no_sharp_edge():
    """The facets of a coarse round turn by 45°, its faces do not turn at all."""
    sides = polygon(
        *(((x, y), Surface.FREE) for x, y in ((0, 0), (30, 0), (30, 10), (10, 10), (10, 30), (0, 30)))
    )
    with session():
        faces = draw_body(Prism(sides, (0.0, 4.0)))
        mesh, _ = tetrahedralise(faces, [], Sizing(5.0))
        sharp = creases(faces, mesh)
    assert BoundaryEdges(mesh).singular_nodes((), sharp).size == BoundaryEdges(mesh).singular_nodes().size > 0
    smooth = dataclasses.replace(sharp, nodes=sharp.nodes[:0], fold=sharp.fold[:0], label=sharp.label[:0])
    assert not masked_nodes(mesh, BoundaryEdges(mesh).singular_nodes((), smooth)).any()


def test_a_facet_that_is_folded_over_is_no_cusp():
    """One such facet on a fillet would hide the peak stress of the fillet."""
    with session():
        faces = draw_body(block(20.0, 20.0, 8.0))
        mesh, _ = tetrahedralise(faces, [], Sizing(4.0))
        sharp = creases(faces, mesh)
    flat = TetMesh(mesh.points, mesh.tets[:, :4], {name: of[:, :3] for name, of in mesh.facets.items()})
    top = flat.facets[Surface.FREE]
    top = top[(flat.points[top][:, :, 2] > 8 - 1e-6).all(axis=1)]
    middle = np.abs(flat.points[top].mean(axis=1)[:, :2] - 10).sum(axis=1).argmin()
    a, b, c = flat.points[top[middle]]
    points = flat.points.copy()
    points[top[middle, 2]] = c + 1.2 * ((a + b) / 2 - c)  # beyond the opposite edge
    folded = dataclasses.replace(flat, points=points)
    assert BoundaryEdges(folded).singular_nodes().size > 0
    assert BoundaryEdges(folded).singular_nodes((), sharp).size == 0


def test_edges_are_read_at_places_and_in_directions_of_the_drawing(studies):
    """Mesh edges of 8 mm lie across the arcs by up to 12° otherwise than those of 5 mm."""
    found = []
    for size in (8.0, 5.0):
        mesh = mesh_study(dataclasses.replace(studies["fused"], mesh=MeshTable(size_mm=size)))
        found.append(SharpEdges.of(mesh.whole, mesh.creases.on(mesh.drawn_node)))
    one, other = found
    assert len(one.at) == len(other.at)
    apart, nearest = KDTree(other.at).query(one.at)
    assert sorted(nearest) == list(range(len(other.at)))
    assert apart.max() < 0.2  # the sagitta of a chord
    cosine = np.einsum("nix,njx->nij", one.away, other.away[nearest]).max(axis=2)
    assert cosine.min() > np.cos(np.radians(1.0))


def test_a_way_ends_where_a_fillet_begins():
    """A slot with a sharp corner at (10, 10) and one of radius 2, from (14, 10)."""
    corners = (14, 10), (10, 10), (10, 20), (0, 20), (0, 0), (30, 0), (30, 20), (16, 20), (16, 12)
    curves = (*(Line(*ends) for ends in pairwise(corners)), Arc((14.0, 12.0), 2.0, 0.0, -np.pi / 2))
    with session():
        faces = draw_body(Prism(tuple(Side(curve, Surface.FREE) for curve in curves), (0.0, 12.0)))
        mesh, _ = tetrahedralise(faces, [], Sizing(1.5))
        edges = SharpEdges.of(mesh, creases(faces, mesh))
    assert np.abs(edges.at[:, :2] - 10).max() < 1e-6
    rows, step, within = np.arange(len(edges.at)), np.full(len(edges.at), 0.25), np.ones(len(edges.at))
    floor = np.abs(edges.away[:, :, 0] - 1) < 1e-6
    for side in (0, 1):
        reached = edges.paths(side, rows, step, 40, within).length * 0.25
        assert reached[floor[:, side]] == pytest.approx(4.0, abs=0.3)
        assert reached[~floor[:, side]] == pytest.approx(10.0, abs=0.3)


def test_each_edge_has_its_place_and_figures(edges):
    assert [edge.name for edge in sorted(edges, key=lambda edge: edge.safety_factor)] == [*"ABCD"][
        : len(edges)
    ]
    for edge in edges:
        _, y, z = edge.at_mm
        assert abs(y) == pytest.approx(7, abs=1e-3) or abs(z) == pytest.approx(6, abs=1e-3)
        assert any("cylinder of radius" in face for face in edge.between)
        assert 89 < edge.opening_deg < 112
        assert edge.length_mm == pytest.approx(12, rel=0.01) or 13.9 < edge.length_mm < 14.5
        assert 0 < edge.structural_von_mises_MPa < 700
        assert edge.safety_factor == pytest.approx(700 / edge.structural_von_mises_MPa, rel=1e-6)
        assert edge.required_safety_factor == 2.0


def test_the_answer_counts_the_structural_stress(result, edges):
    case, found = result.summary.results["given"], result.summary.survival
    least = min([case.min_safety_factor, *(edge.safety_factor for edge in edges)])
    assert found.safety_factor == pytest.approx(least) or found.place is not None
    assert found.required_safety_factor == 2.0
    assert as_dict(result.summary)["results"]["given"]["sharp_edges"][0]["name"] == edges[0].name


@pytest.mark.parametrize(
    ("share", "words"),
    [(0.2, "reach into the notch effect: draw the fillet, or refine"), (0.8, "face beside")],
)
def test_a_wide_bar_says_why_and_what_helps(result, share, words):
    """Finer elements do not help where the stress changes towards the end of the flank it is read on."""
    (case,) = result.cases.values()
    worst = case.sharp[0]
    wide = dataclasses.replace(
        worst, bar=2 * worst.structural_von_mises, change=2 * share * worst.structural_von_mises
    )
    case = dataclasses.replace(case, sharp=(wide,))
    options = SimpleNamespace(tolerance_percent=5.0)
    rod = SimpleNamespace(options=options, study=options)
    notes = [*_bar_notes(rod, SimpleNamespace(cases={"given": case}), Governing.of((case,)))]
    (said,) = (note.text for note in notes if "may govern" in note.text)
    assert words in said
    assert ("--all-cases" in said) == (share < 0.5)


def test_the_change_to_where_a_flank_ends_belongs_to_the_bar():
    edges = SimpleNamespace(edge=np.array([0, 0, 0, 1]))
    sizes = np.array([[100.0, 50.0], [120.0, 51.0], [np.nan, 52.0], [300.0, 53.0]])
    changes = SharpPlaces(edges, 0.3)._changes(np.arange(4), sizes)
    assert changes[:2, 0] == pytest.approx([0.0, 20.0])
    assert changes[3, 0] == 0.0  # another edge
    assert not changes[:, 1].any()


def test_the_terminal_says_where_what_and_which_to_use(result, edges, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    console = Console(file=io.StringIO(), width=200, highlight=False)
    print_runs([(tmp_path, result.summary)], console, verbose=True)
    said = console.file.getvalue()
    assert "where the elastic stress is infinite" in said
    for edge in edges:
        assert f"Sharp edge {edge.name} at (" in said
    assert said.count("Which to use:") == 1
    assert "Singular, left out" not in said
    brief = Console(file=io.StringIO(), width=80, highlight=False)
    print_runs([(tmp_path, result.summary)], brief)
    require_brief(brief.file.getvalue())
    assert f"sharp edge {edges[0].name}" in brief.file.getvalue()


def test_the_picture_marks_the_edges(result, edges, tmp_path):
    picture = described_by(result.summary, tmp_path / "given.vtu")
    assert picture.marks == tuple((edge.name, edge.at_mm) for edge in edges)
    assert f"sharp edge {edges[0].name}" in picture.notes[-1]


def test_a_finer_mesh_gives_the_same_structural_stress(studies, edges):
    finer = analyse(dataclasses.replace(studies["fused"], mesh=MeshTable(size_mm=4.0)))
    others = {edge.between: edge for edge in finer.summary.results["given"].sharp_edges}
    for edge in edges:
        other = others.get(edge.between)
        if other is None:
            continue
        apart = abs(other.structural_von_mises_MPa - edge.structural_von_mises_MPa)
        bar = edge.error_percent / 100 * edge.structural_von_mises_MPa
        assert apart < max(bar, 0.06 * edge.structural_von_mises_MPa)


def test_a_rod_without_sharp_edges_has_none_of_it():
    found = analyse("leon-2001", size=14).as_dict()
    assert all("sharp_edges" not in case for case in found["results"].values())
    assert "place" not in found["survival"]
