"""Two materials in series: a bar in tension, whose parts elongate by F L / (E A) each."""

from dataclasses import replace

import numpy as np

from fea.base.material import Materials
from fea.solid.traction import traction_forces
from fea.verify.body import STEEL, held
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import percent, solved
from geometry.bodies import Prism, polygon
from geometry.surfaces import Surface
from mesh.generate import mesh_body

LENGTH, HALF = 20.0, 2.0
CONTRASTS = (1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9)
# The exact field is linear in each part, so that only rounding errors remain, which grow with the contrast.
TOLERANCE_PERCENT = 1e-4


def rows() -> list[ExtremeRow]:
    """The far half is `value` times as stiff as the near one; ν = 0, so that there is no lateral strain."""
    corners = (
        ((0.0, 0.0), Surface.FREE),
        ((HALF, 0.0), Surface.FREE),
        ((HALF, HALF), Surface.FREE),
        ((0.0, HALF), Surface.FREE),
    )
    bar = Prism(polygon(*corners), (0.0, LENGTH / 2, LENGTH), Surface.CLAMPED, Surface.LOADED)
    mesh = mesh_body(bar, HALF)
    far = (mesh.points[mesh.tets[:, :4], 2].mean(axis=1) > LENGTH / 2).astype(np.int64)
    fixed = held(mesh, {Surface.CLAMPED: (0, 1, 2)})
    forces = traction_forces(mesh, Surface.LOADED, lambda _, normals: normals)
    soft = replace(STEEL, poissons_ratio=0.0)
    end = np.unique(mesh.facets[Surface.LOADED])
    found = []
    for contrast in CONTRASTS:
        stiff = replace(soft, youngs_modulus=contrast * soft.youngs_modulus)
        result = solved(mesh, Materials((soft, stiff), far), forces, fixed)
        exact = LENGTH / 2 / soft.youngs_modulus * (1 + 1 / contrast)
        error = max(percent(value, exact) for value in result.displacement[end, 2])
        found.append(result.row("material contrast", "E₂/E₁", contrast, error, TOLERANCE_PERCENT))
    return found
