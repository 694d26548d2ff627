"""Circles fitted to points."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats


@dataclass(frozen=True)
class Circle:
    """A circle in a plane: centre (2,) and radius, mm."""

    center: Floats
    radius: float

    def distance(self, places: Floats) -> Floats:
        """Distance (…,) of places (…, 2) from the circle, mm."""
        return np.asarray(np.abs(np.linalg.norm(places - self.center, axis=-1) - self.radius))


def fitted_circle(places: Floats) -> Circle | None:
    """Least-squares circle through places (n, 2), mm; None for a straight line.

    Source: Kåsa (1976), IEEE Transactions on Instrumentation and Measurement 25(1), 8-14.
    """
    middle = places.mean(axis=0)
    off = places - middle
    table = np.column_stack([2 * off, np.ones(len(off))])
    (a, b, c), _, rank, _ = np.linalg.lstsq(table, (off**2).sum(axis=1), rcond=1e-10)
    square = c + a * a + b * b
    return None if rank < 3 or square <= 0 else Circle(middle + np.array([a, b]), float(np.sqrt(square)))
