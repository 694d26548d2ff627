"""Meshes that the checks of a run would refuse are made again; others stay as they are."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fea.analysis.meshing import mesh_study
from fea.base.checks import LIMITS
from fea.machine.clock import Clock
from fea.rod.discretise import mesh_flaws
from fea.rod.meshed_rod import mass_error
from fea.solid.inertia import inertia
from fea.study.study import parse_study
from geometry.bodies import block, draw
from geometry.session import session
from mesh.generate import tetrahedralise
from mesh.quality import measure
from mesh.sizing import Sizing

ROD = '[rod]\nlength_mm = 100\nbig_end_bore_mm = 50\nsmall_end_bore_mm = 25\nshank_section = "rectangular"\n'


def meshed(size, element="p2", rod=ROD):
    pins = '[analysis]\npressure = "cosine-180"\n'  # contact needs smaller elements on the bores
    study = parse_study(f'{rod}{pins}[mesh]\nsize_mm = {size}\nelement = "{element}"\n', "coarse", Path())
    said = []
    found = mesh_study(study, Clock(said.append))
    materials = study.materials(found.parts)
    mass = inertia(found.cell, materials[0].density).properties.mass
    return found, said, mass_error(mass, found.parts.values(), materials)


def test_straight_edges_that_miss_the_mass_are_made_again_with_shorter_ones():
    found, said, error = meshed(12.5)
    assert error < 0.2 * LIMITS["mesh_mass"]
    assert found.meshing.size == 12.5
    assert 0 < found.meshing.repair.size < found.meshing.size
    assert [what for what in said if "again" in what] == [
        f"meshing again, because {found.meshing.repair.causes[0]}"
    ]
    assert "straight where the solid is curved near" in found.notes[1].text


def test_elements_too_bent_for_the_mass_are_made_again():
    found, _, error = meshed(100 / 7, rod=ROD.replace("25", "20").replace("rectangular", "I"))
    assert error < 0.2 * LIMITS["mesh_mass"]
    assert "elements were too distorted near" in found.meshing.repair.causes[0]


def test_a_flat_element_is_found_by_its_shape():
    with session():
        mesh, quality = tetrahedralise(draw(block(10.0, 10.0, 10.0)), (), Sizing(4.0, 1))
        a, b, c, d = mesh.points[mesh.tets[0]]
        points = mesh.points.copy()
        points[mesh.tets[0, 3]] = (a + b + c) / 3 + 1e-4 * (d - a)
        flat = replace(mesh, points=points)
        repair = mesh_flaws(None, None, flat, measure(flat))
        assert mesh_flaws(None, None, mesh, quality) is None
    centers = [spot.center for spot in repair.balls]
    assert np.isclose(centers, points[mesh.tets[0]].mean(axis=0)).all(axis=1).any()
    assert "flat near" in repair.causes[0]


@pytest.mark.parametrize(("size", "element"), [(6.0, "p2"), (12.5, "p1")])
def test_sound_meshes_and_chords_are_left_alone(size, element):
    found, said, _ = meshed(size, element)
    assert found.meshing.repair.causes == ()
    assert set(said) == {"geometry", "mesh"}
