import pytest
from rod_studies import random_rod

from fea.solid.inertia import inertia
from geometry.dimensions import dimensions
from geometry.errors import InvalidValue
from geometry.session import session
from geometry.solid import build
from mesh.generate import tetrahedralise
from mesh.sizing import Sizing, default_size, refinements


@pytest.mark.parametrize("seed", range(30))
def test_a_random_rod_meshes_or_is_refused_by_name(seed):
    rod = random_rod(seed)
    if isinstance(rod, InvalidValue):
        assert rod.name.removeprefix("rod.").removesuffix("_mm") in dimensions()
        return
    with session():
        solid = build(rod)
        size = default_size(rod.length)
        mesh, quality = tetrahedralise(
            solid.faces, refinements(solid.features, size, rod.length), Sizing(size)
        )
    assert quality.least_scaled_jacobian > 0
    assert inertia(mesh, 1.0).properties.mass == pytest.approx(solid.mass.mass, rel=1e-3)
