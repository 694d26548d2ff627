"""Cross-sections and mass properties by quadrature over the dimensions, without a CAD kernel."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import Floats, Mask
from geometry.dimensions import Dimensions
from geometry.mass import MassProperties
from geometry.outline import Outline, Pocket, slant_half_width, web_pocket
from geometry.rod import Rod
from geometry.segments import half_chord
from geometry.steps import RingStep, ring_steps

# Gauss points over the angle of a half circle: accurate also for arcs that end with a vertical tangent.
_ANGLES, _WEIGHTS = np.polynomial.legendre.leggauss(10)
_SHARES = (1 - np.cos((_ANGLES + 1) * math.pi / 2)) / 2
_TURN = 720  # angles of a whole circle
_SHARE_WEIGHTS = _WEIGHTS * np.sin((_ANGLES + 1) * math.pi / 2) * math.pi / 4


@dataclass(frozen=True)
class CrossSection:
    """The cross-section of a rod at `x`."""

    x: float  #: place, mm from the crank-pin centre
    area: float  #: mm²
    #: inertia_y, inertia_z: second moments about the axes through the centre, mm⁴: `inertia_z` resists
    #: bending in the plane of motion, `inertia_y` sideways
    inertia_y: float
    inertia_z: float


@dataclass(frozen=True)
class HeightField:
    """A rod as z = ±half_width(x, y) over its plan, with its sections and mass properties."""

    rod: Rod

    @cached_property
    def outline(self) -> Outline:
        """The plan."""
        return Outline(self.rod)

    @cached_property
    def pocket(self) -> Pocket | None:
        """The web pockets."""
        return web_pocket(self.rod, self.outline.edge) if self.rod.has_pockets else None

    @cached_property
    def steps(self) -> tuple[RingStep, RingStep]:
        """The ring steps."""
        return ring_steps(self.rod)

    @cached_property
    def chamfers(self) -> tuple[tuple[float, float, float], ...]:
        """Of each chamfered bore: x of its axis, outer radius of the chamfer, half the end's width; mm."""
        rod = self.rod
        ends = (
            (0.0, rod.big_end_bore, rod.big_end_chamfer, rod.big_end_width),
            (rod.length, rod.small_end_bore, rod.small_end_chamfer, rod.small_end_width),
        )
        return tuple((x, bore / 2 + size, width / 2) for x, bore, size, width in ends if size)

    def face(self, x: Floats, y: Floats) -> Floats:
        """Return z of the upper side faces at points of the plan, mm, without pockets and bores."""
        big, small = self.steps
        beside = np.arctan2(y, x) > self.outline.shank_sector  # the bosses and the ring between them
        z_big = np.where(beside, big.ring, big.half_width(np.hypot(x, y)))
        z = np.maximum(z_big, small.half_width(np.hypot(x - small.center, y)))
        if (boss := self.outline.bosses) is not None and boss.round:
            z = np.where(y > boss.top - boss.round, np.minimum(z, boss.half_width(y)), z)
        if (rib := self.outline.rib) is not None:
            z = np.where(self.on_rib(x, y), rib.side.half_width(np.hypot(x, y)), z)
        return np.minimum(z, slant_half_width(self.rod, x))

    def on_rib(self, x: Floats, y: Floats) -> Mask:
        """Whether points lie in the sector that holds the rib."""
        rib = self.outline.rib
        return np.arctan2(np.abs(y), -x) < (0.0 if rib is None else rib.sector)

    def half_width(self, x: Floats, y: Floats) -> Floats:
        """Return z of the upper surface at points of the plan, mm; 0 in the bores."""
        z = self.face(x, y)
        if self.pocket is not None and not self.pocket.in_sides:
            z = np.minimum(z, self.pocket.half_width(x, y))
        for bore in self.outline.bores:
            z = np.where(np.hypot(x - bore.center[0], y) < bore.radius, 0.0, z)
        for center, rim, half_width in self.chamfers:
            z = np.minimum(z, half_width - np.maximum(rim - np.hypot(x - center, y), 0.0))
        return z

    def void(self, x: Floats, y: Floats) -> Floats:
        """Half-height of the hollows that holes and pockets in the sides leave, mm."""
        rod, bosses = self.rod, self.outline.bosses
        z = np.where(x > rod.length, half_chord(rod.oil_hole / 2, y), 0.0)
        z = np.maximum(z, half_chord(self._drilled_radius(x), y))
        if self.pocket is not None and self.pocket.in_sides:
            z = np.maximum(z, self.pocket.half_height(x, np.abs(y)))
        if (rib := self.outline.rib) is not None:
            z = np.where(self.on_rib(x, y), rib.groove_depth(np.hypot(x, y)), z)
        if bosses is not None:
            bolt = half_chord(bosses.bolt_radius, y - bosses.bolt_at)
            z = np.maximum(z, np.where(np.abs(x) < bosses.half_length, bolt, 0.0))
        return z

    def _drilled_radius(self, x: Floats) -> Floats:
        """Radius at `x` of what is drilled along the rod's axis, mm."""
        rod = self.rod
        round_ = rod.shank_bore_round
        short = np.maximum(x - rod.shank_bore_end + round_, 0.0)
        bore = np.where(x < rod.shank_bore_end, rod.shank_bore / 2 - round_ + half_chord(round_, short), 0.0)
        return np.where((x > 0) & (x < rod.length), np.maximum(bore, rod.oil_gallery / 2), 0.0)

    def sections(self, x: Floats) -> tuple[CrossSection, ...]:
        """Integrate the sections at `x` (n,), mm."""
        area, second, cube = self._moments(x)
        figures = np.stack([x, 4 * area, 4 * cube / 3, 4 * second], axis=1)
        return tuple(CrossSection(*each) for each in figures.tolist())

    def section(self, x: float) -> CrossSection:
        """Integrate the section at `x` (mm)."""
        return self.sections(np.array([float(x)]))[0]

    def mass(self) -> MassProperties:
        """Integrate the mass properties for density 1 (the mass is the volume, mm³)."""
        x, weight = _nodes(self._stations())
        x, weight = x.ravel(), weight.ravel()
        area, second, cube = self._moments(x)
        volume = float(4 * weight @ area)
        center = float(4 * weight @ (area * x)) / volume
        xx = float(4 * weight @ (area * (x - center) ** 2))
        yy, zz = float(4 * weight @ second), float(4 * weight @ cube / 3)
        return _mirrored_body(volume, center, (xx, yy, zz))

    def bushing(self) -> MassProperties:
        """Integrate the mass properties of the bushing alone, for a rod that has one."""
        rod, angle = self.rod, (np.arange(_TURN) + 0.5) * 2 * math.pi / _TURN
        radius = rod.small_end_bore / 2 + rod.bushing * (_ANGLES[:, None] + 1) / 2
        x, y = rod.length + radius * np.cos(angle), radius * np.sin(angle)
        weight = _WEIGHTS[:, None] * radius * rod.bushing / 2 * (2 * math.pi / _TURN)
        z = self.half_width(x, y)
        void = np.minimum(self.void(x, y), z)
        solid = 2 * weight * (z - void)
        volume = float(solid.sum())
        center = float((solid * x).sum()) / volume
        xx, yy = float((solid * (x - center) ** 2).sum()), float((solid * y**2).sum())
        zz = float((2 / 3 * weight * (z**3 - void**3)).sum())
        return _mirrored_body(volume, center, (xx, yy, zz))

    def _moments(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """Integrals of z, z y² and z³ over y ≥ 0 at every `x`."""
        y, weight = _nodes(self._seams(x))
        x = x[:, None, None]
        z = self.half_width(x, y)
        void = np.minimum(self.void(x, y), z)
        solid, axes = weight * (z - void), (1, 2)
        return solid.sum(axes), (solid * y**2).sum(axes), (weight * (z**3 - void**3)).sum(axes)

    def _stations(self) -> Floats:
        ends = [piece.start[0] for piece in self.outline.upper] + [self.outline.upper[-1].end[0]]
        first, last = ends[0], ends[-1]
        for bore in self.outline.bores:
            ends += [bore.start[0], bore.end[0]]
        for center, rim, _ in self.chamfers:
            ends += [center - rim, center + rim]
        for step, side in zip(self.steps, (1, -1), strict=True):
            for radius in (step.rim, step.foot):
                begin = self.outline.fillets[0].start[0] if side > 0 else self.outline.fillets[1].end[0]
                ends += [step.center + side * radius, self._crossing(step.center, begin, radius)]
        if (rib := self.outline.rib) is not None:
            for radius in rib.rings:
                ends += [-radius, self._crossing(0.0, rib.end.end[0], radius)]
        if self.pocket is not None:
            big, small = self.pocket.corners()
            for inset in (0.0, self.pocket.floor_radius):
                ends += [self.pocket.big_end + inset, self.pocket.small_end - inset]
            ends += [big.center[0], big.end[0], small.start[0], small.center[0]]
        ends += [*self._drilled_stations(), self.rod.length - self.rod.small_end_radius]
        return np.unique(np.clip(ends, first, last))

    def _drilled_stations(self) -> Iterator[float]:
        """Yield x where holes along the axis end, ever closer to where the chord of a circle is singular."""
        rod = self.rod
        gallery, wide = rod.oil_gallery / 2, rod.shank_bore / 2
        if wide:
            round_ = rod.shank_bore_round
            above = max(gallery - (wide - round_), 0.0)
            yield rod.shank_bore_end
            yield from (rod.shank_bore_end - round_ + math.sqrt(round_**2 - y**2) for y in (above, round_))
        for x, radius, half in (
            (0.0, rod.big_end_bore / 2, max(gallery, wide)),
            (rod.length, -rod.small_end_bore / 2, gallery),
            (rod.length, rod.small_end_bore / 2, rod.oil_hole / 2),
            (rod.length, rod.small_end_radius, rod.oil_hole / 2),
        ):
            short = 1 - math.sqrt(1 - (half / radius) ** 2)
            while 0 < short < 1:
                yield x + radius * (1 - short)
                short *= 4

    def _crossing(self, center: float, begin: float, radius: float) -> float:
        """Return x where a circle about a bore crosses the outline: the search begins inside of it."""
        side, low, high = math.copysign(1.0, begin - center), abs(begin - center), radius
        for _ in range(6):  # each narrows the interval 256 times
            along = np.linspace(low, high, 257)
            outside = np.hypot(along, self.outline.height(center + side * along)) > radius
            first = max(int(outside.argmax()), 1) if outside.any() else along.size - 1
            low, high = along[first - 1 : first + 1].tolist()
        return center + side * low

    def _seams(self, x: Floats) -> Floats:
        """Ordinates (len(x), n), from 0 to the outline, between which z changes smoothly."""
        top = self.outline.height(x)
        circles = [(bore.center[0], bore.radius) for bore in self.outline.bores]
        circles += [(center, rim) for center, rim, _ in self.chamfers]
        circles += [(step.center, radius) for step in self.steps for radius in (step.rim, step.foot)]
        if (rib := self.outline.rib) is not None:
            circles += [(0.0, radius) for radius in rib.rings]
        seams = [half_chord(radius, x - center) for center, radius in circles]
        levels = [self.rod.oil_hole / 2]
        if self.rod.big_end_opening:
            seams.append(self._drilled_radius(x))
        if self.pocket is not None and self.pocket.in_sides:
            seams.append(self.pocket.floor_begins(x))
            levels += [self.pocket.floor, self.pocket.floor + self.pocket.floor_radius]
        elif self.pocket is not None:
            seams += [self.pocket.upper_side(x, inset) for inset in (0.0, self.pocket.floor_radius)]
            seams += [np.full_like(x, center[1]) for center in self.pocket.corner_centers()]
        if self.outline.bosses is not None:
            boss = self.outline.bosses
            levels += [boss.bolt_at - boss.bolt_radius, boss.bolt_at + boss.bolt_radius]
            levels += [boss.top - boss.round] if boss.round else []
        seams += [np.full_like(x, level) for level in levels]
        stacked = np.stack([np.zeros_like(x), *seams, top], axis=-1)
        return np.sort(np.clip(stacked, 0.0, top[:, None]), axis=-1)


def _mirrored_body(volume: float, center: float, squares: tuple[float, float, float]) -> MassProperties:
    """Body of density 1 with the mirror planes y = 0 and z = 0, from integrals of (x − center)², y², z²."""
    xx, yy, zz = squares
    inertia = ((yy + zz, 0.0, 0.0), (0.0, xx + zz, 0.0), (0.0, 0.0, xx + yy))
    return MassProperties(volume, (center, 0.0, 0.0), inertia)


def _nodes(seams: Floats) -> tuple[Floats, Floats]:
    """Return nodes and weights (…, n − 1, nodes) of a quadrature between seams (…, n)."""
    low, span = seams[..., :-1, None], np.diff(seams)[..., None]
    return low + span * _SHARES, span * _SHARE_WEIGHTS


def sections(rod: Rod, count: int = 201) -> tuple[CrossSection, ...]:
    """Return at least two cross-sections evenly spaced over the shank, from ring to ring."""
    stations = np.linspace(rod.big_end_radius, rod.length - rod.small_end_radius, count)
    return HeightField(rod).sections(stations)


def least_section(rod: Rod) -> CrossSection:
    """Return the section of least area between the rings."""
    coarse = sections(rod)
    place = min(range(len(coarse)), key=lambda i: coarse[i].area)
    low, high = (coarse[i].x for i in (max(place - 1, 0), min(place + 1, len(coarse) - 1)))
    return min(HeightField(rod).sections(np.linspace(low, high, 101)), key=lambda section: section.area)


# Dimensions that are the thickness of a wall by themselves.
OF_WALLS = (
    "big_end_ring",
    "shank_width",
    "shank_depth_big_end",
    "shank_depth_small_end",
    "web_thickness",
    "flange_thickness",
)


def walls(rod: Dimensions) -> dict[str, float]:
    """Return the thickness of each wall of a rod, mm, by its name."""
    thickness = {
        "big-end ring": rod.big_end_ring,
        "small-end ring": rod.small_end_ring - rod.bushing,
        "shank": min(rod.shank_width, rod.shank_depth_big_end, rod.shank_depth_small_end),
    }
    if rod.has_pockets:
        thickness |= {"web": rod.web_thickness, "flange": rod.flange_thickness}
    if rod.big_end_opening:
        thickness["wall beside the hole along the shank"] = (rod.drilled_thickness - rod.big_end_opening) / 2
    if rod.cap_bolt:
        apart = rod.cap_bolt_spacing - rod.cap_bolt
        thickness["wall between bolt hole and bore"] = (apart - rod.big_end_bore) / 2
    return thickness
