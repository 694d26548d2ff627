"""Cook's membrane with ν = 0.4999 in plane strain on finer and finer meshes: deflection of its corner.

The target is that of the benchmark `cook`; the corners of both vertical edges are singular.
"""

from fea.verify.cases.cook import INCOMPRESSIBLE, NEARLY_NOT, membrane, meshed, rise
from fea.verify.stability.incompressible import beyond
from fea.verify.stability.pair import solved_pair
from fea.verify.stability.row import ExtremeRow
from fea.verify.stability.solved import percent, solved

SIZES = (12.0, 6.0, 3.0)
METHODS = ("p1", "p2", "p2/p1")


def rows() -> list[ExtremeRow]:
    """Each method on the same sizes."""
    return [_row(method, size) for method in METHODS for size in SIZES]


def _row(method: str, size: float) -> ExtremeRow:
    body = membrane(meshed(size, order=1 if method == "p1" else 2))
    if method == "p2/p1":
        result = solved_pair(body.mesh, NEARLY_NOT, body.forces, body.fixed).solved
    else:
        result = solved(body.mesh, NEARLY_NOT, body.forces, body.fixed)
    error = percent(rise(body.mesh, result.displacement), INCOMPRESSIBLE.target)
    name, tolerance = f"Cook's membrane, ν = 0.4999, {method}", INCOMPRESSIBLE.tolerance_percent
    return result.row(
        name, "mm", size, error, tolerance, noticed_by=beyond(method, NEARLY_NOT.poissons_ratio)
    )
