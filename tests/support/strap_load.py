"""A tilted pin force on the strap with the motion and the crank force that balance it."""

import numpy as np
from strap import BIG_BORE, LENGTH, SMALL_BORE, WIDTH

from fea.solid.bore import bore_facets, bore_load
from fea.solid.inertia import inertia
from fea.solid.parity import Split
from fea.solid.supports import rigid_modes
from geometry.surfaces import Surface
from loads.bearing import BorePressure
from loads.instants import in_motion

DENSITY = 7.7e-9
COSINE = BorePressure.parse("cosine-180").tension


def tilted_load(mesh):
    """A pin force, a motion and the crank force that balances them."""
    body = inertia(mesh, DENSITY)
    rod = body.properties
    motion = in_motion((-2e6, 1e6), angular_velocity=300.0, angular_acceleration=3e4)
    (a_x, a_y), omega, alpha = motion.acceleration, motion.angular_velocity, motion.angular_acceleration
    x, about_origin = rod.center[0], rod.inertia_z + rod.mass * rod.center[0] ** 2
    pin = np.array([-3000.0, (about_origin * alpha + rod.mass * x * a_y) / LENGTH])
    crank = rod.mass * np.array([a_x - omega**2 * x, a_y + alpha * x]) - pin
    parts = [body.forces(motion)]
    for surface, center, radius, force in (
        (Surface.SMALL_END_BORE, LENGTH, SMALL_BORE, pin),
        (Surface.BIG_END_BORE, 0.0, BIG_BORE, crank),
    ):
        peak = COSINE.peak(np.hypot(*force), radius, WIDTH)
        facets = bore_facets(mesh, surface, center)
        load = bore_load(
            facets,
            len(mesh.points),
            tuple(force),
            lambda psi, p=peak: p * COSINE.unbounded(psi),
            COSINE.angle / 2,
        )
        parts.append(load.forces)
    odd = [part.antisymmetric for part in parts if part.antisymmetric is not None]
    return Split(sum(part.symmetric for part in parts), sum(odd) if odd else None)


def without_rigid_motion(points, u):
    modes, flat = rigid_modes(points).reshape(-1, 6), u.reshape(-1)
    return (flat - modes @ np.linalg.lstsq(modes, flat)[0]).reshape(-1, 3)
