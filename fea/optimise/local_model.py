"""What the designs tried so far say of those near them.

Mass and margins are taken as linear in the dimensions about a design. They are fitted by weighted least
squares to all designs near it; those of one mesh have an offset in common, which is a random effect (Laird &
Ware 1982, Biometrics 38, 963), so that what meshes scatter by is averaged out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fea.optimise.designs import Design
from geometry.arrays import Floats

# Scaled distance at which a design counts 1/e of one at the centre, and beyond which it does not count.
_NEAR, _FAR = 0.12, 0.4
# What the model of one mesh errs by, over what meshes scatter by, and over what margins change by from one
# bound of a dimension to the other: no design may tell a slope, which is nothing then.
_OF_MESHES, _OF_SLOPES = 0.3, 0.01


@dataclass(frozen=True)
class LocalModel:
    """Mass and margins near a design, linear in the dimensions.

    Attributes
    ----------
    centre
        (n,) scaled dimensions.
    values, slopes
        (1 + k,) and (1 + k, n) of the mass, relative to that of the centre, and of each margin, on the mean
        of meshes.
    """

    centre: Floats
    values: Floats
    slopes: Floats

    @classmethod
    def of(cls, tried: Sequence[Design], about: Design) -> "LocalModel":
        """Fit the model about a design to those near it, which have the same limits."""
        names = [limit.name for limit in about.limits]
        known = [{limit.name: limit.margin for limit in design.limits} for design in tried]
        near = [
            (design, margins)
            for design, margins in zip(tried, known, strict=True)
            if np.linalg.norm(design.x - about.x) <= _FAR and margins.keys() >= set(names)
        ]
        away = np.array([design.x - about.x for design, _ in near])
        values = np.array(
            [[design.mass_kg / about.mass_kg, *(margins[name] for name in names)] for design, margins in near]
        )
        meshes = np.unique([design.mesh for design, _ in near])
        of_mesh = np.array([[design.mesh == mesh for mesh in meshes] for design, _ in near], dtype=float)
        weight = np.exp(-0.5 * (np.linalg.norm(away, axis=1) / _NEAR) ** 2)[:, None]
        n, m = away.shape[1], len(meshes)
        matrix = np.hstack([np.ones((len(near), 1)), away, of_mesh])
        penalty = np.diag([0.0, *[_OF_SLOPES] * n, *[_OF_MESHES] * m])[1:]
        found = np.linalg.lstsq(
            np.vstack([weight * matrix, penalty]),
            np.vstack([weight * values, np.zeros((n + m, values.shape[1]))]),
            rcond=None,
        )[0]
        return cls(about.x, found[0], found[1 : n + 1].T)

    def at(self, x: Floats) -> tuple[float, Floats]:
        """Return mass and margins (k,) of a design (n,)."""
        mass, *margins = self.values + self.slopes @ (x - self.centre)
        return float(mass), np.array(margins)
