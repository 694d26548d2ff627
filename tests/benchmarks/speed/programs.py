"""The programs that are compared, and how each is called on a case."""

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Place:
    """Where a run happens.

    Attributes
    ----------
    case
        The case's ``.npz``; its ``.inp`` lies beside it.
    folder
        The run's own, empty.
    peer_python
        The interpreter that has the peers.
    """

    case: Path
    folder: Path
    peer_python: str

    @property
    def out(self) -> Path:
        """Start of the names of what the run leaves."""
        return self.folder / "out"


@dataclass(frozen=True)
class Program:
    """One row of the comparison.

    Attributes
    ----------
    name
        As the report calls it.
    command
        What is run.
    answer
        The file with its answer, within the run's folder.
    straight
        Whether it solves the mesh with straight edges.
    whole_process
        Whether its time is that of the whole process, reading and writing included; otherwise the stages
        it reports add up to it, imports and the reading of the case excluded.
    compared
        Whether it has an answer to be compared.
    """

    name: str
    command: Callable[[Place], list[str | Path]]
    answer: str = "out.npz"
    straight: bool = False
    whole_process: bool = False
    compared: bool = True


def _ours(what: str) -> Callable[[Place], list[str | Path]]:
    return lambda place: [sys.executable, HERE / "ours.py", place.case, place.out, *what.split()]


def _ours_script(script: str) -> Callable[[Place], list[str | Path]]:
    return lambda place: [sys.executable, HERE / script, place.case, place.out]


def _peer(script: str) -> Callable[[Place], list[str | Path]]:
    return lambda place: [place.peer_python, HERE / script, place.case, place.out]


def _calculix(place: Place) -> list[str | Path]:
    deck = place.folder / "job.inp"
    deck.symlink_to(place.case.with_suffix(".inp"))
    return ["ccx", "-i", "job"]


def _run(place: Place) -> list[str | Path]:
    size = json.loads(place.case.with_suffix(".json").read_text(encoding="utf-8"))["size_mm"]
    flags = ["--rpm", "6000", "--size", f"{size:g}", "--out", place.folder / "run", "--quiet"]
    return [sys.executable, HERE / "imports.py", "run", place.folder.parent / "imports.txt", *flags]


def _imports(place: Place) -> list[str | Path]:
    return [sys.executable, HERE / "imports.py", "floor", place.folder.parent / "imports.txt"]


PROGRAMS = {
    "whole": Program("fea, whole rod", _ours("whole")),
    "quarter": Program("fea, mirror planes", _ours("quarter")),
    "multigrid": Program("fea, whole rod, multigrid", _ours("multigrid")),
    "ngsolve": Program("NGSolve", _peer("peer_ngsolve.py")),
    "calculix": Program("CalculiX", _calculix, "job.frd", whole_process=True),
    "sfepy": Program("SfePy", _peer("peer_sfepy.py"), straight=True),
    "skfem": Program("scikit-fem", _ours_script("peer_skfem.py"), compared=False),
    "pardiso": Program("Pardiso's phases", _ours_script("kernels.py"), compared=False),
}
# At one size, that of the thesis's model.
PROCESSES = {
    "run": Program("fea run --rpm 6000", _run, whole_process=True, compared=False),
    "imports": Program("imports alone", _imports, whole_process=True, compared=False),
}
REFERENCES = {False: _ours("reference"), True: _ours("reference straight")}
