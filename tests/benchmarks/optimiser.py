"""How good `fea optimise` is: against a search with many more evaluations, with and without moving meshes.

    python tests/benchmarks/optimiser.py search leon-2001 --min-safety 0.5 --size 10 --evaluations 30
    python tests/benchmarks/optimiser.py reference leon-2001 --min-safety 0.5 --size 10 --evaluations 2000
    python tests/benchmarks/optimiser.py moving leon-2001 --min-safety 0.5 --size 10
    python tests/benchmarks/optimiser.py noise leon-2001 --size 10

The reference searches globally first (differential evolution, half of the evaluations), then polishes the
best designs that differ (COBYQA), and counts only rods that hold on a mesh of their own.
"""

import argparse
import time

import numpy as np
from scipy.optimize import differential_evolution

from fea.apps.optimise.designs import Designs
from fea.apps.optimise.problem import variables
from fea.apps.optimise.run_optimise import search_study
from fea.apps.optimise.search import search
from fea.study.flags import Flags
from fea.study.study import load_study
from geometry.errors import GeometryError
from mesh.tetmesh import MeshError

POLISHED, APART = 5, 0.15
SEED = 1


def main() -> None:
    """Measure what was asked for and print it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=("search", "reference", "moving", "noise"))
    parser.add_argument("study")
    parser.add_argument("--min-safety", type=float, default=1.0)
    parser.add_argument("--size", type=float)
    parser.add_argument("--rpm")
    parser.add_argument("--evaluations", type=int, default=2000)
    asked = parser.parse_args()
    flags = Flags(min_safety=asked.min_safety, size=asked.size, rpm=asked.rpm)
    study = search_study(flags.applied(load_study(asked.study)))
    jobs = {"search": alone, "reference": reference, "moving": moving, "noise": noise}
    jobs[asked.what](study, asked.evaluations)


class Remeshed(Designs):
    """Designs that each have a mesh of their own."""

    def _rod(self, x):
        return *self._meshed(x), True


def found_by(study, *, morphing=True, most=150, start=None):
    """Search, say what came of it, and return it."""
    begin, free = time.perf_counter(), variables(study)
    found = search((Designs if morphing else Remeshed)(free), free.start if start is None else start, most)
    taken = time.perf_counter() - begin
    said = "holds" if found.holding else "DOES NOT HOLD"
    print(
        f"{'moved meshes' if morphing else 'new meshes'}: {1000 * found.best.mass_kg:.2f} g, {said}, "
        f"{found.count} meshes, {taken:.0f} s; {found.ended}",
        flush=True,
    )
    return found


def alone(study, evaluations):
    """Search as `fea optimise` does, without its last check."""
    found_by(study, most=evaluations)


def reference(study, evaluations):
    """Compare a search with one of many more evaluations."""
    ours = found_by(study)
    free = variables(study)
    designs = Designs(free)
    designs.begin(free.start)

    def merit(x):
        try:
            design = designs.at(x)
        except (GeometryError, MeshError):
            return 10.0
        infeasibility = float(np.linalg.norm(np.asarray(x) - design.x))  # of what was asked for
        return design.mass_kg * (1 + 10 * max(0.0, -design.margin)) + infeasibility

    count = len(free.keys)
    generations = max(1, evaluations // 2 // (8 * count) - 1)
    differential_evolution(
        merit, [(0.0, 1.0)] * count, popsize=8, maxiter=generations, polish=False, rng=SEED, tol=0
    )
    best, starts = sorted(designs.tried, key=lambda one: one.mass_kg * (1 + 10 * max(0.0, -one.margin))), []
    for design in best:
        if all(np.linalg.norm(design.x - other) > APART for other in starts):
            starts.append(design.x)
        if len(starts) == POLISHED:
            break
    print(f"global: {designs.count} meshes, {1000 * best[0].mass_kg:.2f} g", flush=True)
    each = (evaluations - designs.count) // len(starts)
    polished = [found_by(study, most=each, start=start) for start in starts]
    holding = [one.best.mass_kg for one in polished if one.holds]
    least = min(holding, default=float("nan"))
    total = designs.count + sum(one.count for one in polished)
    print(f"reference: {1000 * least:.2f} g after {total} meshes")
    print(f"ours over reference: {ours.best.mass_kg / least:.4f} with {ours.count} meshes")


def moving(study, _evaluations):
    """Compare the search on moved meshes with one on new meshes."""
    moved, made = (found_by(study, morphing=morphing) for morphing in (True, False))
    print(f"moved over new meshes: mass {moved.best.mass_kg / made.best.mass_kg:.4f}")


def noise(study, _evaluations):
    """Scatter of the limits about a parabola, along a line through the start, in percent of the factor."""
    free = variables(study)
    along = np.random.default_rng(SEED).normal(size=len(free.keys))
    along /= np.linalg.norm(along)
    steps = np.linspace(-0.05, 0.05, 21)
    for morphing in (True, False):
        designs = (Designs if morphing else Remeshed)(free)
        designs.begin(free.start)
        tried = [designs.at(free.start + step * along) for step in steps]
        for index, limit in enumerate(tried[0].constraints):
            values = np.log([design.constraints[index].low for design in tried])
            rest = values - np.polyval(np.polyfit(steps, values, 2), steps)
            print(f"{'moved' if morphing else 'new'} meshes, {limit.name}: {100 * rest.std():.3f} %")


if __name__ == "__main__":
    main()
