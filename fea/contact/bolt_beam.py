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

    def bow(self, moments: Floats) -> float:
        """Upper bound of how far it leaves the line between the seats, over its length.

        A cubic whose ends turn by φ and ψ from that line stays within 4/27 (φ + ψ).
        """
        return float(4 / 27 * np.hypot(*(np.asarray(moments) @ self.flexibility)).sum())

    def bending(self, moments: Floats) -> Floats:
        """Bending stress (n, 2) in each plane at the sections of moments (2, 2) on the ends, MPa.

        `moments` has the planes in its rows and the ends at head and thread in its columns, N mm.
        """
        head, thread = np.asarray(moments).T
        inside = np.multiply.outer(self.places, head) - np.multiply.outer(1 - self.places, thread)
        return np.asarray(inside / self.moduli[:, None])
