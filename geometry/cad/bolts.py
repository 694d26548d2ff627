"""The bolts of an imported assembly: from its holes, its own bolts and nuts, and what the user says."""

from collections.abc import Sequence
from dataclasses import dataclass

import gmsh
import numpy as np

from geometry.arrays import Floats, vector
from geometry.assembly import PLAIN, ROOM, WIDER, BoltAxis, BoltSeat
from geometry.cad.joint import USUAL, BoltHole, Seat
from geometry.cad.shapes import recognised_faces
from geometry.errors import GeometryError, require
from geometry.faces import edge_points, solid_points
from geometry.holes import place_text

# A round seat that a head covers to this part of its radius counts as covered.
_WHOLE = 0.9
# Length of an engaged thread over the hole's diameter, where nothing shows it.
_ENGAGED = 1.5
# The rod's hole is that of a nut's bolt, not of a thread, if it has at least this part of the cap's width.
_ALIKE = 0.97
# Ratio of the sizes of bolts that count as alike.
_SAME_SIZE = 1.01
# Relative difference of lengths that are meant to be the same.
_SAME_GRIP = 1e-3
# Of coordinates, which the kernel turned and moved.
_DIGITS = 12
# A fastener's axis is that of its hole within this part of the hole's radius.
_ALONG_ONE_AXIS = 0.2


@dataclass(frozen=True, eq=False)
class Fastener:
    """A solid that may be a bolt, a nut or a washer."""

    points: Floats  #: (n, 3) along its edges, mm
    planes: tuple[Floats, ...]  #: per plane face, points (n, 3) along its edges, mm

    def is_in(self, hole: BoltHole) -> bool:
        """Whether its axis is that of a hole."""
        middle = (self.points.min(axis=0) + self.points.max(axis=0)) / 2
        return bool(hole.beside(middle[None])[0] < _ALONG_ONE_AXIS * hole.radius)

    def contact(self, hole: BoltHole, level: float) -> float | None:
        """Outer radius, mm, of its plane face wider than the hole there; of a hexagon the inscribed one."""
        radii = []
        for points in self.planes:
            beside = hole.beside(points)
            at_level = np.abs(hole.along(points) - level).max() < 0.05 * hole.radius
            if at_level and beside.max() > 1.05 * hole.radius:
                radii.append(float(beside[beside > (beside.min() + beside.max()) / 2].min()))
        return max(radii, default=None)


def removed(volumes: Sequence[int]) -> list[Fastener]:
    """Measure solids and take them out of the model."""
    fasteners = []
    for volume in volumes:
        planes = [face.tag for face in recognised_faces((volume,)) if face.shape == "Plane"]
        fasteners.append(Fastener(solid_points(volume), tuple(map(edge_points, planes))))
    gmsh.model.occ.remove([(3, volume) for volume in volumes], recursive=True)
    gmsh.model.occ.synchronize()
    return fasteners


def bolts_in(
    holes: Sequence[BoltHole], fasteners: Sequence[Fastener], given: BoltSeat | None
) -> tuple[tuple[BoltAxis, ...], tuple[str, ...]]:
    """Return the bolts in holes through the joint, and what was assumed about them.

    The fasteners of one hole stand for all; a given length of 0 says nothing. Raises `GeometryError`: no hole
    through the joint, or no seat for a head; `InvalidValue`: what is given does not fit the holes.
    """
    if not holes:
        raise GeometryError(
            "no hole for a bolt runs through the joint of rod and cap: a round hole square to the joint must "
            "lead through the cap and go on in the rod. Correct the CAD file"
        )
    sizes = [hole.radius for hole in holes]
    if max(sizes) > _SAME_SIZE * min(sizes):
        listed = "; ".join(f"{2 * hole.radius:.4g} mm at {place_text(hole.center)}" for hole in holes)
        raise GeometryError(
            f"the holes through the joint differ in size, but the bolts of a cap must be alike: {listed}. "
            "Close those that are not for bolts in the CAD program"
        )
    pattern = next((hole for hole in holes if any(fastener.is_in(hole) for fastener in fasteners)), holes[0])
    shown = [fastener for fastener in fasteners if fastener.is_in(pattern)]
    dimensions = _BoltDimensions(pattern, shown, given or BoltSeat(head_diameter=0.0, grip=0.0))
    bolts = []
    for hole in holes:
        if hole.head is None:
            raise GeometryError(
                f"the hole of diameter {2 * hole.radius:.4g} mm through the joint at "
                f"{place_text(hole.center)} has no plane seat around it for the head of its bolt, square to "
                "the hole. Add one to the cap in the CAD program"
            )
        bolts.append(dimensions.bolt(hole, hole.head))
    notes = [*dimensions.assumed]
    grips = [bolt.grip for bolt in bolts]
    if max(grips) > _SAME_SIZE * min(grips):
        listed = f"({', '.join(f'{grip:.4g}' for grip in grips)} mm)"
        notes.append(f"the bolts have different grips {listed}; each is taken to be as stiff as the first")
    return tuple(bolts), tuple(notes)


class _BoltDimensions:
    """Dimensions of all bolts: given, of the fasteners in one hole (the pattern), or in usual proportions."""

    def __init__(self, pattern: BoltHole, fasteners: Sequence[Fastener], given: BoltSeat) -> None:
        self._pattern, self._fasteners, self._given = pattern, fasteners, given
        self.assumed: dict[str, None] = {}  # what neither user nor fasteners give, in words

    def bolt(self, hole: BoltHole, head: Seat) -> BoltAxis:
        radius = self._head(hole, head)
        nut = None if self._given.engaged else self._nut(hole, head)
        if nut is not None and hole.nut is not None:
            first = last = -hole.nut.level
        else:
            first, last = self._thread(hole, head)
        return BoltAxis(
            point=vector(hole.center.round(_DIGITS) + 0.0),
            direction=vector(hole.direction.round(_DIGITS) + 0.0),
            hole_radius=hole.radius,
            head=head.level,
            head_radius=radius,
            thread_radius=hole.rod_radius,
            nut_radius=nut or 0.0,
            grip_end=first,
            engaged=first - last,
        )

    def _assume(self, text: str) -> None:
        self.assumed[text] = None

    def _contact(self, level: float) -> float | None:
        radii = (fastener.contact(self._pattern, level) for fastener in self._fasteners)
        return next((radius for radius in radii if radius is not None), None)

    def _head(self, hole: BoltHole, head: Seat) -> float:
        if diameter := self._given.head_diameter:
            _require_room("assembly.bolt_head_mm", diameter, head, "head")
            return diameter / 2
        shown = None if self._pattern.head is None else self._contact(self._pattern.head.level)
        radius = _within(USUAL * hole.radius if shown is None else shown, head)
        if shown is None:
            self._assume(
                f"the bolts' heads, which the file does not show, press on {2 * radius:.4g} mm in diameter "
                "(assembly.bolt_head_mm)"
            )
        return radius

    def _nut(self, hole: BoltHole, head: Seat) -> float | None:
        """Radius of the nut's seat; None for a screw."""
        given, key = self._given, "assembly.bolt_nut_mm"
        if hole.nut is None or self._pattern.nut is None:
            rule = "the rod's holes have no plane seats around their ends for nuts"
            remedy = "Give assembly.bolt_engaged_mm."
            require(not given.nut_diameter, key, given.nut_diameter, rule, remedy)
            return None
        between = head.level + hole.nut.level
        fits = abs(given.grip - between) < _SAME_GRIP * between
        if given.nut_diameter:
            _require_room(key, given.nut_diameter, hole.nut, "nut")
            rule = f"the seats of head and nut are {between:.5g} mm apart in the file"
            require(not given.grip or fits, "assembly.bolt_grip_mm", given.grip, rule, "Leave it out.")
            return given.nut_diameter / 2
        if given.grip and not fits:
            return None
        shown = self._contact(-self._pattern.nut.level)
        if shown is not None:
            return _within(shown, hole.nut)
        if self._fasteners or hole.rod_radius < _ALIKE * hole.radius:
            return None
        radius = _within(USUAL * hole.radius, hole.nut)
        self._assume(
            f"the bolts have nuts on seats of {2 * radius:.4g} mm in diameter, because the rod's holes have "
            "plane ends (assembly.bolt_nut_mm or assembly.bolt_engaged_mm)"
        )
        return radius

    def _thread(self, hole: BoltHole, head: Seat) -> tuple[float, float]:
        given, (low, high) = self._given, hole.rod_wall
        top = min(high, -2 * PLAIN * hole.radius)
        first = head.level - given.grip if given.grip else top
        rule = (
            f"the thread must begin in the rod's hole, {head.level - top:.5g} to {head.level - low:.5g} mm "
            "from the head's seat"
        )
        require(low < first <= top + _SAME_GRIP * hole.radius, "assembly.bolt_grip_mm", given.grip, rule)
        if given.engaged:
            rule = f"the thread must end in the rod's hole, {first - low:.4g} mm beyond the grip"
            fits = given.engaged <= (first - low) * (1 + _SAME_GRIP)
            require(fits, "assembly.bolt_engaged_mm", given.engaged, rule)
            return first, max(first - given.engaged, low)
        if self._fasteners:
            ends = [float(self._pattern.along(fastener.points).min()) for fastener in self._fasteners]
            if (last := max(low, min(ends))) < first:
                return first, last
            raise GeometryError(
                f"the bolt in the hole at {place_text(hole.center)} has no nut and ends before a thread in "
                "the rod. Correct the CAD file, or give assembly.bolt_grip_mm and bolt_engaged_mm"
            )
        last = max(low, first - 2 * _ENGAGED * hole.radius)
        self._assume(
            f"the bolts' threads engage over {first - last:.4g} mm from {-first:.3g} mm behind the joint "
            "(assembly.bolt_grip_mm, assembly.bolt_engaged_mm)"
        )
        return first, last


def _require_room(key: str, diameter: float, seat: Seat, what: str) -> None:
    least, most = 2 * seat.inner, 2 * seat.outer
    rule = f"the plane seat of the {what} in the file reaches from {least:.4g} to {most:.4g} mm in diameter"
    require(least < diameter <= most, key, diameter, rule)


def _within(radius: float, seat: Seat) -> float:
    if seat.round and radius > _WHOLE * seat.outer:
        return seat.outer  # rather than a thin rim around the head
    reduced = min(radius, ROOM * seat.outer)
    if reduced < WIDER * seat.inner:
        raise GeometryError(
            f"a bolt's seat of {2 * seat.inner:.4g} to {2 * seat.outer:.4g} mm in diameter is too narrow to "
            "press on. Correct the CAD file"
        )
    return reduced
