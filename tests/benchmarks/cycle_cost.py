"""Cost of the whole crank cycle: python tests/benchmarks/cycle_cost.py [REPORT.md] [ROUNDS]

Every run is a process of its own; runs to be compared take turns, and the medians are of their ratios.
CalculiX (`ccx` on the path) solves the same mesh with one *STEP a crank angle.
"""

import math
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))

import fea.pins.pressure as pressure_loads_module
import fea.pins.pressure as series_module
from cycles import SPEEDS, direct, on_bores

from fea.analysis.pipeline import prepare
from fea.analysis.prepared_rod import PreparedRod
from fea.base.choices import Symmetry
from fea.output.inp import write_inp
from fea.solid.parity import Parity
from fea.solid.supports import determinate_restraints, plane_conditions
from fea.study.flags import Flags
from fea.study.study import load_study

COMMAND = "python tests/benchmarks/cycle_cost.py results/cycle.md"
STEPS = (1, 3, 6)
CYCLE = 721
CCX_SIZE = 8.0
ORDERS = (8, 16, 24, 32)


def seconds(folder: Path, *command: str) -> tuple[float, float]:
    """Wall and processor seconds of a program, start and end of its process included."""
    start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return time.perf_counter() - start, spent


def program(*arguments: str) -> list[str]:
    """Return the command of a run of `fea`."""
    return [sys.executable, "-m", "fea", "run", "--quiet", "--out", "run", *arguments]


def costs(rounds: int) -> list[str]:
    """Cost of one speed's cycle and of a map of a hundred, over that of the static run beside them."""
    speeds = ",".join(f"{rpm:.1f}" for rpm in np.linspace(800, 9000, 100))
    asked = {
        "static, five peak cases": ("--rpm", "6000"),
        "with `--cycle`": ("--rpm", "6000", "--cycle"),
        "map of 100 speeds": ("--rpm", speeds, "--cycle"),
    }
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in asked}
    for _ in range(rounds):
        for name, arguments in asked.items():
            with tempfile.TemporaryDirectory() as folder:
                found[name].append(seconds(Path(folder), *program(*arguments)))
    static = np.array(found["static, five peak cases"])
    rows = [
        "| run | wall s | processor s | wall over static | processor over static | goal |",
        "|---|---|---|---|---|---|",
    ]
    for (name, own), goal in zip(found.items(), ("", "1.5", "5"), strict=True):
        wall, spent = np.median(own, axis=0)
        ratio = np.median(np.array(own) / static, axis=0)
        rows.append(f"| {name} | {wall:.2f} | {spent:.2f} | {ratio[0]:.2f} | {ratio[1]:.2f} | {goal} |")
    return rows


def analysed(symmetry: Symmetry, size: float) -> PreparedRod:
    """The default study with half a cosine of pressure, not kept from an earlier call."""
    flags = Flags(size=size, symmetry=symmetry, cycle=True, pressure="cosine-180")
    return prepare(flags.applied(load_study("leon-2001")))


def superposition() -> list[str]:
    """Error at 20 random angles and three speeds against the number of unit solutions."""
    rows = [
        "| model | highest order | unit solutions | on the bores, % of peak | elsewhere |",
        "|---|---|---|---|---|",
    ]
    rows_of = {"quarter": (Symmetry.QUARTER, 8.0), "whole": (Symmetry.NONE, 10.0)}
    for name, (symmetry, size) in rows_of.items():
        rod = analysed(symmetry, size)
        on_bore = on_bores(rod)
        exact = {}
        for rpm in SPEEDS:
            angles = np.random.default_rng(int(rpm)).uniform(0, 4 * math.pi, 20)
            exact[rpm] = angles, *direct(rod, rpm, angles)
        for order in ORDERS:
            errors = _superposed(rod, order, exact)
            worst = np.max(errors[0], axis=0)
            bore, elsewhere = 100 * worst[on_bore].max(), worst[~on_bore].max()
            rows.append(f"| {name} | {order} | {errors[1]} | {bore:.2g} | {elsewhere:.1e} |")
    return rows


def _superposed(rod: PreparedRod, order: int, exact: dict) -> tuple[list[np.ndarray], int]:
    original = pressure_loads_module.series
    pressure_loads_module.series = lambda arc: series_module.series(arc, order)
    try:
        rod.__dict__.pop("cycle", None)
        cycle, errors = rod.cycle, []
        for rpm, (angles, stress, peaks) in exact.items():
            weights = cycle.weights(rod.crank_cycle(rpm), angles)
            found = cycle.units.tensor(0, weights, rod.mesh.mirrored)
            errors.append((np.abs(found - stress).max(axis=1) / peaks).max(axis=1))
    finally:
        pressure_loads_module.series = original
        rod.__dict__.pop("cycle", None)
    return errors, cycle.units.count


def calculix() -> list[str]:
    """Seconds of CalculiX for a few steps on the half rod, and what they come to for the whole cycle."""
    if not shutil.which("ccx"):
        return ["CalculiX is not installed."]
    rod = analysed(Symmetry.HALF, CCX_SIZE)
    cell = rod.mesh.cell
    fixed = plane_conditions(cell, Parity.SYMMETRIC) | determinate_restraints(cell)
    rows = ["| program | crank angles | wall s | processor s |", "|---|---|---|---|"]
    measured = []
    with tempfile.TemporaryDirectory() as folder:
        for count in STEPS:
            job, model, steps = Path(folder) / "job.inp", "", ""
            for angle in np.linspace(0, 4 * math.pi, count, endpoint=False):
                forces = rod.prescribed.respond(rod.crank_cycle(6000).at(np.array([angle])))[0].forces
                write_inp(job, cell, rod.materials[0], forces.symmetric, fixed)
                model, step = job.read_text().split("*STEP", maxsplit=1)
                steps += "*STEP" + step.replace("*CLOAD", "*CLOAD, OP=NEW")
            job.write_text(model + steps)
            wall, spent = seconds(Path(folder), "ccx", "-i", "job")
            measured.append(spent)
            rows.append(f"| CalculiX | {count} | {wall:.1f} | {spent:.1f} |")
        slope, once = np.polyfit(STEPS, measured, 1)
        whole = once + slope * CYCLE
        rows.append(
            f"| CalculiX, extrapolated: {once:.1f} s and {slope:.2f} s a step | {CYCLE} | | {whole:.0f} |"
        )
        flags = ("--rpm", "6000", "--cycle", "--symmetry", "half", "--size", str(CCX_SIZE))
        wall, spent = seconds(Path(folder), *program(*flags))
    rows.append(f"| `fea run {' '.join(flags)}` | {CYCLE} | {wall:.1f} | {spent:.1f} |")
    apart = np.abs(np.polyval([slope, once], STEPS) - measured).max()
    rows += [
        "",
        f"The same half of the rod, {len(cell.points)} nodes. Over {CYCLE} steps CalculiX would take",
        f"{whole / spent:.0f} times the processor time; the steps that are measured lie within",
        f"{apart:.1f} s of the line.",
    ]
    return rows


def main(report: str = "", rounds: str = "3") -> None:
    """Measure, print and write."""
    parts = [
        "# What the whole crank cycle costs\n",
        f"`{COMMAND}`; every run is a process of its own, the runs compared take turns.\n",
        "## Cost, leon-2001 at its default element size\n",
        *costs(int(rounds)),
        "\nThe static run solves its five peak cases at once. In the map every speed leaves `summary.json`,",
        "`study.toml` and `loads.csv`; fields are written at the worst speeds only.",
        "\n## Error of superposition against the number of unit solutions\n",
        "With `--pressure cosine-180`, at 20 random crank angles and three speeds (1000, 6000, 9000 rpm),",
        "against the same instants solved directly, in parts of each instant's largest von Mises stress. The",
        "default goes up to n = 32.\n",
        *superposition(),
        "\n## Against CalculiX\n",
        *calculix(),
    ]
    text = "\n".join(parts) + "\n"
    print(text)
    if report:
        Path(report).write_text(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
