"""Compare `fea` with CalculiX, NGSolve and SfePy on the same second-order mesh and the same loads.

    python tests/benchmarks/speed --peer-python PYTHON [--dofs 20000,40000,105000] [--rounds 5]

PYTHON is an interpreter with the dependency group `bench` (ngsolve, sfepy); CalculiX is `ccx` on the path
(Debian: calculix-ccx). Every run is a process of its own, the programs take turns within each round, and
each answer is compared with ours. Runs are kept in `--folder` (ignored by git): a second call goes on where
the first one stopped, `--minutes` ends a slice early, `--fresh` starts anew. `--report` writes
results/speed.md from what is there.
"""

import argparse
import shutil
import sys
from pathlib import Path

from programs import PROCESSES, PROGRAMS
from runs import Bench, Limits, slice_of

ROOT = Path(__file__).parents[3]


def main() -> None:
    parser = argparse.ArgumentParser(
        "speed", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--dofs", default="20000,40000,105000", help="sizes of the whole rod")
    parser.add_argument("--programs", default=",".join(PROGRAMS), help=f"of {', '.join(PROGRAMS)}")
    parser.add_argument("--process-dofs", type=int, default=64_485, help="size of the whole process; 0: none")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=600, help="longest run")
    parser.add_argument("--memory-gb", type=float, default=16, help="address space of a run")
    parser.add_argument("--minutes", type=float, default=1e9, help="end this slice then")
    parser.add_argument("--peer-python", default=sys.executable)
    parser.add_argument("--folder", type=Path, default=ROOT / "results" / "speed")
    parser.add_argument("--fresh", action="store_true", help="forget the runs so far")
    parser.add_argument("--report", action="store_true", help="write results/speed.md from the runs so far")
    options = parser.parse_args()
    folder = options.folder.resolve()
    if options.fresh:
        shutil.rmtree(folder, ignore_errors=True)
    bench = Bench(folder, options.peer_python, Limits(options.threads, options.seconds, options.memory_gb))
    sizes = [int(float(size)) for size in options.dofs.split(",") if size]
    programs = [name for name in options.programs.split(",") if name]
    done = slice_of(bench, sizes, programs, options.rounds, options.minutes)
    if options.process_dofs:
        at = [options.process_dofs]
        done = slice_of(bench, at, list(PROCESSES), options.rounds, options.minutes) and done
    if not done:
        sys.stderr.write("the time of this slice is up: call again to go on\n")
    if options.report:
        from report import write_report

        write_report(bench.rows(), ROOT / "results" / "speed.md")


if __name__ == "__main__":
    main()
