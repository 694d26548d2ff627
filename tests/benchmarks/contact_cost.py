"""Cost of contact and oil films over the static run with prescribed pressures on the same mesh.

    python tests/benchmarks/contact_cost.py [--rounds 5] [--report FILE.md]

Every run is a process of its own that draws, meshes, solves and recovers; runs that are compared take turns,
and the medians are of their ratios. *Static* has five load cases with half-cosine pressures. Of films, the
time is that beyond five cases under contact, and the memory that of all.
"""

import dataclasses
import json
import statistics
import sys
import time
from typing import cast

from scripts import command, measured, publish, reporting, spread

STUDY, RPM, MAP = "leon-2001", 6000.0, (2000.0, 7940.0, 60.0)
DEFAULT, FINE = None, 3.0
# What is compared, with the goals: ratios of seconds, of processor time (user and system) and of memory.
MEASURED = ("seconds", "processor", "MiB")
RUNS = (
    ("five cases", "contact", DEFAULT, (1.4, 1.25, None)),
    ("721 angles", "cycle", DEFAULT, (3.0, None, 2.0)),
    ("five cases, 3 mm", "contact", FINE, (None, None, None)),
    ("721 angles, 3 mm", "cycle", FINE, (4.0, None, None)),
    ("map of 100 speeds", "map", DEFAULT, (12.0, None, None)),
    ("film of the big end", "big film", DEFAULT, (None, None, None)),
    ("films of both ends", "films", DEFAULT, (2.5, None, 2.0)),
)
FILMS = ("big film", "films")


def work(mode: str, size: float | None) -> dict[str, float]:
    """Run one of the modes; times without the imports, and the peak memory of the process."""
    from fea.analysis.film import film_at, films_at
    from fea.analysis.many_speeds import SpeedSweep
    from fea.analysis.meshing import mesh_loaded
    from fea.analysis.pipeline import prepare, solve_speed, with_cycle
    from fea.base.choices import CONTACT
    from fea.machine.clock import Clock
    from fea.machine.system import peak_memory
    from fea.pins.contact import ContactPins  # loaded before the clock starts
    from fea.study.option_tables import MeshTable
    from fea.study.study import load_study
    from mesh.sizing import default_size

    study = load_study(STUDY)
    mesh = MeshTable(size_mm=size or default_size(study.rod.length))
    touched = dataclasses.replace(study.analysis, pressure=CONTACT, cycle=mode in ("cycle", "map"))
    study = dataclasses.replace(study, analysis=touched, mesh=mesh)
    start, processor = time.perf_counter(), time.process_time()
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
        elif mode in FILMS:
            (films_at if mode == "films" else film_at)(rod, RPM)
    return {
        "seconds": time.perf_counter() - start,
        "processor": time.process_time() - processor,
        "MiB": peak_memory(),
        "nodes": len(meshed.whole.points),
        "unknowns": cast("ContactPins", rod.pins).contact.problem.unfolding.size if mode != "static" else 0,
    }


def ratios(rounds: list[list[dict[str, float]]], measure: str) -> list[float]:
    """Ratio of each round's last run to the first; of time, less that of the one between them."""
    beside = 0.0 if measure == "MiB" else 1.0
    return [
        (last[measure] - beside * sum(run[measure] for run in between)) / first[measure]
        for first, *between, last in rounds
    ]


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
        "# What contact and films cost",
        "",
        f"Made by `{command()}`. Ratios to the static run on the same mesh, median (least … largest) of",
        f"{arguments.rounds} pairs that took turns, or of one at {FINE:g} mm and for the map; rod: {STUDY}",
        f"at {RPM:g} rpm. Of films, the time is that beyond five cases under contact.",
        "",
        "| run | time | goal | processor time | goal | memory | goal | static s | nodes | unknowns |",
        "| --- | --- | --- | --- | --- | --- | --- | ---: | ---: | ---: |",
    ]
    for name, mode, size, goals in RUNS:
        rounds = 1 if mode == "map" or size == FINE else arguments.rounds
        modes = ("static", "contact", mode) if mode in FILMS else ("static", mode)
        runs = [[measured(__file__, each, size) for each in modes] for _ in range(rounds)]
        cells = [name]
        for measure, goal in zip(MEASURED, goals, strict=True):
            cells += [spread(ratios(runs, measure)), "–" if goal is None else f"{goal:g}"]
        seconds = statistics.median(first["seconds"] for first, *_ in runs)
        cells += [f"{seconds:.2f}", *(str(runs[0][-1][count]) for count in ("nodes", "unknowns"))]
        lines.append(f"| {' | '.join(cells)} |")
        print(lines[-1], file=sys.stderr, flush=True)
    text = "\n".join([*lines, ""])
    publish(text, arguments.report)


if __name__ == "__main__":
    main()
