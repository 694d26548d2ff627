"""Where a pin touches its bore, and how hard."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats


@dataclass(frozen=True)
class Touch:
    """Contact of a pin with its bore."""

    pressure: float  # the largest, MPa
    angle: float  # where it is, about the bore's axis from rod +x, rad
    z: float  # where it is along the bore, mm
    arc: float  # angle around the bore over which they touch anywhere, to the distance of two vertices, rad

    @classmethod
    def of(cls, pressure: Floats, angle: Floats, z: Floats) -> "Touch":
        """Find it from pressures (n,), MPa, at angles (n,), rad, and places (n,) along the bore, mm."""
        largest = int(pressure.argmax())
        touching = np.sort(angle[pressure > 0])
        if touching.size < 2:
            return cls(float(pressure[largest]), float(angle[largest]), float(z[largest]), 0.0)
        gaps = np.diff(np.append(touching, touching[0] + 2 * np.pi))
        every = np.diff(np.unique(np.round(angle, 6)))
        open_arc = gaps.max() if gaps.max() > 2.5 * np.median(every) else 0.0
        return cls(
            float(pressure[largest]), float(angle[largest]), float(z[largest]), float(2 * np.pi - open_arc)
        )
