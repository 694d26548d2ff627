"""What a single overload does to a rod: whether it bends, and what it leaves for good.

The material flows at its yield strength without hardening, in a rod without residual stress. Up to the force
at which the shank bends (`fea.judge.bent_column`) the solid rod is followed; beyond it, the bowed column: its
deflection grows until the liquid that stops the piston has room, or the energy that drives it is used up.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from fea.analysis.collapse import bending, overload_table, weaker
from fea.analysis.flow import flow_checks, left_out
from fea.analysis.flowing_rod import FlowingRod, FollowedFlow
from fea.analysis.overload_figures import OverloadFigures
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
from fea.solid.stress import von_mises
from fea.solid.supports import bore_mean
from geometry.arrays import vector
from geometry.surfaces import Surface
from loads.hydrolock import BULK
from loads.instants import given


class Bent(NamedTuple):
    """What is left of a shank that has bent."""

    bow: float  #: departure from a straight line, mm
    shortening: float  #: by it, mm


def with_overload(rod: PreparedRod, static: SpeedResult) -> SpeedResult:
    """Follow the single overload of a study, if it has one. Errors as of `PreparedRod.equilibrium`."""
    overload = rod.overload
    if overload is None:
        return static
    if why := left_out(rod):
        return replace(static, notes=(*static.notes, omission(OVERLOAD, why)))
    strength = rod.materials[0].yield_strength
    with rod.clock("plastic flow"):
        column = weaker(rod, strength)
        most = column.limit if overload.liquid else min(overload.force, column.limit)
        flowing = _loaded(rod, most)
        flexibility = -_apart(rod, flowing) / most
        force = overload.on_elastic_rod(flexibility)
        followed = flowing.followed(strength, min(force, column.limit) / most, most_turns=1)
        figures = _figures(rod, followed, column, force)
        if followed.flow.answer is not PlasticAnswer.COLLAPSES:
            bent = Bent(0.0, 0.0) if force <= column.limit else _bent(column, flexibility, overload)
            figures = replace(figures, **_left(rod, followed, bent))
    pressure = overload.pressure if overload.liquid is None else overload.liquid.pressure(force)
    figures = replace(figures, kind=overload.kind, pressure_bar=None if pressure is None else pressure / BAR)
    return replace(
        static,
        checks={**static.checks, **flow_checks(followed.flow, static.checks)},
        notes=(*static.notes, *_notes(rod, overload, column, bends=force > column.limit)),
        overload=figures,
        flows={**static.flows, OVERLOAD: followed},
    )


def _loaded(rod: PreparedRod, force: float) -> FlowingRod:
    """The rod at rest under a force, N, that presses on both ends, and without it."""
    solved = rod.equilibrium(given(-force).named(OVERLOAD)[None])
    ((fields, stresses),) = rod.fields(solved)
    u, masked = fields.displacement, fields.error.masked
    counts = ~masked if not masked.all() else masked
    return FlowingRod(rod, {OVERLOAD: u, "no load": 0 * u}, von_mises(stresses[0]), counts)


def _apart(rod: PreparedRod, flowing: FlowingRod) -> float:
    """By how much the bores of the elastic rod are further apart under its load, mm."""
    u, mesh = flowing.loads[OVERLOAD], rod.mesh.whole
    small, big = (bore_mean(mesh, each, u) for each in (Surface.SMALL_END_BORE, Surface.BIG_END_BORE))
    return float(small[0] - big[0])


def _bent(column: BentColumn, flexibility: float, overload: Overload) -> Bent | None:
    """What is left of the shank once what bends it has room or is used up; None where neither happens."""
    if (liquid := overload.liquid) is None:
        return None
    fallen = column.falling
    shorter = fallen.load * flexibility + fallen.shortening
    wanted, pressed = np.transpose([(liquid.shortening(force), liquid.work(force)) for force in fallen.load])
    means = (fallen.load[1:] + fallen.load[:-1]) / 2
    work = pressed + fallen.load[0] * shorter[0] / 2 + np.append(0.0, np.cumsum(means * np.diff(shorter)))
    missing = np.minimum(wanted - shorter, (overload.energy - work) / fallen.load[0])
    if (missing > 0).all():
        return None
    place = last = float((missing <= 0).argmax())
    if last:
        before, at = missing[int(last) - 1 : int(last) + 1]
        place -= float(at / (at - before))
    return Bent(*(float(np.interp(place, np.arange(len(work)), each)) for each in fallen.left))


def _figures(rod: PreparedRod, followed: FollowedFlow, column: BentColumn, force: float) -> OverloadFigures:
    """Gather what a force does to the solid rod, up to that at which its shank bends."""
    bores, flow, node = rod.mesh.bores, followed.flow, followed.node
    collapses = flow.answer is PlasticAnswer.COLLAPSES
    strain = float(flow.strain.max(initial=0.0))
    state = "bends" if force > column.limit else "flows" if strain else "elastic"
    return OverloadFigures(
        kind="",
        state="collapses" if collapses else state,
        safety_factor=SafetyFactor(0.0 if collapses else column.limit / force, mode=OVERLOAD),
        bending=bending(column, OVERLOAD, force),
        max_plastic_strain=strain,
        elements=followed.elements,
        at_mm=vector(rod.mesh.whole.points[node]),
        where=place_name(rod.mesh, node),
        specific_load_MPa={
            "big_end": force / (2 * bores.big_radius * bores.big_width),
            "small_end": force / (2 * bores.small_radius * bores.small_width),
        },
    )


def _left(rod: PreparedRod, followed: FollowedFlow, bent: Bent | None) -> dict[str, Any]:
    """What the solid rod and its bent shank keep, with the limits; nothing where nothing ends the bending."""
    if bent is None:
        return {}
    left = permanent_set(rod.mesh.whole, rod.mesh.bores.rod_length, followed.whole)
    left["length"] -= bent.shortening / UM
    left["bow"] += bent.bow / UM
    return {"set_um": left, "set_judged": judged(left, overload_table(rod).limits)}


def _notes(rod: PreparedRod, overload: Overload, column: BentColumn, *, bends: bool) -> Iterator[Note]:
    table, assumed = overload_table(rod), list[str]()
    if table.bow_mm is None:
        assumed.append(f"a bow of {column.bow:.2g} mm of the unloaded shank (overload.bow_mm)")
    assumed.append("no hardening beyond the yield strength, and no residual stress before the overload")
    assumed.append("no inertia, which would relieve the rod at top dead centre")
    if overload.liquid is not None:
        assumed.append(
            f"compression without combustion, water (bulk modulus {BULK:.0f} MPa), and rigid crank, "
            "bearings, gasket and piston"
        )
        if bends and table.energy_J is None:
            assumed.append("unlimited energy of crank and flywheel (overload.energy_J)")
    yield from assumptions(OVERLOAD, assumed)
    yield omission(
        "bolts, joint, crank and oil films under the overload",
        "it presses on the rod, which relieves bolts and joint; crank, pins and films bear its force, too",
    )
