"""An imported solid moved into the rod's frame."""

from collections.abc import Sequence

import gmsh
import numpy as np

from geometry import kernel
from geometry.cad.cylinders import ROUND
from geometry.cad.holes import Hole
from geometry.faces import Bore
from geometry.frame import rod_frame


def placed(volumes: Sequence[int], big: Hole, small: Hole) -> tuple[Bore, Bore]:
    """Move the solid so that the big-end bore is the origin, x leads to the small end, z along the pins."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 - only imported solids need it

    frame, length = rod_frame(big.direction, small.center - big.center)
    turn = Rotation.from_matrix(frame).as_rotvec()
    angle = float(np.linalg.norm(turn))
    solids = [(kernel.SOLID, tag) for tag in volumes]
    with kernel.attempt("place the solid in the rod's frame"):
        gmsh.model.occ.translate(solids, *(-big.center))
        if angle > 1e-12:
            gmsh.model.occ.rotate(solids, 0, 0, 0, *(turn / angle), angle)
        gmsh.model.occ.synchronize()
    return (
        Bore(0.0, big.radius, big.mean_width, slack=_slack(big)),
        Bore(length, small.radius, small.mean_width, small.taper(frame[0]), slack=_slack(small)),
    )


def _slack(hole: Hole) -> float:
    """By how much the faces of a bore may differ from its cylinder, mm; 0 where all are the same cylinder."""
    exact = hole.deviation < 1e-6 * hole.radius and not hole.fitted
    return 0.0 if exact else 2 * (hole.deviation + ROUND * hole.radius)
