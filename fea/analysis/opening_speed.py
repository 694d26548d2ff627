"""The engine speed from which the joint of an assembled rod opens at the edge of its bore."""

from collections.abc import Sequence

from scipy.optimize import brentq

from fea.analysis.assembly_onsets import MOST_UNKNOWNS
from fea.analysis.prepare import PreparedRod
from fea.solid.errors import ContactError

# The name of that speed among the critical ones.
JOINT_OPENING = "joint_opening"
# To which the speed is found, over itself.
_WITHIN = 0.01
# Stands for the pressure at an edge that has opened, MPa: its sign is what matters.
_OPEN = -1.0


def opening_speed(rod: PreparedRod, speeds: Sequence[float]) -> float | None:
    """Find the lowest speed, rpm, at which a load case opens the joint at the edge of the bore.

    Parameters
    ----------
    rod
        Of separate parts, with an engine.
    speeds
        rpm, between the lowest and highest of which it is looked for.

    Returns
    -------
    float or None
        To 1 %, or of `speeds` the first where the joint is open if the contact problem is large; None where
        it opens at none of them.
    """
    rising = sorted(speeds)
    number = next((number for number, rpm in enumerate(rising) if _edge(rod, rpm) <= 0), None)
    if number is None:
        return None
    rpm = rising[number]
    if number == 0 or rod.contact.problem.fold.size > MOST_UNKNOWNS:
        return rpm
    low = rising[number - 1]
    return float(brentq(lambda speed: _edge(rod, speed), low, rpm, xtol=_WITHIN * rpm))


def opening_speeds(rod: PreparedRod, speeds: Sequence[float]) -> dict[str, float | None]:
    """Return that speed by its name; nothing for a rod of one piece."""
    return {} if rod.putting is None else {JOINT_OPENING: opening_speed(rod, speeds)}


def _edge(rod: PreparedRod, rpm: float) -> float:
    """Least pressure, MPa, at the edge of the bore over the load cases; negative where the joint opens."""
    contact = rod.held_together
    least = []
    for case in rod.loading.at(rod.mass, rpm).cases:
        try:
            pressure = contact.states(contact.scaled(case, 1.0)).joint.edge_pressure
        except ContactError:
            return _OPEN
        least.append(pressure or _OPEN)
    return min(least)
