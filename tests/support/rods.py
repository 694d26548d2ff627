"""Rods drawn at random over the allowed range of dimensions."""

from dataclasses import replace

import numpy as np

from geometry.invalid import InvalidValue
from geometry.proportions import proportioned
from geometry.rod import Rod, ShankSection, dimensions


def random_rod(seed: int) -> Rod | InvalidValue:
    """Draw a rod: usual proportions, every dimension then scaled at random; or the refusal it met.

    Parameters
    ----------
    seed
        The same seed draws the same rod.
    """
    draw = np.random.default_rng(seed)
    length = float(np.exp(draw.uniform(np.log(40), np.log(600))))
    big = length * draw.uniform(0.2, 0.6)
    try:
        section = draw.choice(list(ShankSection))
        rod = proportioned(length, big, big * draw.uniform(0.3, 0.9), shank_section=section)
        free = dimensions()[3:]  # beyond length and bores
        changes = {name: getattr(rod, name) * float(np.exp(draw.normal(0, 0.25))) for name in free}
        return replace(rod, **changes)
    except InvalidValue as refusal:
        return refusal
