"""Does the printed bar hold the true error of a peak? On known answers, and on random rods.

    python tests/benchmarks/error_bars.py [--rods 60] [--tolerance 2] [--fresh]

Every case is a peak von Mises stress with the bar that `fea run` gives it. Known answers: Lamé's cylinder in
plane strain and with free ends, Kirsch's hole, Goodier's cavity. Rods: drawn at random with their engines,
five load cases each, at the default size, at one and a half times that, with first-order elements, and
refined to a tolerance; the reference has elements of 0.8 of the default size and, wherever the stress exceeds
0.78 of the peak in any case, of little more than a third of those there. Printed per group: how many bars
hold the error, the median of bar over error, the median bar. Outcomes are kept in error_bars.json beside
this file.
"""

import argparse
import dataclasses
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from exact_bodies import HEIGHT, MATERIAL, PLANES, PROBLEMS, solve, tetrahedralise
from rod_studies import random_study

from fea.adaptive.adapt import analysed
from fea.adaptive.wanted_size import wanted_sizes
from fea.assess.verdict import peak
from fea.choices import Element
from fea.machine.clock import Clock
from fea.pipeline import Analysis
from fea.solid.error_estimate import ErrorEstimator
from fea.solid.recovery import Recovery
from fea.solid.stress import von_mises
from fea.study.study import MeshTable, Study

KEPT = Path(__file__).with_suffix(".json")
SIZES = (0.6, 0.42, 0.3, 0.2, 0.15)
HOT, FINER, BASE = 0.78, 1 / 2.8, 0.8


def exact_peak(name: str) -> float:
    """Largest von Mises stress of the exact solution, on the inner surface of all these bodies."""
    problem = PROBLEMS[name]
    angle = np.linspace(0, np.pi / 2, 721)
    rings = [0.0] if problem.cylinder else np.linspace(0, np.pi / 2, 7)
    c, s = np.cos(angle), np.sin(angle)
    places = np.concatenate([np.stack([c, s * np.cos(t), s * np.sin(t)], axis=1) for t in rings])
    return float(von_mises(problem.stress(places)).max())


def known_answers(order: int = 2, sizes: tuple[float, ...] = SIZES) -> Iterator[dict]:
    """Rows of the bodies with exact solutions."""
    for name, problem in PROBLEMS.items():
        truth = exact_peak(name)
        for size in sizes:
            for seed in (1, 2):
                mesh = tetrahedralise(problem, size, order=order, seed=seed)
                u = solve(problem, mesh)
                recovery = Recovery(mesh, PLANES, problem.known)
                stress = recovery.nodal_stress(u, MATERIAL, traction=problem.traction(mesh))
                error = ErrorEstimator(mesh, (MATERIAL,))(u, [stress]).stress[0][:, 0]
                # An end that is only held flat is a mirror plane that recovery is not told of.
                away = (mesh.points[:, 2] > 0.6 * HEIGHT) if problem.flat_end else None
                found = peak(von_mises(stress[..., 0]), error, away)
                yield row(f"{name} {size} {seed}", found.value, found.error_percent, truth)


def row(case: str, value: float, bar_percent: float, truth: float) -> dict:
    return {
        "case": case,
        "value": value,
        "bar_percent": bar_percent,
        "truth": truth,
        "error_percent": 100 * abs(truth / value - 1),
    }


def rod_rows(seed: int, tolerance: float) -> dict[str, list[dict]]:
    """Rows of a random rod by group; empty where the rod is refused."""
    study = random_study(seed)
    if study is None:
        return {}
    rpm = study.speed.speeds()[0]
    analysis = Analysis(study, Clock())
    default, size = analysis.at(rpm).cases, analysis.mesh.size
    truth = reference(study, analysis, default, rpm)
    del analysis

    def rows(cases: tuple) -> list[dict]:
        return [
            row(f"rod {seed} {c.case.name}", c.peak.value, c.peak.error_percent, truth[c.case.name])
            for c in cases
        ]

    def at(mesh: MeshTable) -> list[dict]:
        return rows(Analysis(dataclasses.replace(study, mesh=mesh), Clock()).at(rpm).cases)

    options = dataclasses.replace(study.analysis, tolerance_percent=tolerance)
    refined = analysed(dataclasses.replace(study, analysis=options), (rpm,), Clock())
    return {
        "rods, default": rows(default),
        "rods, coarse": at(MeshTable(size_mm=1.5 * size)),
        "rods, first order": at(MeshTable(element=Element.P1)),
        f"rods, refined to {tolerance:g} %": rows(refined.at(rpm).cases),
    }


def reference(study: Study, analysis: Analysis, cases: tuple, rpm: float) -> dict[str, float]:
    """Peak of each case with small elements where it is hot."""
    heat = np.max([case.von_mises / case.peak.value for case in cases], axis=0)
    wanted = wanted_sizes(analysis.mesh, np.where(heat > HOT, FINER, 1.0))
    fine = dataclasses.replace(study, mesh=MeshTable(size_mm=BASE * analysis.mesh.size))
    found = Analysis(fine, Clock(), [wanted]).at(rpm)
    return {case.case.name: case.peak.value for case in found.cases}


def report(groups: dict[str, list[dict]]) -> None:
    """Print coverage and medians."""
    print(f"{'group':32s} cases  held   median bar/error  median bar %  worst error/bar")
    for name, rows in groups.items():
        bar = np.array([r["bar_percent"] for r in rows])
        error = np.array([r["error_percent"] for r in rows])
        held, ratio = np.mean(error <= bar), np.median(bar / np.maximum(error, 0.01))
        worst = (error / bar).max()
        print(f"{name:32s} {len(rows):5d}  {held:.3f}  {ratio:16.2f}  {np.median(bar):12.2f}  {worst:15.2f}")


def grouped(kept: dict[str, dict[str, list[dict]]]) -> dict[str, list[dict]]:
    groups: dict[str, list[dict]] = {}
    for found in kept.values():
        for name, rows in found.items():
            groups.setdefault(name, []).extend(rows)
    second = [r for name, rows in groups.items() if "first order" not in name for r in rows]
    return {"all of second order": second, **groups}


def main() -> None:
    """Compute what is not kept yet, and report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rods", type=int, default=60, help="seeds; about half are refused")
    parser.add_argument("--tolerance", type=float, default=2.0)
    parser.add_argument("--fresh", action="store_true", help="forget what is kept")
    arguments = parser.parse_args()
    kept = {} if arguments.fresh or not KEPT.exists() else json.loads(KEPT.read_text())
    jobs: dict[str, Callable[[], dict[str, list[dict]]]] = {
        "known": lambda: {"known answers": list(known_answers())},
        "known, first order": lambda: {"known answers, first order": list(known_answers(1, SIZES[1:]))},
    }
    for seed in range(arguments.rods):
        jobs[f"rod {seed}"] = lambda seed=seed: rod_rows(seed, arguments.tolerance)
    for name, job in jobs.items():
        if name in kept:
            continue
        try:
            kept[name] = job()
        except Exception as error:
            print(f"{name}: {error}")
            continue
        KEPT.write_text(json.dumps(kept, indent=0))
        print(name, end=" ", flush=True)
    print()
    report(grouped(kept))


if __name__ == "__main__":
    main()
