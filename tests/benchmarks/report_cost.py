"""Cost of a report: `fea run` and `fea run --report` in turn, and how large the report is.

    python tests/benchmarks/report_cost.py [PAIRS [KINDS]]

Prints for the peak cases, the whole cycle, and the whole cycle with pins in contact the median difference in
wall time and in processor time, the ratio of the median times, and the size of the file.
"""

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

KINDS = {"peak cases": [], "cycle": ["--cycle"], "cycle, contact": ["--cycle", "--pressure", "contact"]}
LIMITS = {"peak cases": 3.0, "cycle": 6.0, "cycle, contact": 6.0}  # MB


def timed(arguments, folder):
    """Wall and processor seconds of a run."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    command = [sys.executable, "-m", "fea", "run", *arguments, "--quiet", "--out", str(folder)]
    subprocess.run(command, check=True, env=os.environ)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main(pairs, kinds):
    """Measure the first kinds of runs."""
    with tempfile.TemporaryDirectory() as scratch:
        for kind, arguments in list(KINDS.items())[:kinds]:
            plain, reported = [], []
            for _ in range(pairs):
                plain.append(timed(arguments, Path(scratch, "plain")))
                reported.append(timed([*arguments, "--report"], Path(scratch, "report")))
            differences = list(
                zip(
                    *(
                        [after - before for before, after in zip(one, other, strict=True)]
                        for one, other in zip(plain, reported, strict=True)
                    ),
                    strict=True,
                )
            )
            wall, processor = (statistics.median(column) for column in differences)
            medians = [statistics.median(run[0] for run in runs) for runs in (plain, reported)]
            size = Path(scratch, "report", "report.html").stat().st_size / 1e6
            print(
                f"{kind}: {medians[0]:.1f} s without, {medians[1]:.1f} s with; {wall:+.2f} s of wall time "
                f"(ratio {medians[1] / medians[0]:.3f}), {processor:+.2f} s of processor time; "
                f"{size:.2f} MB of {LIMITS[kind]:g}",
                flush=True,
            )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5, int(sys.argv[2]) if len(sys.argv) > 2 else len(KINDS))
