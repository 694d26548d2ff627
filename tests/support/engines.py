"""Engines and rods that the tests of the loads share."""

import math

from hypothesis import strategies as st

from geometry.mass import MassProperties
from loads.engine import Engine

RPM = 2 * math.pi / 60
DEG = math.pi / 180


def rod_of(mass_kg: float, center_mm: tuple[float, float], inertia_kg_m2: float) -> MassProperties:
    """Only the in-plane inertia matters to planar motion."""
    zero = (0.0, 0.0, 0.0)
    return MassProperties(mass_kg * 1e-3, (*center_mm, 0.0), (zero, zero, (0.0, 0.0, inertia_kg_m2 * 1e3)))


LEON = Engine(crank_radius=47, rod_length=141, bore=76, piston_mass=1.3345e-3, cylinders=4, phase=math.pi)
LEON_ROD = rod_of(0.785, (64.0, 0.0), 3.868e-3)

rods = st.builds(
    rod_of,
    st.floats(0.05, 5),
    st.tuples(st.floats(-50, 200), st.floats(-20, 20)),
    st.floats(1e-5, 1e-2),
)


@st.composite
def engines(draw: st.DrawFn, *, friction: bool = False) -> Engine:
    """Any engine that turns: λ up to 0.95, with or without a pin offset and friction."""
    length = draw(st.floats(60, 400))
    reach = draw(st.floats(0.02, 0.95)) * length
    offset = draw(st.floats(-0.3, 0.3)) * reach
    radius = reach - abs(offset)
    largest = math.tan(math.asin(reach / length))
    mu = draw(st.floats(0, 0.9)) / max(largest, 1.0) if friction else 0.0
    return Engine(radius, length, draw(st.floats(30, 200)), draw(st.floats(1e-4, 5e-3)), offset, mu)
