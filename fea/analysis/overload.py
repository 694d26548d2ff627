"""What a single overload does to a rod: whether it bends, and what it leaves for good.

The material flows at its yield strength without hardening, in a rod without residual stress. Up to the force
at which the shank bends (`fea.judge.bent_column`) the solid rod is followed; beyond it, the bowed column: its
deflection grows until the liquid that stops the piston has room, or the energy that drives it is used up.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from fea.analysis.collapse import bending, overload_table, weaker
from fea.analysis.flow import flow_checks, held_contact, left_out
from fea.analysis.flowing_rod import FlowingRod, FollowedFlow, flowing_under
from fea.analysis.overload_figures import BendingFigures, OverloadFigures
from fea.analysis.permanent_set import judged, permanent_set
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.analysis.survival import OVERLOAD
from fea.base.note import Note, assumptions, omission
from fea.base.units import BAR, UM
from fea.judge.bent_column import BentColumn
from fea.judge.safety_factor import SafetyFactor
from fea.plastic.cycling import PlasticAnswer
from fea.rod.overload import Overload
from fea.rod.places import place_name
from geometry.arrays import Floats, vector
from loads.hydrolock import BULK
from loads.instants import given

# Share of the force at which the shank bends up to which the solid rod is followed then: its bores.
_BELOW = 0.95
# What gives way on the way to a force bears at most this share of it: less than all.
_SHORT = 0.999


def with_overload(rod: PreparedRod, static: SpeedResult) -> SpeedResult:
    """Follow the single overload of a study, if it has one. Errors as of `PreparedRod.equilibrium`."""
    if (overload := rod.overload) is None:
        return static
    if why := left_out(rod):
        return replace(static, notes=(*static.notes, omission(OVERLOAD, why)))
    strength, mesh, length = rod.materials[0].yield_strength, rod.mesh.whole, rod.mesh.bores.rod_length
    with rod.clock("plastic flow"):
        column = weaker(rod, strength)
        most = column.limit if overload.liquid else min(overload.force, column.limit)
        flowing = flowing_under(rod, given(-most).named(OVERLOAD)[None])  # at rest
        flexibility = -permanent_set(mesh, length, _alone(flowing))["length"] * UM / most
        force = overload.on_elastic_rod(flexibility)
        bends = force > column.limit
        borne = _BELOW * column.limit if bends else force
        followed = flowing.followed(strength, borne / most, most_turns=1)
        left = permanent_set(mesh, length, followed.whole)
        if bends:
            left = _bent(left, column, flexibility, overload)
        found = _figures(rod, overload, bending(column, OVERLOAD, force), followed, left, share=borne / force)
    return replace(
        static,
        checks={**static.checks, **flow_checks(followed.flow, static.checks)},
        notes=(
            *static.notes,
            *_notes(rod, overload, column, bends=bends),
            *held_contact(followed, OVERLOAD),
        ),
        overload=found,
        flows={**static.flows, OVERLOAD: followed},
    )


def _alone(flowing: FlowingRod) -> Floats:
    """Displacement (n_nodes, 3), mm, that the overload adds to that of bolts and fits."""
    moved = flowing.loads[OVERLOAD]
    return moved if flowing.rest is None else moved - flowing.rest


def _bent(
    left: dict[str, float], column: BentColumn, flexibility: float, overload: Overload
) -> dict[str, float]:
    """Add the bent shank once what bends it has room or is used up; empty where neither happens."""
    if (liquid := overload.liquid) is None:
        return {}
    fallen = column.falling
    shorter = fallen.load * flexibility + fallen.shortening
    wanted, pressed = np.transpose([(liquid.shortening(force), liquid.work(force)) for force in fallen.load])
    means = (fallen.load[1:] + fallen.load[:-1]) / 2
    work = pressed + fallen.load[0] * shorter[0] / 2 + np.append(0.0, np.cumsum(means * np.diff(shorter)))
    missing = np.minimum(wanted - shorter, (overload.energy - work) / fallen.load[0])
    if (missing > 0).all():
        return {}
    last = int((missing <= 0).argmax())
    before, at = missing[max(last - 1, 0)], missing[last]
    place = last - (at / (at - before) if last else 0.0)
    bow, shortening = (float(np.interp(place, np.arange(len(work)), each)) for each in fallen.left)
    return {**left, "length": left["length"] - shortening / UM, "bow": left["bow"] + bow / UM}


def _figures(
    rod: PreparedRod,
    overload: Overload,
    bent: BendingFigures,
    followed: FollowedFlow,
    left: Mapping[str, float],
    *,
    share: float,
) -> OverloadFigures:
    """Gather what is found; what is left is empty where it is not known.

    `share` is what the solid rod was followed to, of the force. Where it gives way on the way there, its
    factor lies between the last step in equilibrium and that share.
    """
    node, force = followed.node, bent.force_N
    collapses, strain = followed.flow.answer is PlasticAnswer.COLLAPSES, float(followed.flow.strain.max())
    factor, state = SafetyFactor(bent.limit_N / force, mode=OVERLOAD), "flows" if strain else "elastic"
    if collapses:
        least = followed.flow.borne * share
        state, factor = "collapses", SafetyFactor(least, least, _SHORT * share, mode=OVERLOAD)
    elif factor < 1:
        state = "bends"
    known = bool(left) and not collapses
    pressure = overload.pressure if overload.liquid is None else overload.liquid.pressure(force)
    return OverloadFigures(
        kind=overload.kind,
        state=state,
        pressure_bar=None if pressure is None else pressure / BAR,
        safety_factor=factor,
        bending=bent,
        max_plastic_strain=strain,
        elements=followed.elements,
        at_mm=vector(rod.mesh.whole.points[node]),
        where=place_name(rod.mesh, node),
        set_um=left if known else None,
        set_judged=judged(left, overload_table(rod).limits) if known else None,
    )


def _notes(rod: PreparedRod, overload: Overload, column: BentColumn, *, bends: bool) -> Iterator[Note]:
    table = overload_table(rod)
    said = {
        f"a bow of {column.bow:.2g} mm of the unloaded shank (overload.bow_mm)": table.bow_mm is None,
        "no hardening beyond the yield strength, and no residual stress before the overload": True,
        "no inertia, which would relieve the rod at top dead centre": True,
        f"compression without combustion, water (bulk modulus {BULK:.0f} MPa), and rigid crank, bearings, "
        "gasket and piston": overload.liquid is not None,
        "unlimited energy of crank and flywheel (overload.energy_J)": bends and table.energy_J is None,
    }
    yield from assumptions(OVERLOAD, (text for text, applies in said.items() if applies))
    yield omission(
        "bolts, joint, crank and oil films under the overload",
        "it presses on the rod, which relieves bolts and joint; crank, pins and films bear its force, too",
    )
