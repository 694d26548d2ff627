"""Multiples of a load case at which an assembly begins to come apart."""

from collections.abc import Callable

from scipy.optimize import brentq

from fea.contact.assembly_state import AssemblyState
from fea.pins.assembly import AssemblyPins
from geometry.surfaces import Surface
from loads.instants import Instants

# Least and largest multiple that are tried, relative error of the multiple, and most steps to it.
LEAST, LARGEST, WITHIN, _MOST = 1 / 1024, 8.0, 0.02, 12


def onset(left: Callable[[float], float]) -> float | None:
    """Find where what is left of something first falls to zero; 0 where nothing is left without load.

    `left`: by the multiple, at least continuous before it falls to zero.

    Returns None beyond `LARGEST`.
    """
    if left(0.0) <= 0:
        return 0.0
    high = 1.0
    while left(high) > 0:
        if high >= LARGEST:
            return None
        high *= 2
    low = high / 2
    while left(low) <= 0:
        if low <= LEAST:
            return low
        low, high = low / 2, low
    return float(brentq(left, low, high, xtol=WITHIN * low / 4, maxiter=_MOST, disp=False))


# What is left beyond the onset, relative to what there is without load: its sign is what matters.
_LOST = -0.1
# Share of the clamping force below which rod and cap have come apart.
_APART = 1e-3


class LoadLimits:
    """Follows an assembly while everything that acts in a load case grows in proportion."""

    def __init__(self, pins: AssemblyPins, case: Instants, known: AssemblyState) -> None:
        self._pins, self._case = pins, case
        self._states = {0.0: pins.assembly.sums(pins.assembly.assembled.start), 1.0: known}

    def opens(self) -> float | None:
        """When the joint opens at the edge of the bore.

        Raises
        ------
        ContactError
            A state could not be found.
        """
        return self._onset(lambda state: state.joint.edge_pressure or 0.0)

    def separates(self) -> float | None:
        """When rod and cap come apart; errors as for `opens`."""
        clamped = self._states[0.0].joint.force
        return self._onset(lambda state: state.joint.force - _APART * clamped)

    def lifts_off(self, surface: Surface) -> float | None:
        """When a part begins to lift off its seat; errors as for `opens`."""
        return self._onset(
            lambda state: 0.0 if state.faces[surface].open_share > 0 else state.faces[surface].least
        )

    def _onset(self, measure: Callable[[AssemblyState], float]) -> float | None:
        lost = _LOST * measure(self._states[0.0])

        def left(factor: float) -> float:
            if factor not in self._states:
                self._states[factor] = self._pins.state_under(self._case, factor)
            value = measure(self._states[factor])
            return value if value > 0 else lost

        return onset(left)
