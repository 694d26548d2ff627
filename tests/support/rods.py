"""Rods drawn at random over the allowed range of dimensions."""

from dataclasses import fields, replace

import numpy as np

from geometry.dimensions import ShankSection, dimensions, options
from geometry.errors import InvalidValue
from geometry.rod import Rod, proportioned


def random_rod(
    seed: int, section: ShankSection | None = None, spread: float = 0.25, *, ribbed: bool = False
) -> Rod | InvalidValue:
    """Draw a rod: usual proportions, every dimension then scaled at random; or the refusal it met.

    Parameters
    ----------
    seed
        The same seed draws the same rod.
    section
        That of the shank, with an oil gallery in half of the rods; None: an I-section or a rectangle.
    spread
        Standard deviation of the logarithm of each dimension over the usual one.
    ribbed
        Give every rod cap bolts with rounded bosses, and one rib or two over the cap.
    """
    draw = np.random.default_rng(seed)
    length = float(np.exp(draw.uniform(np.log(40), np.log(600))))
    big = length * draw.uniform(0.2, 0.6)
    try:
        drawn = draw.choice([ShankSection.I, ShankSection.RECTANGULAR])
        rod = proportioned(length, big, big * draw.uniform(0.3, 0.9), shank_section=section or drawn)
        optional = _options(rod, draw)
        if section and np.random.default_rng([seed, 1]).random() < 0.5:
            optional["oil_gallery"] = 0.3 * rod.drilled_thickness
        if ribbed:
            optional |= _cap(rod, np.random.default_rng([seed, 2]))
        rod = proportioned(**_given(rod), **optional)
        free = dimensions()[3:]  # beyond length and bores
        changes = {name: getattr(rod, name) * float(np.exp(draw.normal(0, spread))) for name in free}
        return replace(rod, **changes)
    except InvalidValue as refusal:
        return refusal


def _given(rod: Rod) -> dict[str, object]:
    return {field.name: getattr(rod, field.name) for field in fields(Rod) if field.name not in options()}


def _cap(rod: Rod, draw: np.random.Generator) -> dict[str, float]:
    height = draw.uniform(0.1, 0.2) * rod.big_end_radius
    width = rod.big_end_width * draw.uniform(0.3, 0.7)
    cap = {"cap_bolt": 0.35 * rod.big_end_width, "cap_boss_round": 0.15 * rod.big_end_width}
    cap |= {"cap_rib": height, "cap_rib_width": width}
    return cap | ({"cap_rib_groove": min(1.8 * height, 0.65 * width)} if draw.random() < 0.5 else {})


def _options(rod: Rod, draw: np.random.Generator) -> dict[str, float]:
    """Draw what a rod may have besides, each half of the time or less."""
    sizes = {
        "small_end_crown_width": 0.6 * rod.small_end_width,
        "bushing": 0.3 * rod.small_end_ring,
        "oil_hole": 0.15 * rod.small_end_bore,
        "cap_bolt": 0.35 * rod.big_end_width,
    }
    return {name: size for name, size in sizes.items() if draw.random() < 0.4}
