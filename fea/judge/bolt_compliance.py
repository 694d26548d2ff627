"""Elastic compliance of bolts (VDI 2230-1:2015, section 5.1.1): cylinders in series, δ = l/(E A).

Lengths in mm, moduli in MPa, compliances in mm/N.
"""

import math
from dataclasses import dataclass

from fea.study.bolts import Thread

# Lengths of equivalent cylinders over d: head of a hexagon bolt, engaged thread, nut, threaded hole.
HEXAGON_HEAD, SOCKET_HEAD = 0.5, 0.4
_ENGAGED, _NUT, _THREADED_HOLE = 0.5, 0.4, 0.33


@dataclass(frozen=True)
class BoltCompliance:
    """Compliances in series, mm/N.

    Attributes
    ----------
    head, shank, free_thread, engaged
        Of the bolt: δ_SK, Σδ_i, δ_Gew and δ_G.
    counterpart
        δ_M: of the threads of nut or hole.
    """

    head: float
    shank: float
    free_thread: float
    engaged: float
    counterpart: float

    @property
    def between_ends(self) -> float:
        """Of the bolt alone between its end faces, where its stretch is measured."""
        return self.head + self.shank + self.free_thread + self.engaged

    @property
    def total(self) -> float:
        """δ_S."""
        return self.between_ends + self.counterpart


def bolt_compliance(
    thread: Thread,
    *,
    grip: float,
    free_thread: float,
    shank_area: float,
    modulus: float,
    counter_modulus: float,
    nut: bool,
    head: float = HEXAGON_HEAD,
) -> BoltCompliance:
    """Return δ_S and its parts.

    Parameters
    ----------
    thread
        Of the bolt.
    grip
        Length between the seats, or to the first thread that carries.
    free_thread
        Length of the thread within the grip; the rest is shank.
    shank_area
        Of the shank, mm².
    modulus, counter_modulus
        E of the bolt, and of nut or rod.
    nut
        Whether there is a nut; else the hole is threaded.
    head
        Length of the head's equivalent cylinder over d.
    """
    d = thread.diameter
    return BoltCompliance(
        head=head * d / (modulus * thread.nominal_area),
        shank=(grip - free_thread) / (modulus * shank_area),
        free_thread=free_thread / (modulus * thread.root_area),
        engaged=_ENGAGED * d / (modulus * thread.root_area),
        counterpart=(_NUT if nut else _THREADED_HOLE) * d / (counter_modulus * thread.nominal_area),
    )


@dataclass(frozen=True)
class ClampedParts:
    """Parts under a bolt, clamped along its axis.

    Attributes
    ----------
    grip
        l_K, mm.
    seat
        d_W: outer diameter of the head's seat, mm.
    hole
        d_h, mm.
    outer
        D_A: diameter of a cylinder around the bolt that the parts fill, mm.
    modulus
        E_P, MPa.
    nut
        Whether a nut seats on the far side, too; else the bolt is screwed into the last part.
    """

    grip: float
    seat: float
    hole: float
    outer: float
    modulus: float
    nut: bool = True

    @property
    def slope(self) -> float:
        """Tan φ of the cone's half angle, which depends on the parts' proportions."""
        slender = self.grip / self.seat
        wide = math.log(max(self.outer, self.seat) / self.seat)
        if self.nut:
            return 0.362 + 0.032 * math.log(slender / 2) + 0.153 * wide
        return 0.348 + 0.013 * math.log(slender) + 0.193 * wide

    @property
    def widest(self) -> float:
        """D_A,Gr: outer diameter that the cones reach, mm."""
        return self.seat + self._cones * self.grip * self.slope

    @property
    def compliance(self) -> float:
        """δ_P of a sleeve (outer at most seat), a cone with a sleeve, or cones alone, mm/N."""
        if self.outer <= self.seat:
            return 4 * self.grip / (math.pi * self.modulus * (self.outer**2 - self.hole**2))
        reach = min(self.outer, self.widest)
        cone = 2 / (self._cones * self.hole * self.slope) * self._logarithm(reach)
        sleeve = self.grip - (reach - self.seat) / (self._cones * self.slope)
        return (cone + 4 / (reach**2 - self.hole**2) * sleeve) / (math.pi * self.modulus)

    @property
    def _cones(self) -> int:
        """The guideline's w, over 1: cones that meet in the middle with a nut (1), one cone otherwise (2)."""
        return 1 if self.nut else 2

    def _logarithm(self, reach: float) -> float:
        w, h = self.seat, self.hole
        return math.log((w + h) * (reach - h) / ((w - h) * (reach + h)))
