"""The bolts of an imported assembly: from its holes, its own bolts and nuts, and what the user says."""

from collections.abc import Sequence
from dataclasses import dataclass

from geometry.assembly import BoltAxis, BoltSeat
from geometry.cad.bolt_holes import USUAL, BoltHole, Fastener, Seat
from geometry.cad.holes import place_text
from geometry.errors import GeometryError, require

# Largest and least part of the room for a seat that is used.
_ROOM, _WIDER = 0.98, 1.1
# A round seat that a head covers to this part of its radius counts as covered.
_WHOLE = 0.9
# Length of an engaged thread over the hole's diameter, where nothing tells it; distance of the first thread
# from the joint, over the hole's diameter.
_ENGAGED, _PLAIN = 1.5, 0.05
# The hole in the rod is that of a nut's bolt, rather than a thread's, if it is not narrower than this part of
# the cap's.
_ALIKE = 0.97

# Ratio of the sizes of bolts that count as alike.
_SAME_SIZE = 1.01
# Relative difference of lengths that are meant to be the same.
_SAME_GRIP = 1e-3
# Of coordinates, which the kernel turned and moved.
_DIGITS = 12


@dataclass(frozen=True)
class FoundSeats:
    """What a bolt presses on."""

    # head_radius, nut_radius: mm; 0 without a nut
    head_radius: float
    nut_radius: float
    # grip_end, engaged: as of `BoltAxis`
    grip_end: float
    engaged: float


def found_bolts(
    holes: Sequence[BoltHole], fasteners: Sequence[Fastener], given: BoltSeat | None
) -> tuple[tuple[BoltAxis, ...], tuple[str, ...]]:
    """Return the bolts and what was assumed about them.

    Parameters
    ----------
    holes
        Through the joint.
    fasteners
        Of the file; those of one hole stand for all.
    given
        What the user says of the bolts, where a length of 0 says nothing; the file tells the rest.

    Raises
    ------
    GeometryError
        No hole runs through the joint, or one has no plane seat for the head.
    InvalidValue
        What is given does not fit the holes.
    """
    if not holes:
        raise GeometryError(
            "no hole for a bolt runs through the joint of rod and cap: a round hole square to the joint must "
            "lead through the cap and go on in the rod. Correct the CAD file"
        )
    _require_alike(holes)
    pattern = next((hole for hole in holes if any(one.is_in(hole) for one in fasteners)), holes[0])
    own = [one for one in fasteners if one.is_in(pattern)]
    clues = _Clues(pattern, own, given or BoltSeat(head_diameter=0.0, grip=0.0))
    bolts = []
    for hole in holes:
        head = _required(hole)
        found = clues.seats(hole, head)
        x, y, z = (hole.point.round(_DIGITS) + 0.0).tolist()
        u, v, w = (hole.direction.round(_DIGITS) + 0.0).tolist()
        bolts.append(
            BoltAxis(
                point=(x, y, z),
                direction=(u, v, w),
                hole_radius=hole.radius,
                head=head.level,
                grip_end=found.grip_end,
                engaged=found.engaged,
                head_radius=found.head_radius,
                nut_radius=found.nut_radius,
                thread_radius=hole.rod_radius,
            )
        )
    return tuple(bolts), (*clues.assumed, *_unequal(bolts))


def _require_alike(holes: Sequence[BoltHole]) -> None:
    """Refuse holes of different sizes: the bolts of a cap are alike."""
    sizes = [hole.radius for hole in holes]
    if max(sizes) > _SAME_SIZE * min(sizes):
        listed = "; ".join(f"{2 * hole.radius:.4g} mm at {place_text(hole.point)}" for hole in holes)
        raise GeometryError(
            f"the holes through the joint differ in size, but the bolts of a cap must be alike: {listed}. "
            "Close those that are not for bolts in the CAD program"
        )


def _unequal(bolts: Sequence[BoltAxis]) -> list[str]:
    """Say that the bolts are not equally long, if they are not."""
    grips = [bolt.grip for bolt in bolts]
    if max(grips) <= _SAME_SIZE * min(grips):
        return []
    listed = ", ".join(f"{grip:.4g}" for grip in grips)
    return [f"the bolts have different grips ({listed} mm); each is taken to be as stiff as the first"]


def _required(hole: BoltHole) -> Seat:
    if hole.head is None:
        raise GeometryError(
            f"the hole of diameter {2 * hole.radius:.4g} mm through the joint at {place_text(hole.point)} "
            "has no plane seat around it for the head of its bolt, square to the hole. Add one to the cap "
            "in the CAD program"
        )
    return hole.head


class _Clues:
    """What the user and the fasteners of one hole tell about all bolts.

    Parameters
    ----------
    pattern
        The hole that the fasteners are in.
    fasteners, given
        As for `found_bolts`.

    Attributes
    ----------
    assumed
        What neither tells, in words.
    """

    def __init__(self, pattern: BoltHole, fasteners: Sequence[Fastener], given: BoltSeat) -> None:
        self._pattern, self._fasteners, self._given = pattern, fasteners, given
        self.assumed: dict[str, None] = {}

    def seats(self, hole: BoltHole, head: Seat) -> FoundSeats:
        """What the bolt in a hole presses on."""
        radius, given = self._head(hole, head), self._given
        nut = None if given.engaged else self._nut(hole, head)
        if nut is not None and hole.nut is not None:
            return FoundSeats(radius, nut, -hole.nut.level, 0.0)
        first, last = self._thread(hole, head)
        return FoundSeats(radius, 0.0, first, first - last)

    def _assume(self, text: str) -> None:
        self.assumed[text] = None

    def _contact(self, level: float) -> float | None:
        """Radius of a fastener's plane face at a position along its hole."""
        radii = (one.contact(self._pattern, level) for one in self._fasteners)
        return next((radius for radius in radii if radius is not None), None)

    def _head(self, hole: BoltHole, head: Seat) -> float:
        """Radius of the head's seat."""
        if diameter := self._given.head_diameter:
            _require_room("assembly.bolt_head_mm", diameter, head, "head")
            return diameter / 2
        shown = None if self._pattern.head is None else self._contact(self._pattern.head.level)
        radius = _fitted(USUAL * hole.radius if shown is None else shown, head)
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
            return _fitted(shown, hole.nut)
        if self._fasteners or hole.rod_radius < _ALIKE * hole.radius:
            return None
        radius = _fitted(USUAL * hole.radius, hole.nut)
        self._assume(
            f"the bolts have nuts on seats of {2 * radius:.4g} mm in diameter, because the rod's holes have "
            "plane ends (assembly.bolt_nut_mm or assembly.bolt_engaged_mm)"
        )
        return radius

    def _thread(self, hole: BoltHole, head: Seat) -> tuple[float, float]:
        """Positions of the first and the last thread that engage."""
        given, (low, high) = self._given, hole.rod_wall
        top = min(high, -2 * _PLAIN * hole.radius)
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
            last = max(low, min(one.end(self._pattern) for one in self._fasteners))
            if last < first:
                return first, last
            raise GeometryError(
                f"the bolt in the hole at {place_text(hole.point)} has no nut and ends before a thread in "
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


def _fitted(radius: float, seat: Seat) -> float:
    """Reduce a radius to the room on a seat."""
    if seat.round and radius > _WHOLE * seat.outer:
        return seat.outer  # rather than a thin rim around the head
    fitted = min(radius, _ROOM * seat.outer)
    if fitted < _WIDER * seat.inner:
        raise GeometryError(
            f"a bolt's seat of {2 * seat.inner:.4g} to {2 * seat.outer:.4g} mm in diameter is too narrow to "
            "press on. Correct the CAD file"
        )
    return fitted
