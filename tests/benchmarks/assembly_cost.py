"""Cost of a rod in parts over a static run, of the same mesh and of the rod in one piece.

    python tests/benchmarks/assembly_cost.py [--rounds 5] [--report FILE.md]

Every run is a process of its own that draws, meshes, solves and recovers; runs that are compared take turns,
and the medians are of their ratios. The assembly has a cap, bolts, a pressed-in bushing and bearing shells,
with friction. Both static runs have five load cases with half-cosine pressures: *same mesh* is that of the
assembly with all its parts, grown together where they touch; *one piece* is the rod without parts, with
elements of the same size.
"""

import dataclasses
import json
import statistics
import sys
import time
from pathlib import Path
from typing import cast
from unittest.mock import patch

import numpy as np
from scripts import command, measured, publish, reporting, spread

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

# By name: the mode, and how many static runs it may cost.
RUNS = {"five cases": ("assembled", 3.0), "721 angles": ("cycle", 8.0)}
STATIC = {"same mesh": "bonded", "one piece": "solid"}


def work(mode: str, size: float | None) -> dict[str, float]:
    """Run one of the modes; times without the imports, and the peak memory of the process."""
    from assemblies import study

    from fea.analysis.meshing import mesh_loaded
    from fea.analysis.pipeline import prepare, solve_speed, with_cycle
    from fea.machine.clock import Clock
    from fea.machine.system import peak_memory
    from fea.pins.assembly import AssemblyPins  # loaded before the clock starts
    from fea.study.option_tables import MeshTable
    from mesh.sizing import default_size

    asked = study()
    asked = dataclasses.replace(asked, mesh=MeshTable(size_mm=size or default_size(asked.rod.length)))
    plain = dataclasses.replace(asked.analysis, pressure="cosine-180")
    alone = dataclasses.replace(asked, assembly=None, analysis=plain)
    if mode == "cycle":
        asked = dataclasses.replace(asked, analysis=dataclasses.replace(asked.analysis, cycle=True))
    start, processor = time.perf_counter(), time.process_time()
    if mode == "bonded":  # parts keep the nodes that they share
        with patch("fea.rod.meshed_rod.separated", lambda mesh, _: (mesh, np.arange(len(mesh.points)))):
            rod = prepare(alone, mesh=mesh_loaded(asked, Clock()))
    else:
        rod = prepare(alone if mode == "solid" else asked)
    result = solve_speed(rod, asked.speed.speeds()[0])
    if mode == "cycle":
        result = with_cycle(rod, result)
    seconds, processor = time.perf_counter() - start, time.process_time() - processor
    return {
        "seconds": seconds,
        "processor": processor,
        "MiB": peak_memory(),
        "nodes": len(rod.mesh.whole.points),
        "unknowns": 0
        if mode in STATIC.values()
        else cast("AssemblyPins", rod.pins).contact.problem.unfolding.size,
        "failed": sum(not check.passed for check in result.checks.values()),
    }


def main() -> None:
    """Measure every mode against the static run."""
    parser = reporting(__doc__)
    parser.add_argument("--worker")
    parser.add_argument("--size", type=float)
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    if arguments.worker:
        print(json.dumps(work(arguments.worker, arguments.size)))
        return
    lines = [
        "# What a rod in parts costs",
        "",
        f"Made by `{command()}`: León's rod with cap, bolts, bushing and shells.",
        "Ratios to the static run of the same mesh, grown together where parts touch, and of the rod in one",
        f"piece: median (least … largest) of {arguments.rounds} rounds of runs that took turns.",
        "",
        "| run | over | time | goal | processor | memory | static s | its nodes | nodes | size | failed |",
        "| --- | --- | --- | --- | --- | --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    modes = [*STATIC.values(), *(mode for mode, _ in RUNS.values())]
    rounds = [
        {mode: measured(__file__, mode, arguments.size) for mode in modes} for _ in range(arguments.rounds)
    ]
    for name, (mode, goal) in RUNS.items():
        for over, static in STATIC.items():
            pairs = [(own[static], own[mode]) for own in rounds]
            ratios = {
                measure: [other[measure] / one[measure] for one, other in pairs]
                for measure in ("seconds", "processor", "MiB")
            }
            time_ratio, processor_ratio, memory_ratio = (spread(of_pairs) for of_pairs in ratios.values())
            seconds = statistics.median(one["seconds"] for one, _ in pairs)
            one, other = pairs[0]
            lines.append(
                f"| {name} | {over} | {time_ratio} | {goal:g} | {processor_ratio} | {memory_ratio} "
                f"| {seconds:.2f} | {one['nodes']} | {other['nodes']} | {other['unknowns']} "
                f"| {other['failed']} |"
            )
            print(lines[-1], file=sys.stderr, flush=True)
    text = "\n".join([*lines, ""])
    publish(text, arguments.report)


if __name__ == "__main__":
    main()
