"""B-lives of a rod at one speed: its places, how their stress follows the gas load, and what first fails.

Stress over the cycle is that of the cycle, plus the change of the gas load times the stress of the gas alone:
the peak case ``gas``, whose force has the direction of the rod, as the wall takes the rest. So nothing is
solved again. It leaves out that a pin touches another part of its bore under another force; whole runs at
other pressures say how much that is (`tests/benchmarks/scatter.py`).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from fea.analysis.assembly_report import judged_bolts
from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.cycle.unit_solutions import PlaceHistory, spots
from fea.analysis.figures import BLifeFigures, PlaceLifeFigures, ReliabilityFigures
from fea.analysis.prepared_rod import PreparedRod
from fea.base.choices import Fatigue, ThreadRolled
from fea.base.material import Basquin, Material
from fea.judge.cycle_life import is_hard, line_at
from fea.judge.fatigue import LifeLine, criterion_strength, rainflow, reversed_amplitude
from fea.judge.history import deviatoric, signed_equivalent
from fea.judge.reliability import STATIC, BLife, FirstFailure, Place, Scatter, deviation
from fea.rod.loading import EngineLoading
from fea.rod.places import place_names
from fea.study.scatter_table import ScatterTable
from geometry.arrays import Floats, vector
from loads.crank_cycle import CrankCycle
from loads.instants import assembled, joined

SHARES = (0.01, 0.10, 0.50)
# Places whose factor exceeds the smallest by more than this do not fail first; distance, over the length of
# the rod, within which two places of one name are one.
_REACH, _APART = 1.4, 0.05
_GAS_FACTORS, _MOST_CYCLES = 9, 8
# Of bolts by VDI 2230: cycles at the endurance limit, and exponents of the line above it, of threads rolled
# before and after heat treatment. From memory: the guideline could not be read.
_BOLT_KNEE, _BOLT_EXPONENTS = 2e6, {ThreadRolled.BEFORE: 3.0, ThreadRolled.AFTER: 6.0}
# Scatter of the gas load where a study gives none: between cylinders, and from cycle to cycle by fuel.
_CYLINDERS, _PETROL, _DIESEL = 3.0, 5.0, 1.5
_UNFIRED = {"none", "motored", "boyle", "compressor"}
_BROKEN = 1e9  # amplitude, MPa, where mean stress alone breaks a place
_APART_LIVES = 1.1  # bounds that differ by more are both stated


def reliability_figures(result: CycleResult, rod: PreparedRod, rpm: float) -> ReliabilityFigures | None:
    """Return the B-lives at a speed; None where they would rest on assumptions that nobody asked for.

    That is an S–N line or a peak pressure that is assumed, in a study without [scatter].
    """
    loading, table = rod.loading, rod.study.scatter
    if result.weakest is None or not isinstance(loading, EngineLoading):
        return None
    assumed = _assumed_trace(loading) or rod.materials[result.weakest.part].basquin is None
    if assumed and table is None:
        return None
    scatter = scatter_of(table or ScatterTable(), loading, rod.options.fatigue)
    regions = list(_regions(result, rod))
    places = [*_places(result, rod, regions, rod.crank_cycle(rpm), scatter), *_bolts(result, rod)]
    if not places:
        return None
    found, an_hour = FirstFailure(places, scatter), loading.engine.cycles_per_hour * rpm
    lives = tuple(_figures(found.life(share), an_hour) for share in SHARES)
    each = [[found.of_place(number, share) for share in SHARES[1:]] for number in range(len(places))]
    first = min(range(len(places)), key=lambda number: each[number][0])
    given = table or ScatterTable()
    rods = given.rods or loading.engine.cylinders
    points = rod.mesh.whole.points
    failed = None if given.hours is None else found.failed(given.hours * an_hour)
    return ReliabilityFigures(
        lives=lives,
        first=places[first].name,
        conditional=assumed or places[first].assumed,
        places=tuple(
            PlaceLifeFigures(
                where=place.name,
                at_mm=vector(points[regions[k].node]) if k < len(regions) else None,
                count=place.count,
                b10_hours=_hours(b10, an_hour),
                b50_hours=_hours(b50, an_hour),
                assumed=place.assumed,
            )
            for k, (place, (b10, b50)) in enumerate(zip(places, each, strict=True))
        ),
        rods=rods,
        engine=_figures(found.of_engine(SHARES[1], rods), an_hour) if rods > 1 else None,
        by_hours=given.hours,
        failed_percent=None if failed is None else (100 * failed[0], 100 * failed[1]),
        failed_error_percent=None if failed is None else 100 * failed[2],
        samples=found.samples,
        strength_percent=100 * scatter.strength,
        static_percent=100 * scatter.static,
        cylinder_percent=100 * scatter.cylinder,
        boost_percent=100 * scatter.engine,
        cycle_percent=100 * scatter.cycle,
    )


def scatter_of(table: ScatterTable, loading: EngineLoading, criterion: Fatigue) -> Scatter:
    """Return what [scatter] says, with the defaults of a gas."""
    engine = loading.table
    fired = engine.gas not in _UNFIRED
    library = engine.library()
    diesel = "diesel" in (engine.fuel, "diesel" if library is not None and "diesel" in library.title else "")
    usual = (_CYLINDERS, _DIESEL if diesel else _PETROL) if fired else (0.0, 0.0)
    given = table.peak_pressure_percent, table.cycle_pressure_percent
    cylinder, cycle = (own if one is None else one for one, own in zip(given, usual, strict=True))
    static = table.yield_percent if criterion is Fatigue.SODERBERG else table.ultimate_percent
    batch = table.strength_percent * math.sqrt(table.batch_percent / 100)
    every = table.strength_percent, batch, static, cylinder, table.boost_percent, cycle
    return Scatter(*(percent / 100 for percent in every))


def _assumed_trace(loading: EngineLoading) -> bool:
    """Whether the peak pressure is neither measured nor given."""
    engine = loading.table
    library = engine.library()
    figure = None if library is None else library.engine.get("peak_pressure_bar")
    of_library = figure is not None and figure.assumed and figure.value == engine.peak_pressure_bar
    return engine.gas == "otto" and (engine.peak_pressure_bar is None or of_library)


def _regions(result: CycleResult, rod: PreparedRod) -> Iterator[PlaceHistory]:
    """Yield the most stressed node of each place whose factor against fatigue is near the smallest.

    A place is a region by its name, on either side of the plane of motion; images across z = 0 are counted.
    """
    found, points, length = result.envelope, rod.mesh.whole.points, rod.mesh.bores.rod_length
    if found.fatigue_factor is None:
        return
    upper = points[:, 2] >= -1e-9 * length
    factor = np.where(result.counts & upper, found.fatigue_factor, np.nan)
    near = np.flatnonzero(factor <= _REACH * np.nanmin(factor))
    near = near[np.argsort(factor[near], kind="stable")]
    chosen: dict[tuple[str, bool], list[int]] = {}
    for node, name in zip(near.tolist(), place_names(rod.mesh, near), strict=True):
        side = bool(points[node, 1] >= 0)
        others = [*chosen.get((name, side), ()), *chosen.get((name, not side), ())]
        close = any(np.linalg.norm(points[node] - points[one]) < _APART * length for one in others)
        if not close and (name, side) not in chosen:
            chosen[name, side] = [node]
    nodes = [node for of_name in chosen.values() for node in of_name]
    where = [(node, int(found.fatigue_part[node])) for node in nodes]
    yield from spots(where, rod.cycle.units, result.weights, rod.mesh.mirrored)


def _places(
    result: CycleResult, rod: PreparedRod, regions: list[PlaceHistory], cycle: CrankCycle, scatter: Scatter
) -> Iterator[Place]:
    """Yield the regions with the cycles of their stress at several gas loads."""
    factors = np.linspace(max(1 - scatter.reach, 0.0), 1 + scatter.reach, _GAS_FACTORS)
    if not scatter.reach:
        factors = np.array([1.0, 2.0])
    of_gas = _of_gas(rod, regions, cycle)
    nodes = np.array([spot.node for spot in regions], dtype=np.int64)
    names = place_names(rod.mesh, nodes)
    for spot, name, change in zip(regions, names, of_gas, strict=True):
        own = rod.materials[spot.part]
        surface = float(result.regions.at(np.array([spot.node])).factors(own)[0])
        material, line = line_at(own, surface)
        if line is None or criterion_strength(rod.options.fatigue, material) is None:
            continue
        every = np.stack([spot.stress + (factor - 1) * change for factor in factors])
        counted = [rainflow(history) for history in signed_equivalent(deviatoric(every))]
        amplitude, static = _cycles(rod.options.fatigue, material, counted, scatter.static)
        yield Place(
            name=name,
            count=2 if 2 * spot.place[2] > _APART * rod.mesh.bores.rod_length else 1,
            line=line.stronger(1 / material.marin.reliability),
            gas=factors,
            amplitude=amplitude,
            static=static if scatter.static else None,
            hard=is_hard(material),
            assumed=own.basquin is None,
        )


def _of_gas(rod: PreparedRod, regions: list[PlaceHistory], cycle: CrankCycle) -> list[Floats]:
    """Change of stress (6, n_instants) at the regions as the gas load is doubled, MPa."""
    degrees = cycle.degrees
    gas = [case for case in cycle.peaks.cases if case.name == "gas"]
    if not gas:
        return [np.zeros_like(spot.stress) for spot in regions]
    basis, where = rod.cycle.basis, [(spot.node, spot.part) for spot in regions]
    weights = basis.projected(basis.full(joined([gas[0], assembled()])))
    pressed = spots(where, rod.cycle.units, weights, rod.mesh.mirrored)
    course = degrees.gas / float(gas[0].gas) / np.cos(degrees.motion.rod_angle)
    return [np.outer(spot.stress[:, 0] - spot.stress[:, 1], course) for spot in pressed]


def _cycles(
    criterion: Fatigue, material: Material, counted: Sequence[tuple[Floats, Floats]], static: float
) -> tuple[Floats, Floats]:
    """Reversed amplitudes (n_gas, n_cycles), and how (n_gas, n) the largest follows the static strength."""
    amplitudes, ends = np.zeros((len(counted), _MOST_CYCLES)), np.zeros((2, len(counted)))
    for number, (mean, amplitude) in enumerate(counted):
        reversed_ = np.minimum(reversed_amplitude(criterion, mean, amplitude, material), _BROKEN)
        order = np.argsort(-reversed_)[:_MOST_CYCLES]
        amplitudes[number, : len(order)] = reversed_[order]
        ends[:, number] = mean[order[0]], amplitude[order[0]]
    followed = []
    for factor in np.exp(deviation(static) * STATIC):
        ultimate = material.ultimate_strength
        other = replace(
            material,
            yield_strength=factor * material.yield_strength,
            ultimate_strength=None if ultimate is None else factor * ultimate,
        )
        followed.append(np.minimum(reversed_amplitude(criterion, *ends, other), _BROKEN) / amplitudes[:, 0])
    return amplitudes, np.log(followed).T


def _bolts(result: CycleResult, rod: PreparedRod) -> Iterator[Place]:
    """Yield the bolts, whose stress hardly depends on the gas load: inertia pulls the cap off the rod."""
    if rod.assembling is None or not result.states:
        return
    exponent = _BOLT_EXPONENTS[rod.assembling.bolt.bolt.rolled]
    for bolt, judged in zip(result.states[0].bolts, judged_bolts(rod.assembling, result.states), strict=True):
        basquin = Basquin(judged.endurance * (2 * _BOLT_KNEE) ** (1 / exponent), -1 / exponent)
        line = LifeLine(basquin, _BOLT_KNEE, np.array([judged.endurance]), endless=True)
        amplitude = np.full((2, 1), judged.bending_amplitude)
        yield Place("bolt", bolt.count, line, np.array([1.0, 2.0]), amplitude, assumed=True)


def _hours(cycles: float, an_hour: float) -> float | None:
    return cycles / an_hour if math.isfinite(cycles) else None


def _figures(life: BLife, an_hour: float) -> BLifeFigures:
    apart = life.most > _APART_LIVES * life.least
    return BLifeFigures(
        percent=100 * life.share,
        hours=_hours(life.least, an_hour),
        at_most_hours=_hours(life.most, an_hour) if apart else None,
        at_most_unlimited=(apart and math.isinf(life.most)) or None,
        sampling_error_percent=100 * life.error,
    )
