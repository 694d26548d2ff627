"""How stress and bolts follow preload, clearances and friction, in which contact is not linear.

Each cause that [scatter] gives is solved at two standard deviations below and above its mean: twice the whole
crank cycle, of a duty that of the speed with most of the damage, with the stiffness that the rod has. Effects
of several causes multiply.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fea.analysis.assembling import AssemblySetup
from fea.analysis.assembly_report import judged_bolts
from fea.analysis.cycle.operation import Entry, Operation, gas_along_rod
from fea.analysis.life import make_exact
from fea.analysis.life_figures import ResponseFigures
from fea.analysis.prepared_rod import PreparedRod
from fea.base.choices import PreloadScatter
from fea.base.units import RPM, UM
from fea.judge.fatigue import reversed_amplitude
from fea.judge.rainflow import rainflow
from fea.judge.reliability import AWAY
from fea.pins.contact import ContactPins
from fea.solid.errors import ContactError
from fea.study.assembly_table import SCATTER
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from loads.crank_cycle import CrankCycle

# Damage goes with about this power of a range of stress.
_POWER = 8


@dataclass(frozen=True)
class Cause:
    """Something that differs between rods, and how the structure of a rod changes with it."""

    name: str  #: in words
    key: str  #: of [scatter]
    deviation: float  #: standard deviation
    unit: str
    #: low, high: what `PreparedRod.with_pins` takes, `AWAY` deviations below and above the mean
    low: Mapping[str, Any]
    high: Mapping[str, Any]


@dataclass(frozen=True)
class Response:
    """What a cause does to places."""

    cause: Cause
    change: Floats  #: (n_places, 2) of the logarithm of amplitude over strength, at `low` and `high`

    def figures(self, place: int) -> ResponseFigures:
        """Return the figures, with the change at a place."""
        low, high = (100 * np.expm1(self.change[place])).tolist()
        cause = self.cause
        return ResponseFigures(
            cause=cause.name, deviation=cause.deviation, unit=cause.unit, change_percent=(low, high)
        )


def causes(rod: PreparedRod) -> Iterator[Cause]:
    """Yield what [scatter] gives. Raises `InvalidValue`: the rod has no such thing, or it varies too much."""
    table, parts, setup = rod.study.scatter, rod.structure.assembly, rod.assembling
    if table is None:
        return
    for key in ("preload_percent", "friction_percent"):
        rule = "needs a rod of separate parts, whose pins are in contact"
        there, given = rod.assembly_contact is not None, getattr(table, key)
        require(there or not given, f"scatter.{key}", given, rule, "Leave it out, or give [assembly].")
    if parts is not None and setup is not None:
        percent = preload_percent(table.preload_percent, setup)
        of_force = percent / 100 * setup.bolt.tightening.preload
        forces = {"preload": (percent, parts.preload, of_force)}
        percent = table.friction_percent or 0.0
        forces["friction"] = (percent, parts.friction, percent / 100 * parts.friction)
        for name, (percent, mean, deviation) in forces.items():
            if percent:
                ends = (mean + sign * AWAY * deviation for sign in (-1, 1))
                low, high = ({"assembly": replace(parts, **{name: value})} for value in ends)
                yield Cause(name, f"{name}_percent", percent, "%", low, high)
    if table.clearance_um:
        yield from _clearances(rod, table.clearance_um)


def preload_percent(given: PreloadScatter | float | None, setup: AssemblySetup) -> float:
    """Standard deviation of the preload, per cent, that is given or usual for the way of tightening.

    VDI 2230 prints ± s about the mean, and α_A = (1 + s)/(1 − s); the middle of its range of s is taken as
    two standard deviations, which is assumed. A preload without its way of tightening counts as by torque.
    """
    if not isinstance(given, PreloadScatter):
        return given or 0.0
    factor = setup.table.bolt_tightening_factor
    usual = float(np.mean(setup.bolt.tightening.scatter or SCATTER["torque"]))
    return (usual if factor is None else 100 * (factor - 1) / (factor + 1)) / 2


def _clearances(rod: PreparedRod, deviation: float) -> Iterator[Cause]:
    """Yield the diametral clearances of both ends, which differ independently."""
    key, contact = "scatter.clearance_um", rod.structure.contact
    touch = isinstance(rod.pins, ContactPins)
    rule = "needs pins in contact, which this study or rod excludes"
    require(touch, key, deviation, rule, "Leave it out, or give analysis.pressure = contact.")
    if not isinstance(rod.pins, ContactPins):
        return
    fits = rod.pins.fits
    for end, radial in (("small", fits.small_clearance), ("big", fits.big_clearance)):
        mean, away = 2 * radial, AWAY * deviation * UM
        rule = f"must be less than half of the {end} end's clearance, {abs(mean) / UM:.3g} µm"
        remedy = "Beyond, pins would change between clearance and press fit: give less, or that clearance."
        require(away < abs(mean), key, deviation, rule, remedy)
        name = f"{end}_end_clearance_mm"
        low, high = ({"contact": replace(contact, **{name: mean + each})} for each in (-away, away))
        yield Cause(f"{end}-end clearance", "clearance_um", deviation, "µm", low, high)


def responses(rod: PreparedRod, operation: Operation, where: Sequence[tuple[int, int]]) -> list[Response]:
    """Solve every cause at its two values: what each does to nodes of parts, then to the bolts.

    Raises `InvalidValue`: at one of them the parts come apart.
    """
    every = list(causes(rod))
    if not every:
        return []
    (spot, _), *_ = operation.places(where[:1])
    signed = np.split(spot.signed, np.cumsum([entry.weights.even.shape[1] for entry in operation.entries]))
    worst = max(
        zip(operation.entries, signed, strict=False), key=lambda own: own[0].rate * np.ptp(own[1]) ** _POWER
    )
    cycle = worst[0].cycle
    speed = replace(rod.study.speed, rpm=cycle.speed / RPM)
    alone = replace(rod, study=replace(rod.study, speed=speed, duty=None))
    now = _demand(rod, cycle, where)
    found = []
    for cause in every:
        try:
            ends = [_demand(alone.with_pins(**each), cycle, where) for each in (cause.low, cause.high)]
        except ContactError as error:
            rule = f"leads {AWAY:g} deviations from the mean to a rod that does not hold together: {error}"
            remedy = "Give a smaller one, or stronger bolts."
            raise InvalidValue(f"scatter.{cause.key}", cause.deviation, rule, remedy) from error
        found.append(Response(cause, np.stack([end - now for end in ends], axis=1)))
    return found


def _demand(rod: PreparedRod, cycle: CrankCycle, where: Sequence[tuple[int, int]]) -> Floats:
    """Logarithm of the largest reversed amplitude of nodes, MPa, then of that of bolts over their limit."""
    analysis, criterion = rod.cycle, rod.options.fatigue
    full = analysis.basis.full(cycle.degrees, cycle)
    operation = Operation(analysis, (Entry(cycle, full, 1.0, gas_along_rod(cycle.degrees)),), None)
    make_exact(operation, where)
    spots = [spot for spot, _ in operation.projected().places(where)]
    demand = [
        reversed_amplitude(criterion, *rainflow(spot.signed), rod.materials[spot.part]).max()
        for spot in spots
    ]
    if rod.assembling is not None and (states := analysis.basis.contacts(cycle).states):
        bolts = judged_bolts(rod.assembling, states)
        demand += [bolt.bending_amplitude / bolt.endurance for bolt in bolts]
    return np.log(np.array(demand))
