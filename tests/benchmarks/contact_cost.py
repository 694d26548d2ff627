"""What contact costs over the static run with prescribed pressures on the same mesh.

    python tests/benchmarks/contact_cost.py [--rounds 5] [--report FILE.md]

Every run is a process of its own that draws, meshes, solves and recovers; runs that are compared take turns,
and the medians are of their ratios. *Static* has five load cases with half-cosine pressures.
"""

import argparse
import dataclasses
import json
import statistics
import sys
import time
from pathlib import Path
from typing import cast

from own_process import measured, spread

STUDY, RPM, MAP = "leon-2001", 6000.0, (2000.0, 7940.0, 60.0)
DEFAULT, FINE = None, 3.0
RUNS = (
    ("five cases", "contact", DEFAULT, 1.6),
    ("721 angles", "cycle", DEFAULT, 3.5),
    ("five cases, 3 mm", "contact", FINE, None),
    ("721 angles, 3 mm", "cycle", FINE, 6.0),
    ("map of 100 speeds", "map", DEFAULT, 25.0),
)


def work(mode: str, size: float | None) -> dict[str, float]:
    """Run one of the modes; seconds without the imports, and the peak memory of the process."""
    from fea.analysis.many_speeds import SpeedSweep
    from fea.analysis.meshing import mesh_loaded
    from fea.analysis.prepare import prepare
    from fea.analysis.speed import solve_speed, with_cycle
    from fea.base.choices import CONTACT
    from fea.machine.clock import Clock
    from fea.pins.contact import ContactPins  # loaded before the clock starts
    from fea.study.option_tables import MeshTable
    from fea.study.study import load_study
    from geometry.system import peak_memory
    from mesh.sizing import default_size

    study = load_study(STUDY)
    mesh = MeshTable(size_mm=size or default_size(study.rod.length))
    touched = dataclasses.replace(study.analysis, pressure=CONTACT, cycle=mode in ("cycle", "map"))
    study = dataclasses.replace(study, analysis=touched, mesh=mesh)
    start = time.perf_counter()
    meshed = mesh_loaded(study, Clock())  # for all modes that of contact
    if mode == "static":
        plain = dataclasses.replace(study.analysis, pressure="cosine-180")
        study = dataclasses.replace(study, analysis=plain)
    rod = prepare(study, mesh=meshed)
    if mode == "map":
        first, last, step = MAP
        speeds = [first + step * k for k in range(round((last - first) / step) + 1)]
        sweep = SpeedSweep(rod, speeds)
        assert len(speeds) == 100
        assert sweep.critical
    else:
        result = solve_speed(rod, RPM)
        if mode == "cycle":
            with_cycle(rod, result)
    return {
        "seconds": time.perf_counter() - start,
        "MiB": peak_memory(),
        "nodes": len(meshed.whole.points),
        "unknowns": cast("ContactPins", rod.pins).contact.problem.unfolding.size if mode != "static" else 0,
    }


def main() -> None:
    """Measure every mode against the static run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--worker")
    parser.add_argument("--size", type=float)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--report", type=Path)
    arguments = parser.parse_args()
    if arguments.worker:
        print(json.dumps(work(arguments.worker, arguments.size)))
        return
    command = " ".join(["python tests/benchmarks/contact_cost.py", *sys.argv[1:]])
    lines = [
        "# What contact costs",
        "",
        f"Made by `{command}`. Ratios to the static run on the same mesh, median (least … largest) of",
        f"{arguments.rounds} pairs that took turns, or of one at {FINE:g} mm and for the map; rod: {STUDY}",
        f"at {RPM:g} rpm.",
        "",
        "| run | time / static | goal | memory / static | static s | nodes | unknowns |",
        "| --- | --- | --- | --- | ---: | ---: | ---: |",
    ]
    for name, mode, size, goal in RUNS:
        rounds = 1 if mode == "map" or size == FINE else arguments.rounds
        pairs = [(measured(__file__, "static", size), measured(__file__, mode, size)) for _ in range(rounds)]
        times = [other["seconds"] / one["seconds"] for one, other in pairs]
        memory = statistics.median(other["MiB"] / one["MiB"] for one, other in pairs)
        seconds = statistics.median(one["seconds"] for one, _ in pairs)
        around = spread(times, statistics.median(times))
        nodes, unknowns = pairs[0][1]["nodes"], pairs[0][1]["unknowns"]
        asked = "–" if goal is None else f"{goal:g}"
        lines.append(f"| {name} | {around} | {asked} | {memory:.2f} | {seconds:.2f} | {nodes} | {unknowns} |")
        print(lines[-1], file=sys.stderr, flush=True)
    text = "\n".join([*lines, ""])
    print(text)
    if arguments.report:
        arguments.report.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
