"""Assembled rods drawn at random: many go together, the others break one rule or another."""

from dataclasses import replace

import numpy as np
from rods import random_rod

from geometry.assembly import Assembly, BoltSeat
from geometry.errors import InvalidValue
from geometry.presets import LEON_2001
from geometry.rod import Rod

# León's rod with bosses that are wide enough for bolt heads.
BOLTED = replace(
    LEON_2001,
    cap_bolt=9.0,
    cap_bolt_spacing=72.6,
    cap_boss_length=40.0,
    cap_boss_fillet=4.0,
    bushing=1.5,
    oil_hole=4.0,
    big_end_chamfer=0.5,
)
# Without pockets and steps, whose many faces and small elements tell nothing of its parts.
SIMPLE = replace(BOLTED, shank_section="rectangular", shank_width=30.0)
# With bosses that are short enough to be turned.
STUBBY = replace(
    BOLTED, cap_boss_length=24.0, cap_boss_fillet=3.0, big_end_fillet=12.0, cap_bolt_spacing=82.0
)
NUTS = BoltSeat(head_diameter=14.0, nut_diameter=13.0, grip=40.0)
SCREWS = BoltSeat(head_diameter=14.0, grip=24.0, engaged=12.0)


def random_assembly(seed: int) -> tuple[Rod, Assembly] | InvalidValue:
    """Draw a rod and what it is assembled from, or the refusal that the rod alone met.

    Parameters
    ----------
    seed
        The same seed draws the same.
    """
    draw = np.random.default_rng([seed, 19])
    rod = random_rod(seed)
    if isinstance(rod, InvalidValue):
        return rod
    head = rod.cap_bolt * draw.uniform(1.3, 1.7)
    try:
        if rod.cap_bolt and draw.random() < 0.8:
            rod = replace(rod, cap_bolt_spacing=rod.cap_bolt_spacing + head * draw.uniform(0, 1.2))
    except InvalidValue as refusal:
        return refusal
    length = rod.cap_boss_length
    thread = {"grip": length * draw.uniform(0.5, 0.8), "engaged": length * draw.uniform(0.1, 0.3)}
    nut = {"grip": length, "nut_diameter": head * draw.uniform(0.8, 1.1)}
    bolt = BoltSeat(head_diameter=head, **(nut if draw.random() < 0.5 else thread))
    oblique = draw.random() < 0.4
    return rod, Assembly(
        split=float(draw.uniform(-60, 60)) if oblique else 0.0,
        bushing=bool(rod.bushing) and draw.random() < 0.8,
        shell=rod.big_end_ring * float(draw.choice([0.0, draw.uniform(0.05, 0.6)])),
        bolt=bolt if rod.cap_bolt else None,
    )
