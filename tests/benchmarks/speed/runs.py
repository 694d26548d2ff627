"""The measured runs, kept line by line so that a slice can end anywhere and the next one resumes."""

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from measure import Measured, measured
from programs import HERE, PROCESSES, PROGRAMS, REFERENCES, Place

Row = dict[str, Any]


@dataclass(frozen=True)
class Limits:
    """How far a run may go.

    Attributes
    ----------
    threads
        Of every program.
    seconds, memory_gb
        Of one run.
    """

    threads: int
    seconds: float
    memory_gb: float


class Bench:
    """A folder with cases, references and the runs so far.

    Parameters
    ----------
    folder
        Where everything is kept.
    peer_python
        The interpreter that has the peers.
    limits
        Of every run.
    """

    def __init__(self, folder: Path, peer_python: str, limits: Limits) -> None:
        self.folder, self._peer_python, self._limits = folder, peer_python, limits
        folder.mkdir(parents=True, exist_ok=True)
        self._log = folder / "runs.jsonl"

    def rows(self) -> list[Row]:
        """Every run so far."""
        if not self._log.exists():
            return []
        return [json.loads(line) for line in self._log.read_text(encoding="utf-8").splitlines()]

    def keep(self, row: Row) -> None:
        with self._log.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")

    def case(self, dofs: int) -> Path:
        """The case of a size; made when it is missing."""
        path = self.folder / f"case-{dofs}.npz"
        if not path.exists():
            script = (
                f"import sys; sys.path.insert(0, {str(HERE)!r}); from pathlib import Path; "
                f"from case import make_case; make_case(Path({str(path)!r}), {dofs})"
            )
            subprocess.run([sys.executable, "-c", script], check=True)
        return path

    def reference(self, dofs: int, *, straight: bool) -> Path | None:
        """The reference answer of a size; None where we cannot solve the whole rod."""
        name = f"reference-{dofs}{'-straight' if straight else ''}"
        found = self.folder / f"{name}.npz"
        if not found.exists():
            place = Place(self.case(dofs), self._scratch("reference"), self._peer_python)
            if self._measured(REFERENCES[straight](place), place.folder).status != "done":
                return None
            place.out.with_suffix(".npz").rename(found)
        return found

    def measure(self, dofs: int, key: str, number: int) -> Row:
        """Run one program once and keep what it took; the first run is also compared with the reference."""
        program = (PROGRAMS | PROCESSES)[key]
        place = Place(self.case(dofs), self._scratch(), self._peer_python)
        taken = self._measured(program.command(place), place.folder)
        row: Row = {"dofs": dofs, "program": key, "round": number, **taken.as_dict()}
        row["load"] = os.getloadavg()[0]
        row["case"] = json.loads(place.case.with_suffix(".json").read_text(encoding="utf-8"))
        report = place.folder / "out.json"
        if report.exists():
            row = json.loads(report.read_text(encoding="utf-8")) | row
        row["seconds"] = taken.wall if program.whole_process else sum(row.get("stages", {}).values())
        if taken.status == "done" and number == 0 and program.compared:
            row["agreement"] = self._agreement(dofs, key, place.folder / program.answer)
        self.keep(row)
        return row

    def _agreement(self, dofs: int, key: str, answer: Path) -> dict[str, float]:
        """Compare with our whole rod: its own answer, or for the peers one with the stress they form."""
        whole = self.folder / f"whole-{dofs}.npz"
        if key == "whole":
            shutil.copy(answer, whole)
            return {}
        own = whole if whole.exists() else None
        straight = PROGRAMS[key].straight
        reference = own if key in {"quarter", "multigrid"} else self.reference(dofs, straight=straight)
        if reference is None:
            return {}
        command = [sys.executable, HERE / "agreement.py", reference, answer]
        said = subprocess.run(command, check=True, capture_output=True, text=True)
        found: dict[str, float] = json.loads(said.stdout)
        return found

    def _measured(self, command: Iterable[str | Path], folder: Path) -> Measured:
        limits = self._limits
        return measured(list(command), folder, limits.threads, limits.seconds, limits.memory_gb)

    def _scratch(self, name: str = "run") -> Path:
        """An empty folder for one run."""
        folder = self.folder / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        return folder


def most_rounds(first: float) -> int:
    """Fewer rounds of what takes long: by the seconds of its first run."""
    return 5 if first < 20 else 3 if first < 100 else 1


def pending(
    bench: Bench, sizes: Iterable[int], programs: Iterable[str], rounds: int
) -> list[tuple[int, str, int]]:
    """The runs still to be made: size by size, round by round, every program in each round in turn.

    What did not end well is not tried again, nor at a larger size.
    """
    rows = bench.rows()
    made = {(row["dofs"], row["program"], row["round"]) for row in rows}
    first = {(row["dofs"], row["program"]): row["wall"] for row in rows if row["round"] == 0}
    failed: dict[str, int] = {}
    for row in rows:
        if row["status"] != "done":
            failed[row["program"]] = min(row["dofs"], failed.get(row["program"], row["dofs"]))
    return [
        (dofs, key, number)
        for dofs in sorted(sizes)
        for number in range(rounds)
        for key in programs
        if (dofs, key, number) not in made
        and number < most_rounds(first.get((dofs, key), 0.0))
        and dofs < failed.get(key, sys.maxsize)
    ]


def slice_of(bench: Bench, sizes: list[int], programs: list[str], rounds: int, minutes: float) -> bool:
    """Make runs until all are made or the time is up; return whether all are made."""
    end = time.monotonic() + 60 * minutes
    while todo := pending(bench, sizes, programs, rounds):
        if time.monotonic() > end:
            return False
        dofs, key, number = todo[0]
        row = bench.measure(dofs, key, number)
        sys.stderr.write(
            f"{dofs:>8} {key:<9} run {number + 1}: {row['status']}, {row['seconds']:.2f} s, "
            f"{row['peak_mb']:.0f} MB {row.get('agreement', '')} {row['message'][-300:]}\n"
        )
    return True
