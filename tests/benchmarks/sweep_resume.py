"""Seconds to go on with a sweep of 10 000 rows: python tests/benchmarks/sweep_resume.py [ROWS].

The journal is filled with made-up figures but for the last row. Measured are the scan up to the first rod
that would be given out, and, apart, the tables and the report.
"""

import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from fea.apps.sweep.journal import RodResult, write_tables
from fea.apps.sweep.run_sweep import journal_of, report_sweep
from fea.apps.sweep.sweep_file import load_sweep

SWEEP = """study = "leon-2001"
sampling = "sobol"
samples = {rows}
[vary.rod]
web_thickness_mm = {{ from = 4.0, to = 6.0 }}
[vary.material]
yield_MPa = {{ distribution = "normal", mean = 600.0, deviation = 30.0, from = 480.0, to = 720.0 }}
"""


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    with TemporaryDirectory() as place:
        file, folder = Path(place, "many.toml"), Path(place, "out")
        file.write_text(SWEEP.format(rows=count))
        begin = time.perf_counter()
        with journal_of(load_sweep(file), folder) as journal:
            print(f"begin: {time.perf_counter() - begin:.2f} s for {count} rows")
            jobs = journal.pending()[:-1]
            figures = {f"figure_{k}": 1.0 + k / 7 for k in range(25)} | {"trusted": True}
            rods = []
            for n, job in enumerate(jobs):
                share = n / count
                rods.append(
                    RodResult(
                        job, {6000.0: figures | {"factor": 0.8 + share, "mass_kg": 0.7 + share**2}}, 3.0
                    )
                )
            begin = time.perf_counter()
            for rod in rods[:500]:
                journal.finish([rod])
            print(f"enter: {500 / (time.perf_counter() - begin):.0f} rows a second, a transaction each")
            begin = time.perf_counter()
            journal.finish(rods[500:])
            seconds = time.perf_counter() - begin
            print(
                f"enter: {seconds:.2f} s, {(len(rods) - 500) / seconds:.0f} rows a second in one transaction"
            )
        size = (folder / "sweep.sqlite").stat().st_size
        print(f"journal: {size / count:.0f} bytes a row")
        begin = time.perf_counter()
        sweep = load_sweep(file)
        with journal_of(sweep, folder) as journal:
            left = journal.pending()
            journal.design(left[0])
            print(f"resume scan: {time.perf_counter() - begin:.2f} s, {len(left)} rod left")
            begin = time.perf_counter()
            write_tables(folder, journal.rows())
            print(f"tables: {time.perf_counter() - begin:.2f} s")
            begin = time.perf_counter()
            report_sweep(folder / "report.html", sweep, journal)
            print(f"report: {time.perf_counter() - begin:.2f} s")
            print(f"report: {(folder / 'report.html').stat().st_size / 2**20:.1f} MiB")


if __name__ == "__main__":
    main()
