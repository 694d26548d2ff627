"""Are limits those of direct solutions, what do they cost, and are they believable?

python tests/benchmarks/limits.py points               # random limits, solved again directly
python tests/benchmarks/limits.py cost                 # against a static run and a run with --cycle
python tests/benchmarks/limits.py cost leon-2001-bolted --size 10   # without refinement
python tests/benchmarks/limits.py engines --report results/limits.md
"""

import dataclasses
import math
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scripts import reporting

from fea.analysis.buckling import buckling_report
from fea.analysis.cycle.rows import counting
from fea.analysis.engine_study import engine_study
from fea.analysis.pipeline import RefinedRod, prepare, refined_rod, solve_speed, with_cycle
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.summary import speed_summary
from fea.apps.limits.explore import RodLimits, explore
from fea.apps.limits.factors import FailureMode
from fea.apps.limits.limit_map import LimitPoint
from fea.apps.limits.run_limits import limits
from fea.base.units import BAR, DEG
from fea.judge.fatigue import fatigue_factor
from fea.judge.history import deviator_norm, deviatoric, signed_equivalent
from fea.machine.clock import Clock
from fea.rod.places import SurfaceRegions
from fea.study.engine_library import engine_names, engine_preset
from fea.study.study import Study, load_study

# Study or engine of the library, and pins.
RODS = (
    ("leon-2001", "cosine-180"),
    ("leon-2001", "contact"),
    ("columba-2022", "contact"),
    ("toyota-2jz", "cosine-180"),
    ("honda-b18c5", "contact"),
    ("suzuki-hayabusa", "contact"),
    ("leon-2001-bolted", "contact"),
)
POINTS, SEED = 20, 36
# Degrees between directly solved instants, and around those that decide. Contact makes the stress of a place
# peak within a few degrees: every 15, the least factor is up to .6 % too large.
EVERY, AROUND = 5, 6
PROMISED = 0.5  # percent
BLOCK = 4000
HEAD = (
    "engine",
    "redline rpm",
    "limit rpm",
    "ended by",
    "where",
    "throttle closed rpm",
    "peak bar",
    "limit bar",
    "boost bar",
    "ended by",
    "s",
)


def study_of(name: str, pins: str, size: float | None = None) -> Study:
    """A shipped study, or that of an engine of the library with the usual proportions."""
    if name in engine_names() and name != "leon-2001":
        with TemporaryDirectory() as folder:
            path = Path(folder, f"{name}.toml")
            path.write_text(engine_study(name), encoding="utf-8")
            study = load_study(path)
    else:
        study = load_study(name)
    pressure = None if pins == "contact" else pins
    options = dataclasses.replace(study.analysis, pressure=pressure, cycle=True)
    mesh = dataclasses.replace(study.mesh, size_mm=size or study.mesh.size_mm)
    return dataclasses.replace(study, analysis=options, mesh=mesh)


def meshed(study: Study) -> RefinedRod:
    """Refine the mesh as `fea limits` does."""
    return refined_rod(study, [max(rpm for rpm in study.speeds() if rpm)], Clock())


def direct(found: RodLimits, limit: LimitPoint) -> float:
    """The factor at a limit, from instants that are solved without unit loads."""
    rod, cycle = found.rod, found.engine.cycle(limit.rpm, limit.scale)
    angles = np.arange(0, 720, EVERY)
    if limit.worst.crank_angle is not None:
        at = round(limit.worst.crank_angle / DEG)
        angles = np.union1d(angles, (at + np.arange(-AROUND, AROUND + 1, 2)) % 720)
    for dead_centre in (0, 360):
        angles = np.union1d(angles, (dead_centre + np.arange(-AROUND, AROUND + 1, 2)) % 720)
    instants = cycle.at(angles * DEG)
    solved = rod.equilibrium(instants)
    stresses = rod.fields.stresses(solved)
    whole = rod.mesh.mirrored
    counts = counting(rod.fields.errors.masked)[whole.source]
    regions = SurfaceRegions.of(rod.mesh.cell, rod.mesh.bores).at(whole.source)
    least = math.inf
    for stress, material in zip(stresses, rod.materials, strict=True):
        surface = regions.factors(material)
        nodes = np.flatnonzero(counts & np.isfinite(stress[:, 0, 0]))
        for start in range(0, len(nodes), BLOCK):
            some = nodes[start : start + BLOCK]
            history = deviatoric(stress[some])
            if limit.mode is FailureMode.YIELD:
                factors = material.yield_strength / deviator_norm(history).max(axis=1)
            else:
                signed = signed_equivalent(history)
                high, low = signed.max(axis=1), signed.min(axis=1)
                known = fatigue_factor(
                    rod.options.fatigue, (high + low) / 2, (high - low) / 2, material, surface[some]
                )
                factors = np.full(len(some), np.inf) if known is None else known
            least = min(least, float(factors.min()))
    return least


def in_parts(found: RodLimits, limit: LimitPoint) -> float:
    """The factor at a limit of a rod in parts: over the cycle, as `fea run` finds it, on the same mesh."""
    study, mesh = found.rod.study, found.rod.mesh
    engine = study.require_engine()
    engine = dataclasses.replace(engine, gas_scale=limit.scale * (engine.gas_scale or 1.0))
    rod = prepare(dataclasses.replace(study, engine=engine), Clock(), mesh=mesh)
    solved = solve_speed(rod, limit.rpm)
    # The gas force without inertia is a load case of the run, but of no instant of a turning engine.
    cases = {name: case for name, case in solved.cases.items() if name != "gas"}
    result = with_cycle(rod, dataclasses.replace(solved, cases=cases))
    summary = speed_summary(
        RefinedRod(rod, results={limit.rpm: result}), result, buckling_report(rod, result)
    )
    envelope, bolts = summary.envelope, summary.assembly.bolts
    return {
        FailureMode.YIELD: envelope.min_safety_factor,
        FailureMode.FATIGUE: envelope.min_fatigue_safety_factor,
        FailureMode.BOLT_YIELD: bolts.yield_safety_factor,
        FailureMode.BOLT_FATIGUE: bolts.bending_fatigue_safety_factor,
    }[limit.mode]


def points(names: list[str], size: float | None) -> Iterator[str]:
    """Yield a line for each random limit of stress."""
    head = f"{'rod':<18}{'pins':<12}{'mode':<9}{'rpm':>7}{'bar':>8}"
    yield f"{head}{'superposed':>12}{'direct':>9}{'apart %':>9}{'bar %':>7}"
    random, worst = np.random.default_rng(SEED), 0.0
    share = -(-POINTS // len(RODS))
    for name, pins in RODS:
        if names and name not in names:
            continue
        adapted = meshed(study_of(name, pins, size))
        found = explore(adapted, max(rpm for rpm in adapted.rod.study.speeds() if rpm), None, _quiet)
        parts = found.rod.assembly_contact is not None
        modes = (
            FailureMode.YIELD,
            FailureMode.FATIGUE,
            *((FailureMode.BOLT_YIELD, FailureMode.BOLT_FATIGUE) if parts else ()),
        )
        every = [limit for mode in modes for limit in found.of_rays.limits.get(mode, ()) if limit is not None]
        if parts:
            solved = (own and own.limit for own in (found.speed, found.pressure))
            every = [limit for limit in (*solved, *every) if limit is not None and limit.mode in modes]
        for number in random.choice(len(every), min(share, len(every)), replace=False):
            limit = every[number]
            factor = in_parts(found, limit) if parts else direct(found, limit)
            apart = 100 * (factor / (found.rod.options.min_safety or 1.0) - 1)
            worst = max(worst, abs(apart))
            bar = found.bar_percent(limit) or math.nan
            yield (
                f"{name:<18}{pins:<12}{limit.mode.value:<9}{limit.rpm:7.0f}{limit.peak / BAR:8.1f}"
                f"{limit.worst.factor:12.4f}{factor:9.4f}{apart:9.2f}{bar:7.1f}"
                f"{' interpolated' if limit.interpolated else ''}"
            )
    promise = f"{PROMISED} % beyond the bar is promised"
    yield f"largest difference from the required factor: {worst:.2f} % ({promise})"


def _quiet(_stage: str) -> None:
    return


def _seconds(job: Callable[[], Any]) -> tuple[float, float, Any]:
    """Wall and processor time of a job, and what it returns."""
    wall, used = time.perf_counter(), time.process_time()
    done = job()
    return time.perf_counter() - wall, time.process_time() - used, done


def cost(names: list[str], size: float | None) -> Iterator[str]:
    """Yield a line for each rod: processor time of a static run, with the cycle, and of the limits."""
    head = f"{'rod':<18}{'pins':<12}{'static s':>9}{'cycle s':>9}{'answer s':>9}{'map s':>8}"
    yield f"{head}{'answer/cycle':>14}{'map/static':>12}  (wall s)"
    for name, pins in RODS:
        if names and name not in names:
            continue
        adapted = meshed(study_of(name, pins, size))
        study, mesh = adapted.rod.study, adapted.rod.mesh
        rpm = max(rpm for rpm in study.speeds() if rpm)

        def solved(study: Study = study, mesh: Any = mesh, rpm: float = rpm) -> tuple[PreparedRod, Any]:
            rod = prepare(study, Clock(), mesh=mesh)
            return rod, solve_speed(rod, rpm)

        _, static, (rod, result) = _seconds(solved)
        _, more, _ = _seconds(lambda rod=rod, result=result: with_cycle(rod, result))
        answered = list[float]()
        begun = time.perf_counter(), time.process_time()
        rod, result = solved()
        explore(
            RefinedRod(rod, results={rpm: result}),
            rpm,
            None,
            _quiet,
            lambda _found, answered=answered: answered.append(time.process_time()),
        )
        wall, used = time.perf_counter() - begun[0], time.process_time() - begun[1]
        cycle, answer = static + more, answered[0] - begun[1]
        yield (
            f"{name:<18}{pins:<12}{static:9.2f}{cycle:9.2f}{answer:9.2f}{used:8.2f}"
            f"{answer / cycle:14.2f}{used / static:12.1f}  ({wall:.1f})"
        )


def engines() -> Iterator[str]:
    """Yield a row of Markdown for each engine of the library: limits beside redline and own peak pressure."""
    yield "| " + " | ".join(HEAD) + " |"
    yield "| --- " * len(HEAD) + "|"
    for name in engine_names():
        begun = time.perf_counter()
        study = study_of(name, "contact")
        options = dataclasses.replace(study.analysis, tolerance_percent=0.0)
        study = dataclasses.replace(study, analysis=options)
        figures = limits(study, listener=lambda stage, name=name: print(name, stage, file=sys.stderr))
        speed, peak, closed = (
            figures.largest_rpm,
            figures.largest_peak_pressure_bar,
            figures.closed_throttle,
        )
        own = study.require_engine().peak_pressure_bar
        cells = (
            name,
            f"{engine_preset(name).redline_rpm:.0f}",
            "none" if speed is None else f"{speed.value:.0f} ± {speed.bar or 0:.0f}",
            "" if speed is None else speed.mode,
            "" if speed is None else speed.place,
            "" if closed is None else f"{closed.value:.0f}",
            "trace" if own is None else f"{own:.0f}",
            "none" if peak is None else f"{peak.value:.0f} ± {peak.bar or 0:.0f} at {peak.rpm:.0f} rpm",
            "" if peak is None else f"{peak.boost_bar:.1f}",
            "" if peak is None else peak.mode,
            f"{time.perf_counter() - begun:.0f}",
        )
        yield "| " + " | ".join(cells) + " |"


def main() -> None:
    """Measure what is asked for."""
    parser = reporting(__doc__)
    parser.add_argument("what", choices=("points", "cost", "engines"))
    parser.add_argument("rods", nargs="*")
    parser.add_argument("--size", type=float, help="element size, mm, without refinement")
    options = parser.parse_args()
    measured = {
        "points": lambda: points(options.rods, options.size),
        "cost": lambda: cost(options.rods, options.size),
        "engines": engines,
    }[options.what]
    lines = []
    for line in measured():
        print(line, flush=True)
        lines.append(line)
    if options.report:
        options.report.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
