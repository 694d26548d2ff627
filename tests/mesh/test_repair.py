"""Rods whose first mesh fails or is unsound are meshed again, others as ever."""

import pickle
from dataclasses import replace
from functools import partial

import gmsh
import numpy as np
import pytest

from geometry.bodies import block, draw
from geometry.dimensions import ShankSection
from geometry.rod import proportioned
from geometry.session import session
from geometry.solid import build
from mesh.generate import (
    MAX_ROUNDS,
    NOTHING,
    Repair,
    UnsoundMeshError,
    of_elements,
    of_folds,
    repaired,
    tetrahedralise,
)
from mesh.quality import Quality
from mesh.sizing import RefinementBall, SizeField, Sizing, default_size, refinements
from mesh.tetmesh import EDGES, MeshError

GOOD, BAD = Quality(0.5, 0.5, 0.7, (0.0, 0.0, 0.0)), Quality(0.5, 0.001, 0.7, (0.0, 0.0, 0.0))
WORSE = replace(BAD, least_shape=0.0001)
ELSEWHERE = Repair(frozenset({7}), (RefinementBall((0.0, 0.0, 0.0), 1.0, 0.5),), ("an element was flat",))


class Log:
    """A session's log of two lines, of which the second mesh said the second."""

    lines = ("Warning: first", "Warning: second")

    def warnings(self, first=0):
        return self.lines[first:]


class Attempts:
    """Meshes of given quality, or failures, one after the other."""

    def __init__(self, *outcomes):
        self.outcomes, self.repairs = list(outcomes), []

    def __call__(self, *, repair):
        self.repairs.append(repair)
        outcome = self.outcomes.pop(0)
        if isinstance(outcome, Exception):
            raise outcome
        return "mesh", outcome


def settled(attempts):
    told = []
    made = repaired(
        attempts, lambda _, quality: ELSEWHERE if quality is not GOOD else None, Log(), told.append
    )
    return made, told


def test_what_the_other_mesher_leaves_is_not_tried_again():
    attempts = Attempts(BAD, WORSE)
    folds = Repair(causes=("folded",), folded=frozenset({7}))
    made = repaired(attempts, lambda *_: folds, Log(), [].append)
    assert made.quality is WORSE
    assert made.repair == folds


def test_a_face_with_a_folded_triangle_is_found():
    """A node of the top is moved across the opposite side of one of its triangles."""
    with session():
        draw(block(20.0, 20.0, 8.0))
        gmsh.option.setNumber("Mesh.MeshSizeMax", 4.0)
        gmsh.model.mesh.generate(2)
        assert of_folds() is None
        (top,) = (tag for _, tag in gmsh.model.getEntities(2) if gmsh.model.getBoundingBox(2, tag)[2] > 7)
        nodes, places, _ = gmsh.model.mesh.getNodes(2, top)
        moved = np.abs(places.reshape(-1, 3)[:, :2] - 10).sum(axis=1).argmin()
        gmsh.model.mesh.setNode(nodes[moved], places.reshape(-1, 3)[moved] + [7.0, 0.0, 0.0], [])
        found = of_folds()
    assert found.folded == {top}
    assert (found.faces, found.balls) == (frozenset(), ())
    assert "folded" in found.causes[0]


def failure():
    return UnsoundMeshError("crossed", ELSEWHERE)


def test_a_sound_mesh_is_made_once_and_without_repair():
    attempts = Attempts(GOOD)
    made, told = settled(attempts)
    assert attempts.repairs == [NOTHING] == [made.repair]
    assert told == []


def test_failures_and_flaws_add_up_until_a_mesh_is_sound():
    attempts = Attempts(failure(), BAD, GOOD)
    made, told = settled(attempts)
    assert made.quality is GOOD
    assert made.repair == ELSEWHERE + ELSEWHERE
    assert told == ["an element was flat"] * 2


def test_flaws_that_stay_leave_the_first_mesh_for_the_checks_to_mark():
    made, told = settled(Attempts(BAD, failure(), *[WORSE] * (MAX_ROUNDS - 1)))
    assert made.quality is BAD
    assert made.repair == NOTHING
    assert len(told) == MAX_ROUNDS


def test_a_failure_that_stays_is_told_with_the_rounds_it_outlived():
    with pytest.raises(MeshError, match=f"crossed.*{MAX_ROUNDS}"):
        settled(Attempts(*[failure()] * (MAX_ROUNDS + 1)))
    with pytest.raises(MeshError, match=r"^damaged$"):  # nothing to do about it
        settled(Attempts(MeshError("damaged")))


def test_an_unsound_mesh_is_told_across_processes():
    there = pickle.loads(pickle.dumps(failure()))  # noqa: S301 - our own
    assert str(there) == "crossed"
    assert there.repair == ELSEWHERE


def test_elements_are_small_in_a_spot_and_grow_away_from_it():
    repair = Repair(balls=(RefinementBall((0.0, 0.0, 0.0), 3.0, 1.0),), causes=("",))
    with session():
        mesh, _ = tetrahedralise(draw(block(20.0, 20.0, 20.0)), (), Sizing(6.0), repair=repair)
    centers = mesh.points[mesh.tets[:, :4]].mean(axis=1)
    edges = [mesh.points[mesh.tets[:, a]] - mesh.points[mesh.tets[:, b]] for a, b in EDGES]
    length, distance = np.mean(np.linalg.norm(edges, axis=2), axis=0), np.linalg.norm(centers, axis=1)
    assert np.median(length[distance < 3.0]) == pytest.approx(1.0, rel=0.3)
    assert np.median(length[distance > 15.0]) > 3.0


def test_what_the_first_attempt_left_in_the_model_does_not_change_the_second():
    body = block(10.0, 10.0, 10.0)
    with session():
        coarse, _ = tetrahedralise(draw(body), (), Sizing(4.0))
    wide, narrow = (
        SizeField(coarse.points, coarse.tets[:, :4], np.full(len(coarse.points), size)) for size in (3.0, 1.5)
    )
    with session():
        faces = draw(body)
        tetrahedralise(faces, (), Sizing(4.0), wanted=[narrow])
        again, _ = tetrahedralise(faces, (), Sizing(4.0), wanted=[wide], repair=Repair(causes=("",)))
    with session():
        fresh, _ = tetrahedralise(draw(body), (), Sizing(4.0), wanted=[wide])
    assert np.array_equal(again.tets, fresh.tets)
    assert np.array_equal(again.points, fresh.points)


def test_faces_are_found_by_the_edges_of_an_element_and_not_by_its_vertices():
    with session():
        drawn = draw(block(10.0, 10.0, 10.0))
        mesh, _ = tetrahedralise(drawn, (), Sizing(3.0))
        corners = mesh.points[mesh.tets[:, :4]]
        # By side, element and axis: how many vertices lie on that face.
        on = np.stack([np.isclose(corners, 0.0), np.isclose(corners, 10.0)]).sum(axis=2)
        top = (on[1, :, 2] >= 2) & ((on >= 2).sum(axis=(0, 2)) == 1)
        beside = top & ((on == 1).sum(axis=(0, 2)) == 1)
        element = corners[beside][:1]
        repair = of_elements(element, "an element was bad")
        (face,) = repair.faces
        low, high = np.reshape(gmsh.model.getBoundingBox(2, face), (2, 3))
    longest = np.linalg.norm(element[0][:, None] - element[0], axis=-1).max()
    assert (low[2], high[2]) == pytest.approx((10.0, 10.0), abs=1e-5)
    assert repair.size == pytest.approx(longest / 3)
    assert repair.balls[0].center == pytest.approx(element[0].mean(axis=0))


def test_a_rod_whose_coarse_surface_mesh_crosses_itself_is_meshed_at_the_size_asked_for():
    rod = proportioned(100.0, 40.0, 20.0, shank_section=ShankSection.RECTANGULAR)
    size = 4 * default_size(rod.length)
    with session() as log:
        solid = build(rod)
        refined = refinements(solid.features, size, rod.length)
        attempt = partial(tetrahedralise, solid.faces, refined, Sizing(size))
        with pytest.raises(UnsoundMeshError, match="intersect"):
            attempt()
        made = repaired(attempt, lambda *_: None, log, lambda _: None)
    assert len(made.repair.causes) == 1
    assert made.repair.balls == ()
    assert made.quality.least_scaled_jacobian > 0
    assert "Error" not in "".join(made.warnings)
    assert "crossed each other near" in made.repair.notes[0]
