"""B-lives of a rod at one speed: its places, how their stress follows the gas load, and what first fails.

Stress over the cycle is that of the cycle, plus the change of the gas load times the stress of the gas alone:
the peak case ``gas``, whose force has the direction of the rod, as the wall takes the rest. So nothing is
solved again. It leaves out that a pin touches another part of its bore under another force; whole runs at
other pressures say how much that is (`tests/benchmarks/scatter.py`).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict

import numpy as np

from fea.analysis.assembly_report import judged_bolts
from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.cycle.unit_solutions import PlaceHistory, spots
from fea.analysis.life_figures import BLifeFigures, PlaceLifeFigures, ReliabilityFigures
from fea.analysis.prepared_rod import PreparedRod
from fea.base.choices import Fatigue, ThreadRolled
from fea.base.material import Basquin, Material
from fea.judge.cycle_life import LONGEST, LOW_CYCLE, line_at
from fea.judge.fatigue import LifeLine, criterion_strength, reversed_amplitude
from fea.judge.history import deviatoric, signed_equivalent
from fea.judge.rainflow import rainflow
from fea.judge.reliability import STATIC, TAIL, BLife, FirstFailure, Place, Scatter, deviation
from fea.rod.loading import EngineLoading
from fea.rod.places import place_name
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
    """Return the B-lives at a speed; None in the low-cycle regime, or where nobody asked for assumptions.

    These are an S–N line or a peak pressure that is assumed, in a study without [scatter].
    """
    loading, table = rod.loading, rod.study.scatter
    if result.weakest is None or not isinstance(loading, EngineLoading):
        return None
    assumed = _assumed_trace(loading) or rod.materials[result.weakest.part].basquin is None
    if assumed and table is None:
        return None
    given = table or ScatterTable()
    scatter = scatter_of(given, loading, rod.options.fatigue)
    places = [*_places(result, rod, rod.crank_cycle(rpm), scatter), *_bolts(result, rod)]
    found, an_hour = FirstFailure(places, scatter), loading.engine.cycles_per_hour * rpm
    of_rod, rods = [found.of_rod(share) for share in SHARES], loading.engine.cylinders
    if of_rod[1].cycles < LOW_CYCLE:
        return None
    every = [[found.of_place(number, share) for share in SHARES] for number in range(len(places))]
    most = [min(lives) for lives in zip(*every, strict=True)]
    first = places[[lives[1] for lives in every].index(most[1])]
    of_engine = found.of_engine(SHARES[1], rods)
    failed = None if given.hours is None else found.failed(given.hours * an_hour)
    apart = any(one.cycles > _APART_LIVES * life.cycles for one, life in zip(most, of_rod, strict=True))
    return ReliabilityFigures(
        **_hours(of_rod, an_hour),
        at_most=BLifeFigures(**_hours(most, an_hour)) if apart else None,
        first=first.name,
        conditional=assumed or first.assumed,
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
    )


def _hours(lives: Sequence[BLife], an_hour: float) -> dict[str, float | None]:
    """Return the hours of `SHARES` by their names."""
    known = (_known_hours(life, an_hour) for life in lives)
    return dict(zip(("b1_hours", "b10_hours", "b50_hours"), known, strict=True))


def _known_hours(life: BLife, an_hour: float) -> float | None:
    """Return the hours of a life of so many cycles an hour; None beyond the longest one."""
    return life.cycles / an_hour if life.cycles <= LONGEST else None


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


def _regions(result: CycleResult, rod: PreparedRod) -> Iterator[tuple[str, PlaceHistory]]:
    """Yield the places whose factor against fatigue is near the smallest, at their most stressed nodes.

    A place has a name and a side of the plane of motion; images across z = 0 have the same history.
    """
    factor, points = result.envelope.fatigue_factor, rod.mesh.whole.points
    if factor is None:
        return
    length = rod.mesh.bores.rod_length
    chosen = result.counts & (points[:, 2] >= -1e-9 * length) & ~np.isnan(factor)
    left = np.where(chosen, factor, np.inf)
    most, places = _REACH * left.min(), dict[tuple[str, bool], tuple[int, int]]()
    while left.min() <= most:
        node = int(left.argmin())
        side = place_name(rod.mesh, node), bool(points[node, 1] >= 0)
        places.setdefault(side, (node, int(result.envelope.fatigue_part[node])))
        left[np.linalg.norm(points - points[node], axis=1) <= _APART * length] = np.inf
    histories = spots(places.values(), rod.cycle.units, result.weights, rod.mesh.mirrored)
    yield from zip((name for name, _ in places), histories, strict=True)


def _places(result: CycleResult, rod: PreparedRod, cycle: CrankCycle, scatter: Scatter) -> Iterator[Place]:
    """Yield the regions with the cycles of their stress at several gas loads."""
    names, regions = zip(*_regions(result, rod), strict=True)
    reach = 0.1 + 4 * math.hypot(scatter.cylinder_pressure, scatter.boost) + 4.6 * scatter.cycle_pressure
    factors = np.linspace(max(1 - reach, 0.05), 1 + reach, _GAS_FACTORS)
    for name, spot, change in zip(names, regions, _of_gas(rod, regions, cycle), strict=True):
        own = rod.materials[spot.part]
        surface = result.regions.factor(spot.node, own)
        material, line = line_at(own, surface)
        if line is None or criterion_strength(rod.options.fatigue, material) is None:
            continue
        every = np.stack([spot.stress + (factor - 1) * change for factor in factors])
        counted = [rainflow(history) for history in signed_equivalent(deviatoric(every))]
        amplitude, static = _cycles(rod.options.fatigue, material, counted, scatter.static_strength)
        yield Place(
            name=name,
            count=2 if 2 * spot.place[2] > _APART * rod.mesh.bores.rod_length else 1,
            line=line.stronger(1 / material.marin.reliability),
            gas=factors,
            amplitude=amplitude,
            static=static,
            assumed=own.basquin is None,
            node=spot.node,
        )


def varied_cycles(spot: PlaceHistory, rod: PreparedRod, rpm: float) -> list[tuple[float, Floats]]:
    """Shares of cycles, and their signed stress (n_instants,), MPa, at a place, by pressure.

    Empty without scatter. Of share 0 are cycles of three standard deviations, which any long life contains.
    """
    loading = rod.loading
    if not isinstance(loading, EngineLoading):
        return []
    scatter = scatter_of(rod.study.scatter or ScatterTable(), loading, rod.options.fatigue).cycle_pressure
    if not scatter:
        return []
    deviations, weights = np.polynomial.hermite_e.hermegauss(5)
    shares = [*(weights / weights.sum()).tolist(), 0.0, 0.0]
    factors = np.maximum(scatter * np.append(deviations, [-TAIL, TAIL]), -1.0)
    (change,) = _of_gas(rod, [spot], rod.crank_cycle(rpm))
    signed = signed_equivalent(deviatoric(spot.stress + factors[:, None, None] * change))
    return list(zip(shares, signed, strict=True))


def _of_gas(rod: PreparedRod, regions: Sequence[PlaceHistory], cycle: CrankCycle) -> list[Floats]:
    """Change of stress (6, n_instants) at the regions as the gas load is doubled, MPa."""
    gas = [case for case in cycle.peaks.cases if case.name == "gas"]
    if not gas:
        return [np.zeros_like(spot.stress) for spot in regions]
    basis, where = rod.cycle.basis, [(spot.node, spot.part) for spot in regions]
    weights = basis.projected(basis.full(joined([gas[0], assembled()])))
    pressed = spots(where, rod.cycle.units, weights, rod.mesh.mirrored)
    course = cycle.degrees.gas / float(gas[0].gas) / np.cos(cycle.degrees.motion.rod_angle)
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
    # As it grows, the mean stress beside it falls.
    followed = [
        reversed_amplitude(criterion, ends[0] / factor, ends[1], material) / amplitudes[:, 0]
        for factor in np.exp(deviation(static) * STATIC)
    ]
    return amplitudes, np.log(np.minimum(followed, _BROKEN)).T


def _bolts(result: CycleResult, rod: PreparedRod) -> Iterator[Place]:
    """Yield the bolts, whose stress hardly depends on the gas load: inertia pulls the cap off the rod."""
    if rod.assembling is None or not result.states:
        return
    exponent = _BOLT_EXPONENTS[rod.assembling.bolt.bolt.rolled]
    for bolt, judged in zip(result.states[0].bolts, judged_bolts(rod.assembling, result.states), strict=True):
        basquin = Basquin(judged.endurance * (2 * _BOLT_KNEE) ** (1 / exponent), -1 / exponent)
        line = LifeLine(basquin, _BOLT_KNEE, np.array([judged.endurance]), math.inf)
        amplitude = np.full((2, 1), judged.bending_amplitude)
        yield Place("bolt", bolt.count, line, np.array([1.0, 2.0]), amplitude, assumed=True)
