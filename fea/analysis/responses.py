"""How stress and bolts follow preload, clearances and friction, in which contact is not linear.

Each cause that [scatter] gives is solved at one and two standard deviations on either side of its mean: four
times the whole crank cycle, of a duty that of the speed with most of the damage, with the stiffness that the
rod has. Effects of several causes multiply.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from fea.analysis.assembling import AssemblySetup
from fea.analysis.assembly_report import judged_bolts
from fea.analysis.cycle.operation import Entry, Operation, gas_along_rod
from fea.analysis.life import make_exact
from fea.analysis.prepared_rod import PreparedRod
from fea.base.units import RPM, UM
from fea.judge.fatigue import reversed_amplitude
from fea.judge.history import rainflow
from fea.judge.reliability import AWAY
from fea.pins.contact import ContactPins
from fea.solid.errors import ContactError
from fea.study.assembly_table import SCATTER
from fea.study.speed_tables import SpeedTable
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require
from loads.crank_cycle import CrankCycle

_POWER = 8  # of a range of stress, with which damage goes about


class Cause(NamedTuple):
    """Something that differs between rods, and how the structure of a rod changes with it."""

    name: str  #: in words
    key: str  #: of [scatter]
    deviation: float  #: standard deviation
    field: str  #: of what pins are made from: see `PreparedRod.with_pins`
    values: tuple[Any, ...]  #: of that, `AWAY` deviations from the mean


def causes(rod: PreparedRod) -> Iterator[Cause]:
    """Yield what [scatter] gives. Raises `InvalidValue`: the rod has no such thing, or it varies too much."""
    table, parts, setup = rod.study.scatter, rod.structure.assembly, rod.assembling
    if table is None:
        return
    given = {"preload_percent": table.preload_percent, "friction_percent": table.friction_percent}
    for key, value in {**given, "tightening": table.tightening}.items():
        there, rule = rod.assembly_contact is not None, "needs separate parts whose pins are in contact"
        require(there or not value, f"scatter.{key}", value, rule, "Leave it out, or give [assembly].")
    if parts is not None and setup is not None:
        rule, both = "cannot be combined with preload_percent", table.tightening and table.preload_percent
        require(not both, "scatter.tightening", "true", rule, "Keep one of them.")
        percent = usual_scatter(setup) if table.tightening else table.preload_percent
        for name, each, whole in (
            ("preload", percent, setup.bolt.tightening.preload),
            ("friction", table.friction_percent, parts.friction),
        ):
            if each:
                own = _values(parts, name, getattr(parts, name), each / 100 * whole)
                yield Cause(name, f"{name}_percent", each, "assembly", own)
    if table.clearance_um:
        yield from _clearances(rod, table.clearance_um)


def _values(made: Any, name: str, mean: float, deviation: float) -> tuple[Any, ...]:
    """Return a dataclass with values of a field that are `AWAY` from its mean."""
    return tuple(replace(made, **{name: mean + away * deviation}) for away in AWAY)


def usual_scatter(setup: AssemblySetup) -> float:
    """Standard deviation of the preload, per cent, that is usual for the way of tightening.

    VDI 2230 prints ± s about the mean, and α_A = (1 + s)/(1 − s); the middle of its range of s is taken as
    two standard deviations, which is assumed. A preload without its way of tightening counts as by torque.
    """
    factor = setup.table.bolt_tightening_factor
    usual = float(np.mean(setup.bolt.tightening.scatter or SCATTER["torque"]))
    return (usual if factor is None else 100 * (factor - 1) / (factor + 1)) / 2


def _clearances(rod: PreparedRod, deviation: float) -> Iterator[Cause]:
    """Yield the diametral clearances of both ends, which differ independently."""
    key, contact, pins = "scatter.clearance_um", rod.structure.contact, rod.pins
    if not isinstance(pins, ContactPins):
        rule = "needs pins in contact, which this study or rod excludes"
        raise InvalidValue(key, deviation, rule, "Leave it out, or give analysis.pressure = contact.")
    for end, radial in (("small", pins.fits.small_clearance), ("big", pins.fits.big_clearance)):
        mean = 2 * radial
        rule = f"must be less than half of the {end} end's clearance, {abs(mean) / UM:.3g} µm"
        remedy = "Beyond, pins would change between clearance and press fit: give less, or that clearance."
        require(AWAY[-1] * deviation * UM < abs(mean), key, deviation, rule, remedy)
        own = _values(contact, f"{end}_end_clearance_mm", mean, deviation * UM)
        yield Cause(f"{end}-end clearance", "clearance_um", deviation, "contact", own)


def responses(
    rod: PreparedRod, operation: Operation, where: Sequence[tuple[int, int]], every: Sequence[Cause]
) -> Floats:
    """Solve causes: (n_places, n_causes, len(AWAY)) by how much the logarithm of amplitude grows.

    Of nodes of parts, then of the bolts, over their endurance. Raises `InvalidValue`: the parts come apart.
    """
    (signed,) = operation.at_gas(*operation.places(where[:1])[0], [0.0])
    damage = [rate * np.ptp(own) ** _POWER for rate, own in zip(operation.rates, signed, strict=True)]
    cycle = operation.entries[int(np.argmax(damage))].cycle
    rpm = round(cycle.speed / RPM, 6)  # so that the rod spans this very cycle
    alone = replace(rod, study=replace(rod.study, speed=SpeedTable(rpm), duty=None))
    now = _demand(rod, cycle, where)
    found = np.zeros((len(now), len(every), len(AWAY)))
    for number, cause in enumerate(every):
        try:
            rods = (alone.with_pins(**{cause.field: value}) for value in cause.values)
            found[:, number] = np.stack([_demand(other, cycle, where) - now for other in rods], axis=1)
        except ContactError as error:
            rule = f"leads, two deviations from the mean, to a rod that does not hold together: {error}"
            remedy = "Give a smaller one, or stronger bolts."
            raise InvalidValue(f"scatter.{cause.key}", cause.deviation, rule, remedy) from error
    return found


def _demand(rod: PreparedRod, cycle: CrankCycle, where: Sequence[tuple[int, int]]) -> Floats:
    """Logarithm of the largest reversed amplitude of nodes, MPa, then of that of bolts over their limit."""
    analysis, criterion = rod.cycle, rod.options.fatigue
    full = analysis.basis.full(cycle.degrees, cycle)
    operation = Operation(analysis, (Entry(cycle, full, 1.0, gas_along_rod(cycle.degrees)),))
    make_exact(operation, where)
    spots = [spot for spot, _ in operation.projected().places(where)]
    ranges = ((rainflow(spot.signed), rod.materials[spot.part]) for spot in spots)
    demand = [reversed_amplitude(criterion, *counted, material).max() for counted, material in ranges]
    if rod.assembling is not None and (states := analysis.basis.contacts(cycle).states):
        bolts = judged_bolts(rod.assembling, states)
        demand += [bolt.bending_amplitude / bolt.endurance for bolt in bolts]
    return np.asarray(np.log(demand))
