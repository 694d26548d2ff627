"""Two hundred runs in one process: does memory grow, or anything stay open or behind?

    python tests/benchmarks/soak.py --count 200

Runs differ in speed, solver, element, support and material; of ten one reads a STEP file, another has its
whole cycle. Printed: memory after the warm-up and at the end, its slope a run (least squares over the minima
of ten runs, which allocation noise does not move), open files, files in the temporary directory, child
processes.
"""

import argparse
import gc
import os
import tempfile
from pathlib import Path

import numpy as np

TURN = 10  # runs after which everything repeats
SOFT = (7, 8)  # those of a nearly incompressible material
STUDY = """
[rod]
{rod}
[engine]
stroke_mm = 94.0
bore_mm = 76.0
piston_mass_kg = 1.3345
gas = "leon-2001"
"""


def resident() -> int:
    """Memory of this process, KiB."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") // 1024


def left(temporary: Path) -> tuple[int, int, int]:
    """Open files, files in the temporary directory, children."""
    children = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    return len(list(Path("/proc/self/fd").iterdir())), len(list(temporary.iterdir())), len(children)


def one(number: int, folder: Path) -> None:
    """One run of the turn."""
    from fea import run

    turn = number % TURN
    study = folder / ("step.toml" if turn == TURN - 1 else "soft.toml" if turn in SOFT else "preset.toml")
    run(
        str(study),
        rpm=1000.0 + 500 * turn,
        size=14,
        solver="cholmod" if turn in (3, 4) else "amg" if turn in (0, SOFT[1]) else "auto",
        element="p1" if turn in (5, 6) else "p2",
        support="clamped" if turn in (2, 6) else "inertia-relief",
        cycle=turn == 1,
        out=folder / "r",
    )


def main() -> None:
    """Run and measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200)
    count = parser.parse_args().count
    from geometry.cad.formats import step_file
    from geometry.presets import PRESETS
    from geometry.session import session

    with tempfile.TemporaryDirectory() as scratch:
        folder, temporary = Path(scratch, "work"), Path(scratch, "tmp")
        folder.mkdir()
        temporary.mkdir()
        tempfile.tempdir = str(temporary)
        with session():
            (folder / "rod.step").write_bytes(step_file(PRESETS["leon-2001"]))
        (folder / "preset.toml").write_text(STUDY.format(rod='preset = "leon-2001"'))
        soft = STUDY.format(rod='preset = "leon-2001"\n[material]\npreset = "leon-2001"\nnu = 0.49')
        (folder / "soft.toml").write_text(soft)
        (folder / "step.toml").write_text(STUDY.format(rod='step = "rod.step"'))
        memory = []
        for number in range(count):
            one(number, folder)
            memory.append(resident())
            if number == 2 * TURN - 1:
                before = left(temporary)
        after = left(temporary)
    lows = np.array(memory[TURN : len(memory) // TURN * TURN]).reshape(-1, TURN).min(axis=1)
    slope = np.polyfit(TURN * np.arange(len(lows)), lows, 1)[0]
    late = np.polyfit(TURN * np.arange(len(lows) // 2), lows[-(len(lows) // 2) :], 1)[0]
    print(
        "memory of every tenth of the runs, MiB:", *(f"{low / 1024:.1f}" for low in lows[:: len(lows) // 10])
    )
    print(f"{count} runs: {memory[0] / 1024:.1f} MiB after the first, {memory[-1] / 1024:.1f} MiB at the end")
    print(f"slope after the first {TURN}: {slope:.1f} KiB a run; over the second half: {late:.1f} KiB a run")
    for name, was, now in zip(("open files", "temporary files", "children"), before, after, strict=True):
        print(f"{name}: {was} after {2 * TURN} runs, {now} at the end")


if __name__ == "__main__":
    main()
