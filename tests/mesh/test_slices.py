"""Sections cut out of a mesh against closed forms and against the dimensions."""

from dataclasses import replace

import numpy as np
import pytest

from fea.analysis.pipeline import prepare
from fea.judge.column import Plane, column
from fea.study.flags import Flags
from fea.study.study import load_study
from fea.verify.cases.dynamics import HEIGHT, WIDTH, strut
from mesh.slices import sections


def test_sections_of_a_bar_are_those_of_its_rectangle():
    # A quarter of it is meshed: b × h halved each way, moments about the quarter's own centre.
    mesh = strut(16.0)
    for found in sections(mesh, [0.1, 300.0, 431.7]):
        width, height = WIDTH / 2, HEIGHT / 2
        assert found.area == pytest.approx(width * height)
        assert found.inertia_z == pytest.approx(height * width**3 / 12)
        assert found.inertia_y == pytest.approx(width * height**3 / 12)


def test_a_plane_beside_the_mesh_is_refused():
    with pytest.raises(ValueError, match="misses the mesh"):
        sections(strut(16.0), [700.0])


def test_a_rod_without_dimensions_has_the_sections_of_its_mesh():
    rod = prepare(Flags(size=6.0, pressure="cosine-180").applied(load_study("leon-2001")))
    unknown = replace(rod.study, rod=replace(rod.study.rod, dimensions=None))
    (exact, least), (cut, narrowest) = rod.shank, replace(rod, study=unknown).shank
    assert narrowest.area == pytest.approx(least.area, rel=2e-3)
    middle = [i for i, section in enumerate(exact) if 45 < section.x < 115]
    for name in ("area", "inertia_y", "inertia_z"):
        pairs = np.array([(getattr(exact[i], name), getattr(cut[i], name)) for i in middle])
        # Chords across the concave fillets at the rings add most.
        np.testing.assert_allclose(pairs[:, 1], pairs[:, 0], rtol=0.02, err_msg=name)
        np.testing.assert_allclose(pairs[10:40, 1], pairs[10:40, 0], rtol=2e-3, err_msg=name)
    for plane in Plane:
        loads = [column(plane, *found, 207e3, 600.0).euler for found in ((exact, least), (cut, narrowest))]
        assert loads[1] == pytest.approx(loads[0], rel=3e-3)
