"""Does the printed bar hold the true error of a peak? On known answers, and on rods drawn at random.

    python tests/benchmarks/error_bars.py [--rods 60] [--tolerance 2] [--report results/error-bars.md]

Every case is a peak von Mises stress with the bar that `fea run` gives it. Known answers: Lamé's cylinder in
plane strain and with free ends, Kirsch's hole, Goodier's cavity. Rods: random ones in random engines, and
the shipped studies at speeds drawn at random, up to five load cases each, at the default size, at one and a
half times that, with first-order elements, and refined to a tolerance. Outcomes are kept in error_bars/
beside this file, so that a run that was stopped goes on.
"""

import argparse
import dataclasses
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from error_bar_table import FACTORS, report_text
from exact_bodies import HEIGHT, MATERIAL, PLANES, PROBLEMS, solve, tetrahedralise
from rod_studies import random_study

from fea.adaptive.adapt import analysed
from fea.adaptive.wanted_size import wanted_sizes
from fea.assess.verdict import peak
from fea.choices import Element
from fea.machine.clock import Clock
from fea.pipeline import Analysis
from fea.results import CaseResult
from fea.stress.error_estimate import STRESS_FACTOR, ErrorEstimator
from fea.stress.recovery import Recovery
from fea.stress.stress import von_mises
from fea.study.study import MeshTable, SpeedTable, Study, load_study

KEPT = Path(__file__).with_suffix("")
SIZES = (0.6, 0.42, 0.3, 0.2, 0.15)
SHIPPED, DRAWS = ("leon-2001", "columba-2022", "molina-2024"), 2
# The reference: elements of this over the default size, and where the stress of any case exceeds a share of
# its peak, smaller by the factor beside it.
BASE, HOT = 0.9, {0.75: 1 / 2.2, 0.9: 1 / 4.5}

Groups = dict[str, list[dict]]


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
                yield row(f"{name} {size} {seed}", order, (von_mises(stress[..., 0]), error), away, truth)


def row(case: str, order: int, field: tuple, masked: np.ndarray | None, truth: float) -> dict:
    """What a case printed, with the bars that other factors on the estimate would give."""
    value, error = field
    unit = error / STRESS_FACTOR[order]
    bars = [peak(value, factor * unit, masked).error_percent for factor in FACTORS[order]]
    found = peak(value, error, masked)
    return {
        "case": case,
        "value": found.value,
        "order": order,
        "bars_percent": bars,
        "truth": truth,
        "error_percent": 100 * abs(truth / found.value - 1),
    }


def rod_rows(name: str, study: Study, tolerance: float) -> Groups:
    """Rows of a rod by group."""
    rpm = study.speed.speeds()[0]
    analysis = Analysis(study, Clock())
    default, size = analysis.at(rpm).cases, analysis.mesh.size
    fine = reference(study, analysis, default, rpm)
    del analysis

    def rows(cases: tuple[CaseResult, ...], order: int = 2) -> list[dict]:
        return [
            row(f"{name} {c.case.name}", order, c.judged[0], c.error.masked, fine[c.case.name].peak.value)
            | {"reference_bar_percent": fine[c.case.name].peak.error_percent, "verdict": c.verdict().value}
            for c in cases
        ]

    def at(mesh: MeshTable) -> list[dict]:
        cases = Analysis(dataclasses.replace(study, mesh=mesh), Clock()).at(rpm).cases
        return rows(cases, 1 if mesh.element is Element.P1 else 2)

    options = dataclasses.replace(study.analysis, tolerance_percent=tolerance)
    refined = analysed(dataclasses.replace(study, analysis=options), (rpm,), Clock())
    return {
        "rods, default": rows(default),
        "rods, coarse": at(MeshTable(size_mm=1.5 * size)),
        "rods, first order": at(MeshTable(element=Element.P1)),
        f"rods, refined to {tolerance:g} % (factor {STRESS_FACTOR[2]:g})": rows(refined.at(rpm).cases),
    }


def reference(study: Study, analysis: Analysis, cases: tuple, rpm: float) -> dict[str, CaseResult]:
    """Each case with small elements where it is hot."""
    heat = np.max([case.von_mises / case.peak.value for case in cases], axis=0)
    ratio = np.ones_like(heat)
    for share, factor in HOT.items():
        ratio[heat > share] = factor
    fine = dataclasses.replace(study, mesh=MeshTable(size_mm=BASE * analysis.mesh.size))
    found = Analysis(fine, Clock(), [wanted_sizes(analysis.mesh, ratio)]).at(rpm)
    return {case.case.name: case for case in found.cases}


def drawn_studies(rods: int) -> Iterator[tuple[str, Study]]:
    """Shipped studies at random speeds, then random rods in random engines."""
    for name in SHIPPED:
        study = load_study(name)
        for draw in range(DRAWS):
            share = np.random.default_rng([len(name), draw]).uniform(0.3, 1.1)
            rpm = round(share * max(study.speed.speeds()))
            yield f"{name} {rpm} rpm", dataclasses.replace(study, speed=SpeedTable(rpm=float(rpm)))
    for seed in range(rods):
        study = random_study(seed)
        if study is not None:
            yield f"rod {seed}", study


def main() -> None:
    """Compute what is not kept yet, and report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rods", type=int, default=60, help="seeds; about two thirds are refused")
    parser.add_argument("--tolerance", type=float, default=2.0)
    parser.add_argument("--report", type=Path)
    arguments = parser.parse_args()
    jobs: dict[str, Callable[[], Groups]] = {
        "known": lambda: {"known answers": list(known_answers())},
        "known, first order": lambda: {"known answers, first order": list(known_answers(1, SIZES[1:]))},
    }
    for name, study in drawn_studies(arguments.rods):
        jobs[name] = lambda name=name, study=study: rod_rows(name, study, arguments.tolerance)
    kept: dict[str, Groups] = {}
    for name, job in jobs.items():
        file = KEPT / f"{name.replace(' ', '-')}.json"
        try:
            kept[name] = json.loads(file.read_text()) if file.exists() else job()
        except Exception as error:
            print(f"{name}: {error}", file=sys.stderr)
            continue
        KEPT.mkdir(exist_ok=True)
        file.write_text(json.dumps(kept[name]))
        print(name, end=", ", flush=True, file=sys.stderr)
    text = report_text(kept, f"python tests/benchmarks/error_bars.py --rods {arguments.rods}")
    print(text)
    if arguments.report:
        arguments.report.write_text(text)


if __name__ == "__main__":
    main()
