"""Rods that other people drew, and the shipped studies: seconds to the draft and to the verdict, nodes, bar.

    python tests/benchmarks/cad_rods.py --cad FOLDER [--before CHECKOUT] --report results/cad-rods.md

Each is a default `fea run`, in this checkout and in another one in turn, where that is given. FOLDER holds
the files by the names in `CAD_RODS` of `first_answers.py` and below; those that are not there are left out.
Studies in FOLDER (`*.toml`), of any other rods, are run too.
Seconds of wall time depend on what else the machine does: those of the processors stand beside them.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from first_answers import CAD_RODS, CadRod, cad_study
from scripts import command, reporting

MORE_RODS = (
    CadRod(
        "emefff.step",
        "emefff/Dynamics-Of-A-Monocylinder-Engine-In-Salome-Meca@42a788f: Engine_assembly_V4.step",
        "sd195",
    ),
    CadRod(
        "lucaschi2026.step",
        "lucaschi2026-code/Pickle-Ball-Launcher@976c0f3: CAD/connecting_rod.step",
        "suzuki-g10",
    ),
)
SHIPPED = ("leon-2001", "columba-2022", "molina-2024", "leon-2001-bolted")
_TOLD = (
    "Seconds are of wall time and, in brackets, of the processors; nodes are those of each pass; the factor "
    "is the smallest of the run, with its error bar."
)
_TICK = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Outcome:
    """One run: wall and processor seconds to the draft and to the end, and what it says."""

    draft: tuple[float, float] | None
    end: tuple[float, float]
    nodes: tuple[int, ...] = ()
    factor: float = float("nan")
    bar: float = float("nan")
    said: str = ""

    def cells(self) -> str:
        """Cells of the table: draft, end, nodes of the passes, smallest factor and its bar."""
        draft = "—" if self.draft is None else f"{self.draft[0]:.0f} ({self.draft[1]:.0f})"
        if not self.nodes:
            return f"{draft} | {self.end[0]:.0f} ({self.end[1]:.0f}) | | {self.said}"
        nodes = ", ".join(f"{count / 1000:.0f}k" for count in self.nodes)
        end = f"{self.end[0]:.0f} ({self.end[1]:.0f})"
        return f"{draft} | {end} | {nodes} | {self.factor:.2f} ± {self.bar:.1f} %"


def processor_seconds(pid: int) -> float:
    """Processor time of a process and of those it started, s."""
    total, waiting = 0.0, [pid]
    while waiting:
        one = waiting.pop()
        try:
            fields = Path(f"/proc/{one}/stat").read_text().rpartition(")")[2].split()
            waiting += map(int, Path(f"/proc/{one}/task/{one}/children").read_text().split())
        except OSError:  # it has ended
            continue
        total += sum(map(int, fields[11:15])) / _TICK
    return total


def ran(checkout: Path, study: str, seconds: float) -> Outcome:
    """Run a study by default, at most so long."""
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-P", "-m", "fea", "run", study, "--out", f"{folder}/run"]
        start, draft = time.monotonic(), None
        process = subprocess.Popen(
            ["timeout", f"{seconds:g}", *command],
            cwd=folder,
            env=os.environ | {"PYTHONPATH": str(checkout)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        last = ""
        for line in process.stderr or ():
            last = line.strip()
            if "draft:" in line:
                draft = time.monotonic() - start, processor_seconds(process.pid)
        before = os.times()
        process.wait()
        after = os.times()
        spent = after.children_user + after.children_system - before.children_user - before.children_system
        end = time.monotonic() - start, spent
        try:
            found = json.loads(Path(folder, "run", "summary.json").read_text())
        except OSError:
            why = f"not done in {seconds:.0f} s" if process.returncode == 124 else last.removeprefix("fea: ")
            return Outcome(draft, end, said=why)
    nodes = tuple(one["nodes"] for one in found.get("passes") or [found["model"]])
    survival = found["survival"]
    bar = 100 * (survival["safety_factor"] / survival["assured_safety_factor"] - 1)
    return Outcome(draft, end, nodes, survival["safety_factor"], bar)


def studies(folder: Path, written: Path) -> Iterator[tuple[str, str]]:
    """Name of each run with its study, which is `written` for a rod from a file."""
    for rod in (*CAD_RODS, *MORE_RODS):
        if (folder / rod.file).exists():
            path = written / f"{Path(rod.file).stem}.toml"
            path.write_text(cad_study(rod, folder))
            yield path.stem, str(path)
    yield from ((path.stem, str(path.resolve())) for path in sorted(folder.glob("*.toml")))
    yield from ((name, name) for name in SHIPPED)


def main() -> None:
    """Run everything and write the table as far as it has come after each study."""
    parser = reporting(__doc__)
    parser.add_argument("--cad", type=Path, default=Path("cad"))
    parser.add_argument("--before", type=Path, help="another checkout, which runs each study as well")
    parser.add_argument("--only", nargs="+", help="names of studies")
    parser.add_argument("--seconds", type=float, default=600.0, help="wall time after which a run is ended")
    arguments = parser.parse_args()
    here = Path(__file__).parents[2]
    checkouts = [*([arguments.before.resolve()] if arguments.before else []), here]
    kinds = [*(["before"] if arguments.before else []), "after"]
    heads = [f"{kind}: {head}" for kind in kinds for head in ("draft s", "end s", "nodes", "factor ± bar")]
    lines = [
        "# What a default run costs on rods that other people drew",
        "",
        f"Made by `{command()}`. {_TOLD}",
        "",
    ]
    lines += [f"| rod | {' | '.join(heads)} |", f"|{' --- |' * (len(heads) + 1)}"]
    with TemporaryDirectory() as written:
        for name, study in studies(arguments.cad, Path(written)):
            if arguments.only and name not in arguments.only:
                continue
            cells = [ran(checkout, study, arguments.seconds).cells() for checkout in checkouts]
            lines.append(f"| {name} | {' | '.join(cells)} |")
            print(lines[-1], flush=True)
            if arguments.report:
                arguments.report.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
