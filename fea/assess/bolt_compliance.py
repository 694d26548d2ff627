"""Elastic compliance of bolts (VDI 2230-1:2015, section 5.1.1): cylinders in series, δ = l/(E A).

Lengths in mm, moduli in MPa, compliances in mm/N.
"""

from dataclasses import dataclass

from fea.study.metric_thread import Thread

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
