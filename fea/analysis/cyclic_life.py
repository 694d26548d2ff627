"""How long a rod lasts in which the same places flow to and fro in every turn."""

import numpy as np

from fea.analysis.flowing_rod import FollowedFlow
from fea.analysis.summary_figures import CyclicFigures
from fea.judge.cycle_life import StrainLine, life_line
from fea.plastic.cycling import PlasticAnswer
from fea.rod.loading import EngineLoading

# Share of the elements beyond the cyclic strength from which on following them takes longer than the cycle.
_MOST = 0.02


def _needs_cyclic_strength(followed: FollowedFlow) -> bool:
    """Whether a rod has yet to be followed at the cyclic yield strength, which decides its strain range."""
    smaller = followed.rod.rod.materials[0].flow_strength < followed.zone.strength[0, 0]
    return bool(smaller and followed.flow.answer is PlasticAnswer.CYCLIC)


def takes_too_long(followed: FollowedFlow) -> bool:
    """Whether the strain range is left out: without a cycle, or where many elements flow at that strength."""
    flowing = followed.rod
    many = (flowing.nodal > flowing.rod.materials[0].flow_strength).mean() > _MOST
    return _needs_cyclic_strength(followed) and bool(many or not flowing.rod.options.cycle)


def cyclic_life(followed: FollowedFlow, rpm: float | None) -> CyclicFigures | None:
    """Return the range of strain of a turn and the turns to a crack; None where flow is not cyclic.

    The range is that of the smaller of yield and cyclic yield strength. None, too, if it `takes_too_long`, or
    if the rod does not only flow to and fro at that strength. Life follows from the strain amplitude and the
    strength, which both ends of the turn reach (Smith, Watson & Topper: `fea.judge.cycle_life`).
    """
    if takes_too_long(followed):
        return None
    flowing, (material, *_) = followed.rod, followed.rod.rod.materials
    if _needs_cyclic_strength(followed):
        followed = flowing.follow(material.flow_strength)
    if followed.flow.answer is not PlasticAnswer.CYCLIC:
        return None
    zone, rod, loading = followed.zone, flowing.rod, flowing.rod.loading
    strength, ranges = float(zone.strength[0, 0]), followed.flow.strain_range(zone)
    element = int(np.unravel_index(ranges.argmax(), ranges.shape)[0])
    surface = rod.regions.factor(followed.most_stressed(element), material)
    line, turns, strain = life_line(material, surface), None, None
    if line is not None:
        strain = StrainLine.of(material, float(line.knee), surface)
    if strain is not None:
        turns = strain.of_strain(strength, float(ranges.max()) / 2)
    an_hour = loading.engine.cycles_per_hour * rpm if rpm and isinstance(loading, EngineLoading) else None
    return CyclicFigures(
        strain_range=float(ranges.max()),
        strength_MPa=strength,
        turns=turns,
        minutes=None if turns is None or an_hour is None else 60 * turns / an_hour,
        assumed=None if strain is None else strain.assumed,
    )
