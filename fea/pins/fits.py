"""The pins of a rod: what a study says of them, and what is assumed where it says nothing.

The defaults are those of passenger-car engines. Clearances in workshop manuals: piston pin of 21 mm,
0.004-0.020 mm (Mazda 6, V6 3.0, 2008); crank pin of 41.96 mm, 0.020-0.058 mm (Yanmar 3YM30). The bore of a
piston pin is about 0.6 of its diameter; its bosses leave some play beside the rod.

A pin that bends presses on the ends of a straight bore, where the exact stress is infinite. Makers therefore
widen bores towards their ends (Luehrmann et al., US patent 7240584, 2007) or let the pin taper towards its
middle (US patent 6923153, MAHLE, 2005). The relief that is assumed widens like a parabola over the whole bore
by as much as the pin bends: under its largest pull if it presses evenly, as the crown of the ring bends with
it, and under its largest push if its pressure falls to nothing at the ends, as the shank keeps the bore
straight. The ends then carry no more than the middle. That depth is a choice of this program, not a figure of
those patents. A relief keeps the pin off the ends if it is as steep there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fea.base.choices import PinBody
from fea.base.note import SINGULAR, Assumed, Note, assumptions, warning
from fea.contact.elastic_pin import Pin, bending
from fea.rod.meshed_rod import Bores
from fea.solid.boundary import BoundarySurface
from fea.study.option_tables import CRANK_PIN, PISTON_PIN, ContactTable
from geometry.errors import require
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# Diametral clearance over the diameter of the bore; bore over the diameter of a piston pin; distance of the
# piston's bosses over the width of the rod; length over which a boss carries the pin over its diameter.
SMALL_CLEARANCE, BIG_CLEARANCE, PIN_BORE, BOSS_GAP, BOSS_LENGTH = 0.6e-3, 1e-3, 0.6, 1.1, 0.8
# Carbon and case-hardening steels.
STEEL = (206e3, 0.3)
# Largest clearance and interference over the diameter: beyond, circles are no longer nearly concentric, and
# the press fit alone strains the rod by more than metals stand.
LARGEST_CLEARANCE, LARGEST_INTERFERENCE = 0.02, 0.003
# Smallest part of its radius by which a drawn bore widens on purpose: meshes differ from cylinders by less.
DRAWN_RELIEF = 2e-4
# Share of the depth asked for that is enough: it is printed with two digits, and errs on the safe side.
_ENOUGH = 0.9
# Least part of the normal beside the end of a bore that points to its axis, where a round or chamfer begins.
_LEADING_IN = 0.2
# What rounding to three digits adds to a length: that of the assumed relief can be given as it is printed.
_PRINTED = 5e-3
_RELIEF, _BIG_END = "contact.small_end_relief_mm", "contact.big_end_clearance_mm"


@dataclass(frozen=True)
class Fits:
    """The pins of a rod."""

    #: small_clearance, big_clearance: radius of the bore minus that of the pin, mm
    small_clearance: float
    big_clearance: float
    #: piston_pin, crank_pin: none for a rigid one
    piston_pin: Pin | None
    crank_pin: Pin | None
    assumed: tuple[str, ...]  #: what the study does not say, in words
    #: Length and radial depth of the relief at the ends of the small end's bore, mm, if it has one
    relief: tuple[float, float] | None = None
    drawn_relief: bool = False  #: whether the small end's bore widens towards its ends by itself
    #: half, bends: length and depth, mm, of a relief that keeps the piston pin off the ends of the small end
    half: float = 0.0
    bends: float = 0.0
    eased: float = 0.0  #: depth over `half` of a relief as steep as that of the small end, mm
    led_in: tuple[Surface, ...] = ()  #: bores whose ends lead into rounds or chamfers
    #: Where the relief is assumed, as deep as the pin bends under its largest force if it presses evenly, mm
    even: float | None = None

    @property
    def in_film(self) -> "Fits":
        """As an oil film has them, which has no sharp ends: there the pin has to press evenly, no more."""
        return self if self.even is None else replace(self, relief=(self.half, self.even))

    def assumed_in_film(self, *, in_contact: bool) -> list[str]:
        """What the small end's film assumes beside what pins in contact say."""
        others = (_BIG_END, _RELIEF)
        own = [] if in_contact else [text for text in self.assumed if not any(key in text for key in others)]
        return own if self.even is None else [*own, _assumed((self.half, self.even))]

    @property
    def sharp(self) -> tuple[Surface, ...]:
        """Bores whose ends an elastic pin presses on as it bends, where the exact pressure is infinite."""
        small = self.piston_pin is not None and self.eased < _ENOUGH * self.bends
        pressed = {Surface.SMALL_END_BORE: small, Surface.BIG_END_BORE: self.crank_pin is not None}
        return tuple(surface for surface, touches in pressed.items() if touches)

    @property
    def singular(self) -> tuple[Surface, ...]:
        """Bores beside whose ends the exact stress is infinite."""
        return self.sharp + tuple(bore for bore in self.led_in if bore not in self.sharp)

    @property
    def notes(self) -> tuple[Note, ...]:
        """What a reader must know of the pins."""
        notes = [*assumptions("contact", self.assumed)]
        if self.sharp:
            text = (
                f"the bending pin presses on the sharp ends of the {_words(self.sharp)}, where the exact "
                "stress is infinite, and the figures leave out the places near them"
            )
            if Surface.SMALL_END_BORE in self.sharp:
                text += (
                    f" (a relief as steep as [{self.half:.3g}, {self.bends:.2g}] mm keeps it off: {_RELIEF})"
                )
            notes.append(warning(text, SINGULAR))
        if rounded := self.singular[len(self.sharp) :]:
            text = (
                f"rounds or chamfers end the {_words(rounded)}, and the pin is not looked for on them: where "
                "its pressure ends the exact stress is infinite, and the figures leave out the places near "
                "it (contact.small_end_relief_mm keeps the pin off the ends of the small end)"
            )
            notes.append(warning(text, SINGULAR))
        return tuple(notes)

    @classmethod
    def of(
        cls,
        table: ContactTable,
        mesh: TetMesh,
        bores: Bores,
        stiffness: Mapping[str, tuple[float, float]],
        largest_forces: tuple[float, float],
    ) -> "Fits":
        """Complete what a study says of the pins.

        `stiffness`: E, MPa, and ν of pins, by their names, where they are given; `largest_forces`: of the
        piston pin away from the crank and towards it, N. Raises `InvalidValue`: a pin does not fit the rod.
        """
        assumed = Assumed()

        def given(key: str, default: float, what: str) -> float:
            return assumed.or_else(getattr(table, key), default, f"{what} {{:.3g}} mm (contact.{key})")

        small, big = (
            _clearance(key, given(key, share * 2 * radius, f"{end}-end clearance"), radius)
            for key, share, radius, end in (
                ("small_end_clearance_mm", SMALL_CLEARANCE, bores.small_radius, "small"),
                ("big_end_clearance_mm", BIG_CLEARANCE, bores.big_radius, "big"),
            )
        )
        piston_pin = None
        if table.piston_pin is PinBody.ELASTIC:
            diameter, width = 2 * bores.small_radius, bores.small_width + abs(bores.small_taper)
            bore = given("piston_pin_bore_mm", PIN_BORE * diameter, "piston-pin bore")
            gap = given("piston_boss_gap_mm", BOSS_GAP * width, "distance of the piston's bosses")
            length = given("piston_pin_length_mm", gap + 2 * BOSS_LENGTH * diameter, "piston-pin length")
            rule = f"must be smaller than 0.95 times the pin's diameter, {diameter:g} mm"
            require(bore < 0.95 * diameter, "contact.piston_pin_bore_mm", bore, rule)
            rule = (
                f"must be at least the width of the small end, {width:g} mm, which the bosses would overlap"
            )
            require(gap >= width, "contact.piston_boss_gap_mm", gap, rule)
            rule = f"must exceed 1.02 times the distance of the piston's bosses, {gap:g} mm, which carry it"
            require(length > 1.02 * gap, "contact.piston_pin_length_mm", length, rule)
            if PISTON_PIN not in stiffness:
                assumed.append("piston pin of steel, 206 GPa ([material.piston_pin])")
            E, nu = stiffness.get(PISTON_PIN, STEEL)
            piston_pin = Pin(bores.small_radius, bore / 2, width / 2, (gap / 2, length / 2), E, nu)
        widens = _widening(mesh, bores)
        relief, drawn = _relief(table, bores), widens > DRAWN_RELIEF * bores.small_radius
        half = bores.small_width / 2
        bends, even, (pull, push) = 0.0, None, largest_forces
        if piston_pin is not None:
            bends = max(bending(piston_pin, pull), bending(piston_pin, push, evenly=False))
        if relief is None and piston_pin is not None and not drawn:
            most = LARGEST_CLEARANCE * bores.small_radius
            relief, even = (half, min(bends, most)), min(bending(piston_pin, max(pull, push)), most)
            assumed.append(_assumed(relief))
        crank_pin = None
        if CRANK_PIN in stiffness:  # solid, held by webs beside the rod
            touching, radius = bores.big_width / 2, bores.big_radius
            webs = (1.02 * touching, 1.02 * touching + radius)
            crank_pin = Pin(radius, 0.0, touching, webs, *stiffness[CRANK_PIN])
        return cls(
            small_clearance=small / 2,
            big_clearance=big / 2,
            piston_pin=piston_pin,
            crank_pin=crank_pin,
            assumed=tuple(assumed),
            relief=relief,
            drawn_relief=drawn and relief is None,
            half=half,
            bends=bends,
            eased=widens if relief is None else relief[1] * half / relief[0],
            even=even,
            led_in=_led_in(
                mesh, bores, eased=table.small_end_relief_mm is not None or (drawn and relief is None)
            ),
        )


def _assumed(relief: tuple[float, float]) -> str:
    return f"small-end relief [{relief[0]:.3g}, {relief[1]:.2g}] mm ({_RELIEF})"


def _words(bores: Sequence[Surface]) -> str:
    return " and ".join(surface.value.replace("_", " ") for surface in bores)


def _widening(mesh: TetMesh, bores: Bores) -> float:
    """By how much the radius of the small end's bore grows towards its ends as it is drawn, mm.

    It may widen like a parabola; edges may have been straightened.
    """
    x, y, z = mesh.points[np.unique(mesh.facets[Surface.SMALL_END_BORE][:, :3])].T
    radius = np.hypot(x - bores.rod_length, y)
    middle = 0.0 if Surface.SYMMETRY_Z in mesh.facets else (z.min() + z.max()) / 2
    off = np.abs(z - middle) / np.abs(z - middle).max()
    return float(np.polyfit(off**2, radius, 1)[0])


def _led_in(mesh: TetMesh, bores: Bores, *, eased: bool) -> tuple[Surface, ...]:
    """Bores whose ends lead into a round or a chamfer, which the pin is not looked for on.

    Its pressure ends amid a surface then, or at an obtuse edge, where the exact stress is infinite; at the
    right angle of a plane end face it is finite. A relief that is given or drawn (`eased`) keeps the pin off
    the ends of the small end.
    """
    ends, led_in = {Surface.BIG_END_BORE: 0.0}, []
    if not eased:
        ends[Surface.SMALL_END_BORE] = bores.rod_length
    for bore, x in ends.items():
        body = BoundarySurface.of(mesh, [bore, Surface.FREE])
        facet, label = body.edges.facet, body.label[body.edges.facet]
        border = label[:, 0] != label[:, 1]
        beyond = np.where(label[border, 0] == 1, facet[border, 0], facet[border, 1])
        away = body.points[body.facets[beyond, :3]].mean(axis=1)[:, :2] - [x, 0.0]
        radial = away / np.linalg.norm(away, axis=1, keepdims=True)
        inwards = -(body.normals[beyond].mean(axis=1)[:, :2] * radial).sum(axis=1)
        if beyond.size and np.median(inwards) > _LEADING_IN:
            led_in.append(bore)
    return tuple(led_in)


def _clearance(key: str, clearance: float, radius: float) -> float:
    name, diameter = f"contact.{key}", 2 * radius
    most = LARGEST_CLEARANCE * diameter
    rule = f"must be at most {LARGEST_CLEARANCE:.0%} of the bore, {most:.3g} mm"
    require(clearance <= most, name, clearance, rule)
    most = LARGEST_INTERFERENCE * diameter
    rule = f"must not be below −{most:.3g} mm: a press fit of more than {LARGEST_INTERFERENCE:.1%} yields"
    require(clearance >= -most, name, clearance, rule)
    return clearance


def _relief(table: ContactTable, bores: Bores) -> tuple[float, float] | None:
    if table.small_end_relief_mm is None:
        return None
    length, depth = table.small_end_relief_mm
    half, most = bores.small_width / 2, LARGEST_CLEARANCE * bores.small_radius
    rule = f"its length must be at most half the bore's, {half:g} mm"
    require(length <= half * (1 + _PRINTED), _RELIEF, [length, depth], rule)
    require(depth <= most, _RELIEF, [length, depth], f"its depth must be at most {most:.3g} mm")
    return min(length, half), depth
