"""A bolt as a beam between its seats."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats


@dataclass(frozen=True)
class BoltBeam:
    """A bolt as a beam, from the first thread that carries (s = 0) to its head (s = 1)."""

    #: (2, 2) turns of the ends at head and thread from the line between the seats, of unit moments on the
    #: ends at head and thread, 1/(N mm)
    flexibility: Floats
    #: Sections where stress is highest, the first of them in the thread: s (n,), area (n,), mm², and section
    #: modulus (n,), mm³
    places: Floats
    areas: Floats
    moduli: Floats
    #: Force over the offset of the parts that bends it where it bears on its hole, N/mm; and the slip of the
    #: joint from which on it does, mm
    lateral: float = 0.0
    play: float = 0.0

    def bending(self, moments: Floats) -> Floats:
        """Bending stress (n, 2) in each plane at the sections of moments (2, 2) on the ends, MPa.

        `moments` has the planes in its rows and the ends at head and thread in its columns, N mm.
        """
        head, thread = np.asarray(moments).T
        inside = np.multiply.outer(self.places, head) - np.multiply.outer(1 - self.places, thread)
        return np.asarray(inside / self.moduli[:, None])
