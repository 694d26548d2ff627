"""What the benchmark scripts share: arguments, runs in processes of their own, campaigns, tables, reports."""

import argparse
import json
import multiprocessing
import statistics
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TypeVar

Outcome = TypeVar("Outcome")


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


def measured(script: str, mode: str, size: float | None) -> dict[str, float]:
    """Run a mode of a benchmark that takes `--worker MODE` and `--size MM`, and prints JSON."""
    worker = [sys.executable, script, "--worker", mode, *([] if size is None else ["--size", str(size)])]
    found: dict[str, float] = json.loads(subprocess.run(worker, check=True, capture_output=True).stdout)
    return found


def spread(values: Sequence[float]) -> str:
    """Return the median, and the least and the largest."""
    return f"{statistics.median(values):.2f} ({min(values):.2f} … {max(values):.2f})"


def campaign(
    outcome: Callable[[int], Outcome | None],
    seeds: Sequence[int],
    wanted: int,
    processes: int,
    patience: float | None = None,
) -> tuple[list[Outcome], list[int]]:
    """Collect so many outcomes of seeds, and the seed that takes longer than `patience`, s, which ends it."""
    found: list[Outcome] = []
    with multiprocessing.get_context("spawn").Pool(processes) as pool:
        outcomes = pool.imap(outcome, seeds)
        for seed in seeds:
            try:
                each = outcomes.next(timeout=patience)
            except multiprocessing.TimeoutError:
                return found, [seed]
            if each is not None:
                found.append(each)
                print(len(found), each, file=sys.stderr, flush=True)
            if len(found) == wanted:
                break
        pool.terminate()
    return found, []
