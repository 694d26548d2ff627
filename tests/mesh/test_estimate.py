import pytest

from geometry.presets import PRESETS
from geometry.session import session
from geometry.solid import build
from mesh.generate import tetrahedralise
from mesh.sizing import Sizing, default_size, estimate, refinements


@pytest.mark.parametrize("name", ["leon-2001", "forsa-g10"])
@pytest.mark.parametrize("factor", [1.0, 0.6])
def test_the_estimate_comes_near_what_gmsh_makes(name, factor):
    rod = PRESETS[name]
    with session():
        solid = build(rod)
        size = factor * default_size(rod.length)
        refined = refinements(solid.features, size, rod.length)
        expected = estimate(refined, Sizing(size))
        mesh, _ = tetrahedralise(solid.faces, refined, Sizing(size))
    assert len(mesh.tets) == pytest.approx(expected, rel=0.15)
