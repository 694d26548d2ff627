"""Shared by the benchmark scripts: arguments, runs in processes of their own, campaigns, tables, reports."""

import argparse
import json
import math
import multiprocessing
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import local
from typing import Any

Row = dict[str, Any]


def reporting(description: str | None) -> argparse.ArgumentParser:
    """Return a parser of arguments with `--report FILE.md`."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--report", type=Path)
    return parser


def command() -> str:
    """The command that runs the script, as a report quotes it."""
    return " ".join([f"python tests/benchmarks/{Path(sys.argv[0]).name}", *sys.argv[1:]])


def publish(text: str, report: Path | None) -> None:
    """Print a report, and write it where that was asked for."""
    print(text)
    if report:
        report.write_text(text, encoding="utf-8")


def table(header: Sequence[str], rows: Iterable[Sequence[str]] = ()) -> list[str]:
    """Return the lines of a Markdown table; columns whose heading ends with a colon are aligned right."""
    rules = ["---:" if name.endswith(":") else "---" for name in header]
    names = [name.removesuffix(":") for name in header]
    return ["| " + " | ".join(line) + " |" for line in (names, rules, *rows)]


def kept_in(path: Path | None) -> dict[str, Any]:
    """Return the outcomes, by their names, that a JSON file keeps; none without a file."""
    kept: dict[str, Any] = json.loads(path.read_text()) if path and path.exists() else {}
    return kept


def keep(path: Path | None, kept: Mapping[str, object]) -> None:
    """Write outcomes to a JSON file, if there is to be one, whole or not at all."""
    if path:
        beside = path.with_suffix(".part")
        beside.write_text(json.dumps(kept))
        beside.replace(path)


def measured(script: str, mode: str, size: float | None) -> dict[str, float]:
    """Run a mode of a benchmark that takes `--worker MODE` and `--size MM`, and prints JSON."""
    worker = [sys.executable, script, "--worker", mode, *([] if size is None else ["--size", str(size)])]
    found: dict[str, float] = json.loads(subprocess.run(worker, check=True, capture_output=True).stdout)
    return found


def spread(values: Sequence[float]) -> str:
    """Return the median, and the least and the largest."""
    return f"{statistics.median(values):.2f} ({min(values):.2f} … {max(values):.2f})"


class LostError(Exception):
    """A process gave no result: it died, or took too long."""


class _OfThread(local):
    """The process of a thread, and the pipe to it."""

    process: Any = None
    pipe: Any = None


_own, _started = _OfThread(), list[Any]()


def in_process(job: Callable[[Any], Any], argument: object, wall: float, cpu: float = math.inf) -> Any:
    """Return the result of a job from a process of this thread, which serves it until it is lost.

    Raises `LostError`: the process died, or the job took more than `wall` seconds or `cpu` seconds of
    processor time (a busy machine is no reason to call a job slow).
    """
    if _own.process is None:
        _own.pipe, theirs = multiprocessing.Pipe()
        context = multiprocessing.get_context("spawn")
        _own.process = context.Process(target=_serve, args=(theirs, job), daemon=True)
        _own.process.start()
        _started.append(_own.process)
        theirs.close()
    try:
        _own.pipe.send(argument)
        end, limit = time.monotonic() + wall, _processor_time(_own.process.pid) + cpu
        while time.monotonic() < end and _processor_time(_own.process.pid) < limit:
            if _own.pipe.poll(1.0):
                return _own.pipe.recv()
        reason = f"no result within {wall:g} s"
        _own.process.kill()
    except (EOFError, OSError):
        _own.process.join()
        reason = f"the process died with code {_own.process.exitcode}"
    _own.process = None
    raise LostError(reason)


def _processor_time(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _serve(pipe: Any, job: Callable[[Any], Any]) -> None:
    while True:
        pipe.send(job(pipe.recv()))


def campaign(
    description: str | None,
    outcome: Callable[[int], Row | None],
    report_text: Callable[[list[Row]], str],
    *,
    count: int,
    first: int = 0,
    what: str = "rods",
    patience: float = 900.0,
) -> None:
    """Compute the outcomes of seeds from `first` on until there are `count`, and publish the report.

    An outcome is None where nothing was drawn. A seed that is lost, or takes longer than `patience`, s,
    becomes a row with `lost`, the reason. With `--resume`, each row is written as it comes, and a further run
    resumes after the last one.
    """
    parser = reporting(description)
    parser.add_argument(f"--{what}", dest="count", type=int, default=count)
    parser.add_argument("--first", type=int, default=first)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument(
        "--resume", type=Path, help="JSON lines of the rows; those of it are not computed again"
    )
    asked = parser.parse_args()
    kept = asked.resume.read_text().splitlines() if asked.resume and asked.resume.exists() else []
    rows: list[Row] = [json.loads(line) for line in kept]
    begin = max((row["seed"] + 1 for row in rows), default=asked.first)

    def row_of(seed: int) -> Row | None:
        try:
            found: Row | None = in_process(outcome, seed, patience)
        except LostError as error:
            found = {"seed": seed, "lost": str(error)}
        return found

    with ThreadPoolExecutor(asked.processes) as threads:
        coming = threads.map(row_of, range(begin, begin + 100 * (asked.count - len(rows))))
        while len(rows) < asked.count and (row := next(filter(None, coming), None)):
            rows.append(row)
            print(len(rows), row, file=sys.stderr, flush=True)
            if asked.resume:
                with asked.resume.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")
        threads.shutdown(wait=False, cancel_futures=True)
        for process in _started:
            process.kill()
    publish(report_text(rows), asked.report)
