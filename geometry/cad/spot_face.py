"""Plane seats cut around bolt holes that end on slanted or rounded faces."""

from collections.abc import Sequence
from dataclasses import replace

import gmsh
import numpy as np

from geometry import kernel
from geometry.cad.bolt_holes import BoltHole
from geometry.cad.edges import solid_points
from geometry.cad.holes import place_text
from geometry.cad.seats import Seat
from geometry.errors import GeometryError

# Radius of the seat over the hole's: the usual one (hexagons and cylinders of M8 to M12: 1.4 to 1.6), the
# least, and the step between those that are tried.
USUAL, _LEAST, _STEP = 1.5, 1.2, 0.05
# Depth of the cut where it is shallowest, over the hole's radius; least level over the height of the hole;
# levels that differ by less, over the hole's radius, become one.
_DEPTH, _LOWEST, _ALIKE = 0.1, 0.3, 0.2


def spot_faced(cap: int, holes: Sequence[BoltHole], wanted: float | None) -> tuple[int, list[BoltHole]]:
    """Cut plane seats for heads around the ends of those holes in a cap that have none.

    Parameters
    ----------
    cap
        Its volume tag; it is used up.
    holes
        Through the joint.
    wanted
        Radius of the seats, mm; None for the usual one, or less where the cap is narrow.

    Returns
    -------
    int, list of BoltHole
        The new volume, and the holes, all with seats.

    Raises
    ------
    GeometryError
        There is no material for a seat.
    """
    bare = [hole for hole in holes if hole.head is None]
    seats = [_seat(cap, hole, wanted) for hole in bare]
    if not seats:
        return cap, list(holes)
    radius = min(seat.outer for seat in seats)
    lowest = min(seat.level for seat in seats)
    found = {}
    for hole, seat in zip(bare, seats, strict=True):
        level = lowest if seat.level - lowest < _ALIKE * hole.radius else seat.level
        found[id(hole)] = Seat(level, hole.radius, radius, round=True)
    with kernel.attempt("cut seats for the bolts' heads into the cap"):
        cap = kernel.cut(cap, [_tool(hole, found[id(hole)]) for hole in bare])
        gmsh.model.occ.synchronize()
    return cap, [
        replace(hole, head=found[id(hole)], cap_end=found[id(hole)].level) if id(hole) in found else hole
        for hole in holes
    ]


def _seat(cap: int, hole: BoltHole, wanted: float | None) -> Seat:
    """The highest seat of the largest radius for which there is material."""
    usual = np.arange(USUAL, _LEAST, -_STEP) * hole.radius
    radii = usual.tolist() if wanted is None else [wanted]
    for radius in radii:
        level = _level(cap, hole, radius)
        if level > _LOWEST * hole.cap_end:
            return Seat(level, hole.radius, radius, round=True)
    raise GeometryError(
        f"the cap has no plane seat for the head of the bolt at {place_text(hole.point)}, and no material "
        f"around its hole of {2 * hole.radius:.4g} mm to cut one of {2 * radii[-1]:.4g} mm. Add a seat in "
        "the CAD program"
    )


def _level(cap: int, hole: BoltHole, radius: float) -> float:
    """Position below which a cylinder around the hole lies in the material, mm."""
    occ = gmsh.model.occ
    core, inner = (
        occ.addCylinder(*hole.point, *(1.1 * hole.cap_end * hole.direction), r)
        for r in (radius, 1.01 * hole.radius)
    )
    with kernel.attempt("look for a seat for a bolt's head on the cap"):
        tube, _ = occ.cut([(kernel.SOLID, core)], [(kernel.SOLID, inner)])
        void, _ = occ.cut(tube, [(kernel.SOLID, cap)], removeTool=False)
        occ.synchronize()
    # A round or a chamfer of the hole's edge at the joint is no end of the material.
    lowest = [float(hole.along(solid_points(tag)).min()) for dim, tag in void if dim == kernel.SOLID]
    tops = [float(hole.along(solid_points(tag)).max()) for dim, tag in void if dim == kernel.SOLID]
    occ.remove(void, recursive=True)
    occ.synchronize()
    ends = [low for low, top in zip(lowest, tops, strict=True) if top > _LOWEST * hole.cap_end]
    return min(ends, default=hole.cap_end) - _DEPTH * hole.radius


def _tool(hole: BoltHole, seat: Seat) -> int:
    start = hole.point + seat.level * hole.direction
    height = 2 * (hole.cap_end - seat.level) + 4 * seat.outer
    return int(gmsh.model.occ.addCylinder(*start, *(height * hole.direction), seat.outer))
