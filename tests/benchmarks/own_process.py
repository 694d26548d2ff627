"""Runs of a benchmark in processes of their own, which print what they measured as JSON."""

import json
import subprocess
import sys


def measured(script: str, mode: str, size: float | None) -> dict[str, float]:
    """Run a mode of a benchmark that takes `--worker MODE` and `--size MM`."""
    command = [sys.executable, script, "--worker", mode, *([] if size is None else ["--size", str(size)])]
    found: dict[str, float] = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    return found


def spread(values: list[float], median: float) -> str:
    """Return the median, and the least and the largest."""
    return f"{median:.2f} ({min(values):.2f} … {max(values):.2f})"
