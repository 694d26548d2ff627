"""Sweeps at full length: how two processes compare with one, and what kill -9 does to them.

python tests/benchmarks/sweep_campaign.py rate --rods 200 --size 14
python tests/benchmarks/sweep_campaign.py kill --who parent --count 20
python tests/benchmarks/sweep_campaign.py kill --who rod --count 20
python tests/benchmarks/sweep_campaign.py kill --who scheduler --count 20
python tests/benchmarks/sweep_campaign.py kill --who rod --count 20
python tests/benchmarks/sweep_campaign.py same --rods 12 --size 14
python tests/benchmarks/sweep_campaign.py scale --rods 3000
python tests/benchmarks/sweep_campaign.py many --rods 20000

`rate` computes the same rods with one worker and with two. `kill` ends the program, the scheduler of a
cluster, or the process of a rod at random moments until the sweep is done. Its rods take a tenth of
a second, and a log tells which were computed twice; the exit code counts faults.
`same` compares the tables of a local cluster and of a scheduler with two workers over TCP. `scale` tells how
many rods a second the program can give out and enter, with rods that take no time. `many` does so with 1000
simulated workers, which return what a rod has at once: tasks and results are pickled as they travel, and
Dask's scheduler and the network are not there.
"""

import argparse
import contextlib
import os
import pickle
import re
import socket
import subprocess
import sys
import tempfile
import time
from concurrent.futures import Executor, Future
from pathlib import Path

import psutil
from sweep_kills import CHEAP, kill

from fea.apps.sweep.journal import RodResult, write_tables
from fea.apps.sweep.run_sweep import journal_of, report_sweep
from fea.apps.sweep.sweep_file import load_sweep
from fea.apps.sweep.workers import Task, Workers, compute_pending

SWEEP = """study = "leon-2001"
sampling = "sobol"
samples = {rods}
seed = {seed}
{size}
[vary.rod]
web_thickness_mm = {{ from = 4.0, to = 6.0 }}
"""


def sweep(folder, rods, size=None, seed=1):
    """Write a sweep file."""
    text = "" if size is None else f"[set]\nmesh.size_mm = {size}"
    path = folder / "web.toml"
    path.write_text(SWEEP.format(rods=rods, seed=seed, size=text))
    return path


def rate(folder, rods, size):
    """Compare one worker and two."""
    path, seconds = sweep(folder, rods, size), {}
    for workers in (1, 2):
        out = folder / f"w{workers}"
        command = [sys.executable, "-m", "fea", "sweep", path, "--out", out, "--workers", f"{workers}"]
        begin = time.perf_counter()
        subprocess.run(list(map(str, command)), check=True)
        seconds[workers] = time.perf_counter() - begin
        print(f"{workers} workers: {seconds[workers]:.1f} s, {rods / seconds[workers]:.3f} rods a second")
    print(f"two against twice one: {100 * seconds[1] / (2 * seconds[2]):.1f} %")
    print("same table:", (folder / "w1/sweep.csv").read_bytes() == (folder / "w2/sweep.csv").read_bytes())


class Scheduler:
    """`dask scheduler` and two workers over TCP."""

    def __init__(self, folder, environment):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        port, log = self.address.rpartition(":")[2], (folder / "dask.log").open("a")
        path = os.pathsep.join((str(CHEAP.parent), environment.get("PYTHONPATH", "")))
        options = {"stdout": log, "stderr": log, "env": environment | {"PYTHONPATH": path}}
        module = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
        self.own = subprocess.Popen(
            [*module, "--host", "127.0.0.1", "--port", port, "--no-dashboard"], **options
        )
        module = [sys.executable, "-m", "distributed.cli.dask_worker"]
        self.workers = [
            subprocess.Popen([*module, self.address, "--nthreads", "1", "--no-dashboard"], **options)
            for _ in range(2)
        ]
        wait_for(self.address)

    def end(self):
        """End them."""
        for process in (self.own, *self.workers):
            process.terminate()
        for process in (self.own, *self.workers):
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()


def wait_for(address):
    """Wait until a port is open."""
    host, port = re.fullmatch(r"tcp://(.*):(\d+)", address).groups()
    for _ in range(600):
        with socket.socket() as trial:
            if trial.connect_ex((host, int(port))) == 0:
                return
        time.sleep(0.1)
    raise TimeoutError(address)


def same(folder, rods, size):
    """Compare two schedulers."""
    path, tables = sweep(folder, rods, size), []
    scheduler = Scheduler(folder, dict(os.environ))
    for out, more in (("local", []), ("tcp", ["--cluster", scheduler.address])):
        command = [sys.executable, "-m", "fea", "sweep", path, "--out", folder / out, *more]
        subprocess.run(list(map(str, command)), check=True)
        tables.append((folder / out / "sweep.csv").read_bytes())
    scheduler.end()
    print("same table:", tables[0] == tables[1])


def scale(folder, rods, _size):
    """How many rods a second the program itself can give out and enter: rods that take no time."""
    path = sweep(folder, rods)
    command = [sys.executable, CHEAP, path, folder / "out"]
    options = {"env": os.environ | {"CHEAP_SECONDS": "0"}, "stdout": subprocess.DEVNULL}
    begin = time.perf_counter()
    process = psutil.Popen(list(map(str, command)), **options)
    used = 0.0
    while process.poll() is None:
        with contextlib.suppress(psutil.Error):
            times = process.cpu_times()
            used = times.user + times.system
        time.sleep(0.05)
    seconds = time.perf_counter() - begin
    size = (folder / "out/sweep.sqlite").stat().st_size, (folder / "out/sweep.parquet").stat().st_size
    print(f"{rods} rods in {seconds:.1f} s; the program used {used:.1f} s")
    print(f"{1000 * used / rods:.2f} ms a rod, so that it saturates at {rods / used:.0f} rods a second")
    print(f"{size[0] / rods:.0f} bytes a rod in the journal, {size[1] / rods:.0f} in the Parquet file")


THREADS = 1000
FIGURES = {f"figure_{k}": 1.0 + k / 7 for k in range(25)} | {"factor": 1.1, "mass_kg": 0.7, "trusted": True}


class AtOnce(Executor):
    """Workers that return at once."""

    def submit(self, function, task):
        _, task = pickle.loads(pickle.dumps((function, task)))  # noqa: S301 - our own
        done = RodResult(task.job, {task.speeds[0]: FIGURES}, 0.0)
        future = Future()
        future.set_result(pickle.loads(pickle.dumps(done)))  # noqa: S301 - as above
        return future


def many(folder, rods, _size):
    """How many rods a second are given out to 1000 simulated workers and entered."""
    asked, clock = load_sweep(sweep(folder, rods)), time.process_time
    begin = clock()
    with journal_of(asked, folder / "out") as journal:
        print(f"planned: {rods / (clock() - begin):.0f} rods a second")
        begin = clock()
        common = Task(asked.base, asked.outputs)
        compute_pending(journal, Workers(AtOnce(), THREADS), common, lambda *_: None)
        print(f"given out and entered: {rods / (clock() - begin):.0f} rods a second")
        begin = clock()
        write_tables(folder / "out", journal.rows())
        print(f"table: {rods / (clock() - begin):.0f} rows a second")
        begin = clock()
        report_sweep(folder / "out" / "report.html", asked, journal)
        print(
            f"report: {clock() - begin:.1f} s, {(folder / 'out/report.html').stat().st_size / 2**20:.1f} MiB"
        )


def main():
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=("rate", "kill", "same", "scale", "many"))
    parser.add_argument("--rods", type=int, default=200)
    parser.add_argument("--size", type=float, default=14.0)
    parser.add_argument("--who", choices=("parent", "scheduler", "rod"), default="parent")
    parser.add_argument("--count", type=int, default=20)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        if asked.what == "kill":
            folder = Path(place)
            sys.exit(kill(folder, asked.who, asked.count, sweep(folder, asked.rods), Scheduler))
        else:
            jobs = {"rate": rate, "same": same, "scale": scale, "many": many}
            jobs[asked.what](Path(place), asked.rods, asked.size)


if __name__ == "__main__":
    main()
