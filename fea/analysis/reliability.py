"""B-lives of a rod at a speed or over a duty: its places, their stress at any gas load, what first fails.

Stress at other gas loads is superposed (`fea.analysis.cycle.operation`); preload, clearances and friction, of
which stress is no linear function, act as cycles solved again say (`fea.analysis.responses`).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace

import numpy as np

from fea.analysis.assembly_report import judged_bolts
from fea.analysis.cycle.operation import (
    CountedCycles,
    Entry,
    JudgedNodes,
    Operation,
    every_cycle,
    gas_along_rod,
)
from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.life_figures import (
    BLifeFigures,
    PlaceLifeFigures,
    ReliabilityFigures,
    ResponseFigures,
)
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.responses import causes, responses
from fea.analysis.scatter import scatter_of
from fea.base.choices import Fatigue, ThreadRolled
from fea.base.material import Basquin, Material
from fea.judge.cycle_life import LONGEST, LOW_CYCLE, life_line
from fea.judge.fatigue import LifeLine, criterion_strength, reversed_amplitude
from fea.judge.reliability import STATIC, BLife, FirstFailure, Place, Scatter, deviation
from fea.rod.loading import EngineLoading
from fea.rod.places import place_name
from fea.study.scatter_table import ScatterTable
from geometry.arrays import Floats, vector

SHARES = (0.01, 0.10, 0.50)
# Places whose factor exceeds the smallest by more than this do not fail first; distance, over the length of
# the rod, within which two places of one name are one.
_REACH, _APART = 1.4, 0.05
_GAS_FACTORS, _MOST_CYCLES = 9, 64
# Of bolts by VDI 2230: cycles at the endurance limit, and exponents of the line above it, of threads rolled
# before and after heat treatment. From memory: the guideline could not be read.
_BOLT_KNEE, _BOLT_EXPONENTS = 2e6, {ThreadRolled.BEFORE: 3.0, ThreadRolled.AFTER: 6.0}
_BROKEN = 1e9  # amplitude, MPa, where mean stress alone breaks a place
_APART_LIVES = 1.1  # bounds that differ by more are both stated


def speed_operation(result: CycleResult, rod: PreparedRod, rpm: float) -> Operation:
    """Return the crank cycles of a rod at a speed, rpm, whose cycle is solved."""
    cycle, engine = rod.crank_cycle(rpm), rod.engine
    rate = engine.engine.cycles_per_hour * rpm
    entry = Entry(cycle, result.weights, rate, gas_along_rod(cycle.degrees), result.states)
    scatter = scatter_of(rod.study.scatter, engine, rod.options.fatigue).cycle_pressure
    return Operation(rod.cycle, (entry,), scatter)


def reliability_figures(
    result: CycleResult, rod: PreparedRod, operation: Operation
) -> ReliabilityFigures | None:
    """Return the B-lives at a speed; None in the low-cycle regime, or where nobody asked for assumptions.

    These are an S–N line or a peak pressure that is assumed, in a study without [scatter].
    """
    found, factor = result.envelope, result.envelope.fatigue_factor
    if result.weakest is None or factor is None:
        return None
    nodes = JudgedNodes(factor, found.fatigue_part, result.counts, result.regions)
    return _reliability(rod, operation, nodes, result.weakest.part)


def duty_reliability(rod: PreparedRod) -> ReliabilityFigures | None:
    """Return the B-lives over the duty of a rod, as `reliability_figures`; None without a duty."""
    life = rod.life
    if life is None or life.operation is None or life.nodes is None or life.figures is None:
        return None
    return _reliability(rod, life.operation, life.nodes, list(rod.mesh.parts).index(life.figures.part))


def _reliability(
    rod: PreparedRod, operation: Operation, nodes: JudgedNodes, part: int
) -> ReliabilityFigures | None:
    """Return the B-lives over an operation, whose worst place is of a part."""
    loading, table = rod.engine, rod.study.scatter
    assumed = _assumed_trace(loading) or rod.materials[part].basquin is None
    if assumed and table is None:
        return None
    given = table or ScatterTable()
    scatter = scatter_of(given, loading, rod.options.fatigue)
    places = [*_places(operation, nodes, rod, scatter), *_bolts(operation, rod)]
    where = [(place.node, int(nodes.part[place.node])) for place in places if place.node is not None]
    found, an_hour = FirstFailure(places, scatter), sum(operation.rates)
    if found.of_rod(SHARES[1]).cycles < LOW_CYCLE:
        return None
    if every_cause := list(causes(rod)):
        solved = responses(rod, operation, where, every_cause)
        places = [replace(place, responses=own) for place, own in zip(places, solved, strict=True)]
        found = FirstFailure(places, scatter)
    of_rod, rods = [found.of_rod(share) for share in SHARES], loading.engine.cylinders
    every = [[found.of_place(number, share) for share in SHARES] for number in range(len(places))]
    most = [min(lives) for lives in zip(*every, strict=True)]
    worst = [lives[1] for lives in every].index(most[1])
    of_engine = found.of_engine(SHARES[1], rods)
    failed = None if given.hours is None else found.failed(given.hours * an_hour)
    apart = any(one.cycles > _APART_LIVES * life.cycles for one, life in zip(most, of_rod, strict=True))
    return ReliabilityFigures(
        **_hours(of_rod, an_hour),
        at_most=BLifeFigures(**_hours(most, an_hour)) if apart else None,
        first=places[worst].name,
        conditional=assumed or places[worst].assumed,
        places=tuple(
            PlaceLifeFigures(
                **_hours(lives, an_hour),
                where=place.name,
                at_mm=None if place.node is None else vector(rod.mesh.whole.points[place.node]),
                count=place.count,
                assumed=place.assumed,
            )
            for place, lives in zip(places, every, strict=True)
        ),
        rods=rods,
        engine_b10_hours=_known_hours(of_engine, an_hour),
        by_hours=given.hours,
        failed_percent=failed and (100 * failed[0], 100 * failed[1]),
        samples=found.samples,
        sampling_error_percent=100 * max(life.error for life in (*of_rod, of_engine)),
        scatter_percent={cause: 100 * value for cause, value in asdict(scatter).items()},
        responses=tuple(
            ResponseFigures(
                cause=cause.name,
                deviation=cause.deviation,
                unit="µm" if cause.field == "contact" else "%",
                change_percent=(100 * math.expm1(low), 100 * math.expm1(high)),
            )
            for cause, (low, *_, high) in zip(every_cause, places[worst].responses, strict=True)
        )
        or None,
    )


def _hours(lives: Sequence[BLife], an_hour: float) -> dict[str, float | None]:
    """Return the hours of `SHARES` by their names."""
    known = (_known_hours(life, an_hour) for life in lives)
    return dict(zip(("b1_hours", "b10_hours", "b50_hours"), known, strict=True))


def _known_hours(life: BLife, an_hour: float) -> float | None:
    """Return the hours of a life of so many cycles an hour; None beyond the longest one."""
    return life.cycles / an_hour if life.cycles <= LONGEST else None


def _assumed_trace(loading: EngineLoading) -> bool:
    """Whether the peak pressure is neither measured nor given."""
    engine = loading.table
    library = engine.library()
    figure = None if library is None else library.engine.get("peak_pressure_bar")
    of_library = figure is not None and figure.assumed and figure.value == engine.peak_pressure_bar
    return engine.gas == "otto" and (engine.peak_pressure_bar is None or of_library)


def _regions(nodes: JudgedNodes, rod: PreparedRod) -> dict[tuple[str, bool], tuple[int, int]]:
    """Return the places whose factor against fatigue is near the smallest: most stressed nodes and parts.

    A place has a name and a side of the plane of motion; images across z = 0 have the same history.
    """
    points, length = rod.mesh.whole.points, rod.mesh.bores.rod_length
    chosen = nodes.counts & (points[:, 2] >= -1e-9 * length) & ~np.isnan(nodes.factor)
    left = np.where(chosen, nodes.factor, np.inf)
    most, places = _REACH * left.min(), dict[tuple[str, bool], tuple[int, int]]()
    while left.min() <= most:
        node = int(left.argmin())
        side = place_name(rod.mesh, node), bool(points[node, 1] >= 0)
        places.setdefault(side, (node, int(nodes.part[node])))
        left[np.linalg.norm(points - points[node], axis=1) <= _APART * length] = np.inf
    return places


def _places(operation: Operation, nodes: JudgedNodes, rod: PreparedRod, scatter: Scatter) -> Iterator[Place]:
    """Yield the regions with the cycles of their stress at several gas loads."""
    where = _regions(nodes, rod)
    reach = 0.1 + 4 * math.hypot(scatter.cylinder_pressure, scatter.boost) + 4.6 * scatter.cycle_pressure
    factors = np.linspace(max(1 - reach, 0.05), 1 + reach, _GAS_FACTORS)
    for (name, _), (spot, change) in zip(where, operation.places(list(where.values())), strict=True):
        material = rod.materials[spot.part]
        line = life_line(material, np.array([nodes.regions.factor(spot.node, material)]))
        if line is None or criterion_strength(rod.options.fatigue, material) is None:
            continue
        counted = [
            every_cycle([(1.0, histories)], operation.rates, operation.log)
            for histories in operation.at_gas(spot, change, (factors - 1).tolist())
        ]
        line, criterion = line.stronger(1 / material.marin.reliability), rod.options.fatigue
        amplitude, rate, static = _cycles(criterion, material, counted, line, scatter.static_strength)
        yield Place(
            name=name,
            count=2 if 2 * spot.place[2] > _APART * rod.mesh.bores.rod_length else 1,
            line=line,
            gas=factors,
            amplitude=amplitude,
            rate=rate / sum(operation.rates),
            static=static,
            assumed=material.basquin is None,
            node=spot.node,
        )


def _cycles(
    criterion: Fatigue, material: Material, counted: Sequence[CountedCycles], line: LifeLine, static: float
) -> tuple[Floats, Floats, Floats]:
    """Reversed amplitudes and rates (n_gas, n) of the cycles that damage most, by gas load.

    The third (n_gas, n_static) is the logarithm of how the first of them follows the static strength.
    """
    most = min(_MOST_CYCLES, max(len(cycles.mean) for cycles in counted))
    amplitudes, rates, ends = (np.zeros((len(counted), of)) for of in (most, most, 2))
    for number, cycles in enumerate(counted):
        reversed_ = reversed_amplitude(criterion, cycles.mean, cycles.amplitude, material)
        reversed_ = np.minimum(reversed_, _BROKEN)
        order = np.argsort(-cycles.rate / line.cycles(reversed_[:, None])[:, 0])[:most]
        amplitudes[number, : len(order)], rates[number, : len(order)] = reversed_[order], cycles.rate[order]
        ends[number] = cycles.mean[order[0]], cycles.amplitude[order[0]]
    # As it grows, the mean stress beside it falls.
    followed = [
        reversed_amplitude(criterion, ends[:, 0] / factor, ends[:, 1], material) / amplitudes[:, 0]
        for factor in np.exp(deviation(static) * STATIC)
    ]
    return amplitudes, rates, np.log(np.minimum(followed, _BROKEN)).T


def _bolts(operation: Operation, rod: PreparedRod) -> Iterator[Place]:
    """Yield the bolts, whose stress hardly depends on the gas load: inertia pulls the cap off the rod."""
    if rod.assembling is None or not operation.entries[0].states:
        return
    exponent = _BOLT_EXPONENTS[rod.assembling.bolt.bolt.rolled]
    judged = [judged_bolts(rod.assembling, entry.states) for entry in operation.entries]
    rate = np.tile(np.array(operation.rates) / sum(operation.rates), (2, 1))
    for bolt, own in zip(operation.entries[0].states[0].bolts, zip(*judged, strict=True), strict=True):
        limit = own[0].endurance
        basquin = Basquin(limit * (2 * _BOLT_KNEE) ** (1 / exponent), -1 / exponent)
        line = LifeLine(basquin, _BOLT_KNEE, np.array([limit]), math.inf)
        amplitude = [limit / each.endurance * each.bending_amplitude for each in own]
        both = np.tile(amplitude, (2, 1))
        yield Place("bolt", bolt.count, line, np.array([1.0, 2.0]), both, rate=rate, assumed=True)
