"""Lamé's cylinder from ν = 0.3 to 0.499999: displacement elements lock or have a meaningless mean stress.

Compared are displacement elements of both orders, and Taylor–Hood elements with a separate pressure, which
`fea run` uses above the limit of second-order displacement elements, by the displacement and the stress at
every node.
"""

from dataclasses import replace

import numpy as np

from fea.base.checks import LIMITS, check
from fea.base.material import Material
from fea.stress.recovery import Recovery
from fea.verify.body import STEEL, LoadedBody, mirror_planes
from fea.verify.cases.lame import INSIDE, OUTSIDE, PRESSURE, loaded
from fea.verify.stability.pair import solved_pair
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import Solved, solved
from geometry.arrays import Floats

RATIOS = (0.3, 0.4, 0.45, 0.49, 0.499, 0.4999, 0.49999, 0.499999)
METHODS = ("p1", "p2", "p2/p1")
# For the displacement at any node, relative to that of the bore, and for any stress component at any node,
# relative to the hoop stress of the bore, on these coarse meshes.
TOLERANCE_PERCENT = {"p1": (3.0, 20.0), "p2": (0.1, 2.0), "p2/p1": (0.1, 2.0)}
_SIZE = {"p1": 1.5, "p2": 2.0, "p2/p1": 2.0}
_A2, _B2 = INSIDE**2, OUTSIDE**2


def rows() -> list[ExtremeRow]:
    """Displacement, then stress, of each method; marked above the limits of `fea.base.checks`."""
    return [row for method in METHODS for row in _rows(method)]


def _rows(method: str) -> list[ExtremeRow]:
    body = loaded(_SIZE[method], order=1 if method == "p1" else 2)
    moved: list[ExtremeRow] = []
    stressed: list[ExtremeRow] = []
    for ratio in RATIOS:
        material = replace(STEEL, poissons_ratio=ratio)
        result, pressure = _solved(method, body, material)
        noticed = beyond(method, ratio)
        u, stress = result.displacement, _stress(body, material, result, pressure)
        errors = _errors(body.mesh.points, material, u, stress)
        for found, what, error, tolerance in zip(
            (moved, stressed), ("displacement", "stress"), errors, TOLERANCE_PERCENT[method], strict=True
        ):
            name = f"near-incompressible {what}, {method}"
            found.append(result.row(name, "ν", ratio, error, tolerance, noticed_by=noticed))
    return moved + stressed


def beyond(method: str, ratio: float) -> tuple[str, ...]:
    """Return the failing check of a run, for `ExtremeRow.noticed_by`."""
    name = f"poissons_ratio_{method}"
    return () if name not in LIMITS or check(name, ratio).passed else (name,)


def _solved(method: str, body: LoadedBody, material: Material) -> tuple[Solved, Floats | None]:
    if method == "p2/p1":
        pair = solved_pair(body.mesh, material, body.forces, body.fixed)
        return pair.solved, pair.pressure
    return solved(body.mesh, material, body.forces, body.fixed), None


def _stress(body: LoadedBody, material: Material, result: Solved, pressure: Floats | None) -> Floats:
    """Stress, recovered as in a run: (n_nodes, 6), MPa."""
    recovery = Recovery(body.mesh, mirror_planes(body.mesh), body.known)
    u = result.displacement[:, :, None]
    return recovery.nodal_stress(u, material, traction=body.traction, pressure=pressure)[:, :, 0]


def _errors(points: Floats, material: Material, u: Floats, stress: Floats) -> tuple[float, float]:
    """Largest errors of displacement and stress over the nodes, %."""
    exact_u, exact_stress = exact(points, material)
    widening = np.abs(exact_u).max()
    hoop = PRESSURE * (_A2 + _B2) / (_B2 - _A2)
    return (
        100 * float(np.abs(u - exact_u).max() / widening),
        100 * float(np.abs(stress - exact_stress).max() / hoop),
    )


def exact(points: Floats, material: Material) -> tuple[Floats, Floats]:
    """Displacement (n, 3), mm, and stress (n, 6), MPa, at places (n, 3): Timoshenko & Goodier 1970, § 28."""
    x, y, _ = points.T
    r = np.hypot(x, y)
    c, s, none = x / r, y / r, np.zeros_like(r)
    unit, nu = PRESSURE * _A2 / (_B2 - _A2), material.poissons_ratio
    radial, hoop = unit * (1 - _B2 / r**2), unit * (1 + _B2 / r**2)
    widening = (1 + nu) / material.youngs_modulus * unit * ((1 - 2 * nu) * r + _B2 / r)
    stress = [
        radial * c * c + hoop * s * s,
        radial * s * s + hoop * c * c,
        nu * (radial + hoop),
        (radial - hoop) * c * s,
        none,
        none,
    ]
    return np.stack([widening * c, widening * s, none], axis=1), np.stack(stress, axis=1)
