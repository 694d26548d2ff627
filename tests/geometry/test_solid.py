import math
from dataclasses import replace

import gmsh
import pytest

from geometry.errors import GeometryError
from geometry.faces import FeatureKind
from geometry.presets import PRESETS
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror, Surface

LEON_2001 = PRESETS["leon-2001"]


def area(faces):
    return sum(gmsh.model.occ.getMass(2, face) for face in faces)


def test_a_cell_has_the_mass_properties_of_the_whole():
    found = []
    for mirror in Mirror:
        with session():
            found.append(build(LEON_2001, mirror).mass)
    whole = found[0]
    for cell in found[1:]:  # to the accuracy of the kernel's own quadrature
        assert cell.mass == pytest.approx(whole.mass, rel=1e-6)
        assert cell.center == pytest.approx(whole.center, rel=1e-6, abs=1e-6)
        for row, expected in zip(cell.inertia, whole.inertia, strict=True):
            assert row == pytest.approx(expected, rel=1e-6, abs=1e-6 * whole.inertia_z)


@pytest.mark.parametrize("mirror", Mirror)
def test_every_surface_is_found_with_its_area(mirror):
    rod, share = LEON_2001, 1 / mirror.copies
    with session():
        solid = build(rod, mirror)
        areas = {surface: area(faces) for surface, faces in solid.faces.items()}
        assert sum(areas.values()) == pytest.approx(
            area([tag for _, tag in gmsh.model.getEntities(2)]), rel=1e-12
        )  # nothing loose is left in the model
    assert areas[Surface.BIG_END_BORE] == pytest.approx(
        share * math.pi * rod.big_end_bore * rod.big_end_width, rel=1e-9
    )
    assert areas[Surface.SMALL_END_BORE] == pytest.approx(
        share * math.pi * rod.small_end_bore * rod.small_end_width, rel=1e-9
    )
    assert set(areas) == {*mirror.planes, Surface.BIG_END_BORE, Surface.SMALL_END_BORE, Surface.FREE}
    for plane in mirror.planes:
        assert areas[plane] > 0


def test_a_fillet_that_vanishes_is_noticed(monkeypatch):
    with session():
        monkeypatch.setattr(gmsh.model.occ, "fillet", lambda bodies, edges, radii: [(3, bodies[0])])
        with pytest.raises(GeometryError, match=r"but the dimensions give"):
            build(LEON_2001)


def test_a_step_that_is_not_cut_is_noticed(monkeypatch):
    monkeypatch.setattr("geometry.solid.space_beside", lambda _rod: ())
    with session(), pytest.raises(GeometryError, match=r"mm³, but the dimensions give"):
        build(replace(LEON_2001, small_end_crown_width=15.0))


def test_a_flush_rod_has_no_steps_and_a_rectangular_one_no_pockets():
    width = LEON_2001.shank_width
    rod = replace(LEON_2001, big_end_width=width, small_end_width=width, shank_section="rectangular")
    with session():
        kinds = {feature.kind for feature in build(rod).features}
    assert kinds == {FeatureKind.BORE, FeatureKind.RING_FILLET}


def test_a_refusal_of_the_kernel_names_what_failed(monkeypatch):
    def refuse(*args):
        raise Exception("no")  # noqa: TRY002 - as gmsh does

    with session():
        monkeypatch.setattr(gmsh.model.occ, "fillet", refuse)
        with pytest.raises(GeometryError, match=r"could not round the pocket floor.*: no"):
            build(LEON_2001)
