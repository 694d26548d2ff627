"""Shared by every measured process: stages against the clock, memory, answers to a file.

No import beyond numpy: the peers run in an environment without this project.
"""

import json
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

THREADS = int(os.environ.get("OMP_NUM_THREADS", "2"))


class Run:
    """One measured run: `python worker CASE.npz OUT`; leaves OUT.json and OUT.npz."""

    def __init__(self) -> None:
        self.case = Path(sys.argv[1])
        self._out = sys.argv[2]
        self.arguments = sys.argv[3:]
        self.stages: dict[str, float] = {}
        self.facts: dict[str, float | str] = {}
        self._base = 0.0

    def start(self) -> None:
        """Everything is imported and the case is in memory: from here it counts."""
        self._base = resident()

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.stages[name] = self.stages.get(name, 0.0) + time.perf_counter() - start

    def finish(self, **answers: np.ndarray) -> None:
        """Leave the figures, and the answers for the comparison."""
        report = {"stages": self.stages, "base_mb": self._base, "peak_mb": peak(), **self.facts}
        Path(f"{self._out}.json").write_text(json.dumps(report), encoding="utf-8")
        np.savez(f"{self._out}.npz", **answers)


def resident() -> float:
    """Memory held now, MB."""
    return _status("VmRSS")


def peak() -> float:
    """Most memory ever held, MB."""
    return _status("VmHWM")


def _status(key: str) -> float:
    for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
        if line.startswith(f"{key}:"):
            return int(line.split()[1]) / 1024
    return float("nan")


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Von Mises stress of tensors (…, 3, 3)."""
    deviator = stress - np.trace(stress, axis1=-2, axis2=-1)[..., None, None] / 3 * np.eye(3)
    return np.sqrt(1.5 * (deviator**2).sum(axis=(-2, -1)))
