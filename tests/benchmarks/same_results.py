"""Whether two versions of the program leave the same results.

    python tests/benchmarks/same_results.py runs OLD NEW FOLDER [CASE ...]  run the cases below, compare
    python tests/benchmarks/same_results.py compare OLD_FOLDER NEW_FOLDER   compare what is there already

OLD and NEW are commands, each one argument: the program of a virtual environment, ``old/.venv/bin/fea``, or
that of a checkout in the environment that has its libraries, with what to set before it:

    python tests/benchmarks/same_results.py runs "PYTHONPATH=../old $PWD/.venv/bin/python -m fea" \\
        "PYTHONPATH=. $PWD/.venv/bin/python -m fea" /tmp/same --limit 1e-9 --friction-limit 1e-6

Fields are compared relative to the largest value of their file: stresses to the largest von Mises stress,
displacements to the largest displacement. Nodes are matched by number where both files have their points in
the same order (separate parts share places), and by place otherwise. Names of files, keys of JSON, columns
and exit codes must be the same; sentences, checks (whose values are rounding) and timings are not compared.
The exit code is 1 where a field is off by more than its limit, or a figure by more than its digits.

What differs on purpose is stated in a table, `names.toml` beside this script or ``--table FILE``: names that
were renamed or added since the old version, arrays that are rounded otherwise, and files and keys that are
written otherwise.
"""

import argparse
import csv
import json
import math
import os
import shlex
import subprocess
import sys
import tempfile
import tomllib
from collections import defaultdict
from collections.abc import Collection, Mapping
from fnmatch import fnmatch
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
from scipy.spatial import KDTree

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from studies import DUTY, ENGINE, OPTIMISE

CASES = {
    "leon": "run leon-2001 --rpm 6000",
    "published": "run leon-2001-as-published",
    "columba": "run columba-2022",
    "molina": "run molina-2024",
    "cycle": "run leon-2001 --cycle --buckling --size 7",
    "parts": "run parts.toml --cycle",
    "first order": "run molina-2024 --element p1 --size 7",
    "half": "run leon-2001 --symmetry half --size 9 --pressure uniform-120 --cycle",
    "whole": "run leon-2001 --symmetry none --size 9",
    "speeds": "run leon-2001 --rpm 1000:9000:500 --size 8 --cycle",
    "tolerance": "run leon-2001 --size 12.1 --tolerance 5",
    "multigrid": "run leon-2001 --size 7 --solver amg",
    "bonded": "run columba-2022 --size 10 --pressure bonded --support clamped --cycle",
    "contact": "run leon-2001 --size 10 --pressure contact",
    "contact cycle": "run molina-2024 --size 9 --pressure contact --cycle --rpm 4000",
    "bolted": "run leon-2001-bolted --size 12 --cycle",
    "duty": "run duty.toml",
    "sweep": "sweep sweep.toml --workers 1",
    "optimise": "optimise optimise.toml --size 16 --evaluations 20",
}
FRICTION = {"bolted"}  # cases whose results depend on the path of friction
BUSHED = f"""
[rod]
preset = "leon-2001"
bushing_mm = 2.0
[material.bushing]
E_GPa = 110.0
nu = 0.34
density_kg_m3 = 8800.0
yield_MPa = 300.0
{ENGINE}"""
PARTS = BUSHED.replace('preset = "leon-2001"\nbushing_mm = 2.0', 'step = "parts.step"').replace(
    "material.bushing", 'material."part 2"'
)
SWEEP = """
study = "leon-2001"
sampling = "sobol"
samples = 6
set.mesh.size_mm = 12.0
vary.rod.web_thickness_mm = { from = 4.0, to = 6.0 }
"""
STUDIES = {
    "bushed": BUSHED,
    "parts": PARTS,
    "duty": DUTY + "[mesh]\nsize_mm = 10.0\n",
    "sweep": SWEEP,
    "optimise": OPTIMISE,
}
FIGURES = 2e-5  # six digits are written
NOTHING = 1e-12  # what rounding leaves of a figure that is zero
NOT_COMPARED = {"checks", "environment", "files", "left_out", "notes", "passes", "peak_memory_MiB"}
NOT_COMPARED |= {"shared_files", "timings_s", "total_s", "solved_dofs", "history_MPa", "seconds", "text"}
EXIT_CODES = "exit_codes.json"
TABLE = Path(__file__).with_name("names.toml")


class Program:
    """A command that runs a version of the program, with what it sets of the environment."""

    def __init__(self, command: str) -> None:
        words = shlex.split(command)
        named = [word for word in words if "=" in word.partition("/")[0]]
        self._environment = os.environ | {
            name: os.pathsep.join(str(Path(part).resolve()) for part in value.split(os.pathsep))
            if name.endswith("PATH")
            else value
            for name, _, value in (word.partition("=") for word in named)
        }
        program, *rest = [word for word in words if word not in named]
        found = Path(program)
        self._command = [str(found.absolute()) if found.exists() else program, *rest]

    def __call__(self, arguments: str, *more: str) -> int:
        """Return the exit code."""
        command = [*self._command, *shlex.split(arguments), *more]
        return subprocess.run(command, env=self._environment, check=False).returncode


def run(fea: Program, folder: Path, chosen: list[str]) -> None:
    """Run cases with a program."""
    codes = {}
    for name in chosen:
        flags = [] if name == "sweep" else ["--threads", "1", "--quiet"]
        flags += ["--no-screenshot"] if CASES[name].startswith("run ") else []
        codes[name] = fea(CASES[name], *flags, "--out", str(folder / name))
        print(f"{name}: exit code {codes[name]}", flush=True)
    (folder / EXIT_CODES).write_text(json.dumps(codes))


def figures(old: object, new: object, where: str, table: Mapping[str, Any]) -> list[str]:
    """Differences of two JSON values beyond `FIGURES`, but for those that the table states."""
    if isinstance(old, dict) and isinstance(new, dict):
        skipped = NOT_COMPARED | set(table["rewritten"]["keys"])
        added = {key for key in new if any(fnmatch(key, name) for name in table["added"]["key"])}
        either = sorted((old.keys() ^ new.keys()) - skipped - (added - old.keys()))
        differ = [f"{where}: {key} is in {'the old' if key in old else 'the new'} only" for key in either]
        keys = sorted((old.keys() & new.keys()) - skipped)
        return differ + [
            line for key in keys for line in figures(old[key], new[key], f"{where}/{key}", table)
        ]
    if isinstance(old, list) and isinstance(new, list):
        if len(old) != len(new):
            return [f"{where}: {len(old)} and {len(new)} entries"]
        if old and all(isinstance(value, int | float) for value in old):
            one, other = np.abs(old), np.abs(new)  # of two places that mirror each other either may be named
            return [] if np.abs(one - other).max() <= FIGURES * one.max() else [f"{where}: {old} and {new}"]
        pairs = enumerate(zip(old, new, strict=True))
        return [line for k, (a, b) in pairs for line in figures(a, b, f"{where}[{k}]", table)]
    same = old == new or (isinstance(old, str) and isinstance(new, str) and " " in old)
    if isinstance(old, float | int) and isinstance(new, float | int):
        period = table["periods"].get(where.rpartition("/")[2], math.inf)
        apart = abs(old - new) if math.isinf(period) else abs(math.remainder(old - new, period))
        same = apart <= FIGURES * max(abs(old), abs(new)) + NOTHING
    return [] if same else [f"{where}: {old} and {new}"]


def rows(old: Path, new: Path, added: Collection[str] = ()) -> list[str]:
    """Differences of two CSV files beyond `FIGURES` of each column's largest value."""
    one, other = ([*csv.reader(path.read_text().splitlines())] for path in (old, new))
    if one[0] != [name for name in other[0] if name in one[0] or name not in added]:
        return [f"columns {one[0]} and {other[0]}"]
    found = []
    for name, *values in zip(*one, strict=True):
        if name in NOT_COMPARED:
            continue
        theirs = [row[other[0].index(name)] for row in other[1:]]
        largest = max((abs(number(value)) for value in values), default=0.0)
        for a, b in zip_longest(values, theirs, fillvalue=""):
            if a != b and not abs(abs(number(a)) - abs(number(b))) <= FIGURES * largest:
                found.append(f"{old.name} {name}: {a} and {b}")
    return found


def number(text: str) -> float:
    """A cell's number; 0 for text, which has to be equal."""
    try:
        return float(text)
    except ValueError:
        return 0.0


def matched(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Number of each of the places (n, 3) among the others: its own where they are in the same order."""
    if one.shape == other.shape and np.abs(one - other).max(initial=0.0) <= 1e-9 * np.abs(one).max(
        initial=1.0
    ):
        return np.arange(len(one))
    return np.asarray(KDTree(other).query(one)[1])


def fields(old: Path, new: Path, table: Mapping[str, Any]) -> dict[str, float]:
    """Largest relative difference of each field of two VTU files; infinite where one has no such field."""
    one, other = pyvista.read(old), pyvista.read(new)
    if len(one.points) != len(other.points) or one.n_cells != other.n_cells:
        return {"places": np.inf}
    node = matched(one.points, other.points)
    cell = matched(one.cell_centers().points, other.cell_centers().points)
    stress = float(np.nanmax(one.point_data["von_mises"])) if "von_mises" in one.point_data else None
    size = float(np.abs(one.points).max())
    found = {"places": float(np.abs(one.points - other.points[node]).max()) / size}
    for kind, order in (("point_data", node), ("cell_data", cell)):
        where, arrays = kind[:-5], [getattr(grid, kind) for grid in (one, other)]
        before = {table["renamed"][where].get(name, name): name for name in arrays[0].keys()}  # noqa: SIM118
        either = before.keys() ^ set(arrays[1].keys()) - (set(table["added"][where]) - before.keys())
        found |= {f"{where} {name}": np.inf for name in either}
        for name in before.keys() & set(arrays[1].keys()):
            a, b = np.asarray(arrays[0][before[name]], float), np.asarray(arrays[1][name], float)
            found[f"{where} {name}"] = _apart(name, a, b[order], stress)
    return found


def _apart(name: str, a: np.ndarray, b: np.ndarray, stress: float | None) -> float:
    """Largest difference of two fields, relative to the largest stress or to the largest value."""
    if a.shape != b.shape or (np.isnan(a) != np.isnan(b)).any():
        return np.inf
    if not np.isfinite(a).any():
        return 0.0
    of_stress = name.startswith(("principal", "stress", "von", "mean", "amplitude"))
    largest = stress if of_stress and name != "stress_ratio" and stress else np.nanmax(np.abs(a))
    away = np.abs(a - b)
    if name.startswith("mode_"):  # the sign of a mode is free
        away = np.minimum(away, np.abs(a + b))
    return float(np.nanmax(away) / (largest or 1.0))


def compare(old: Path, new: Path, limits: tuple[float, float], table: Mapping[str, Any]) -> bool:
    """Print the differences of two folders of runs; return whether they are within the limits."""
    added = table["added"]
    worst: dict[str, tuple[float, str]] = defaultdict(lambda: (0.0, ""))
    said = []
    files = {path.relative_to(folder) for folder in (old, new) for path in folder.rglob("*")}
    for name in sorted(files):
        one, other = old / name, new / name
        if not (one.exists() and other.exists()):
            said.append(f"{name} is in {'the old' if one.exists() else 'the new'} only")
        elif name.suffix == ".json":
            said += figures(json.loads(one.read_text()), json.loads(other.read_text()), str(name), table)
        elif name.suffix == ".csv":
            said += [f"{name}: {line}" for line in rows(one, other, added["column"])]
        elif name.suffix == ".vtu" and not any(map(name.match, table["rewritten"]["files"])):
            limit = limits[name.parts[0] in FRICTION]
            found = fields(one, other, table)
            said += [
                f"{name}: {field} {away:.1e}"
                for field, away in found.items()
                if not away <= max(limit, table["limits"].get(field, 0.0))
            ]
            for field, away in found.items():
                worst[field] = max(worst[field], (away, str(name)))
    for field, (away, where) in sorted(worst.items()):
        print(f"{field:32} {away:.1e}  {where}")
    print(*said, f"{len(said)} differences", sep="\n")
    return not said


def main() -> None:
    """Compare two programs or two folders."""
    ask = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ask.add_argument("task", choices=("runs", "compare"))
    ask.add_argument("old")
    ask.add_argument("new")
    ask.add_argument("folder", nargs="?", help="where the runs are left")
    ask.add_argument("cases", nargs="*", help="all by default")
    ask.add_argument("--limit", type=float, default=1e-9, help="of fields, relative to the largest value")
    ask.add_argument("--friction-limit", type=float, default=1e-6, help="where friction remembers its path")
    ask.add_argument("--table", type=Path, default=TABLE, help="what differs on purpose")
    asked = ask.parse_intermixed_args()
    table = tomllib.loads(asked.table.read_text(encoding="utf-8"))
    limits = asked.limit, asked.friction_limit
    if asked.task == "compare":
        sys.exit(not compare(Path(asked.old), Path(asked.new), limits, table))
    place = Path(asked.folder).resolve()
    with tempfile.TemporaryDirectory() as scratch:
        for name, text in STUDIES.items():
            (Path(scratch) / f"{name}.toml").write_text(text)
        programs = {name: Program(command) for name, command in (("old", asked.old), ("new", asked.new))}
        os.chdir(scratch)
        if programs["old"]("rod bushed.toml --step parts.step --quiet"):
            sys.exit("the old program writes no STEP file")
        for name, program in programs.items():
            (place / name).mkdir(parents=True, exist_ok=True)
            run(program, place / name, asked.cases or [*CASES])
    sys.exit(not compare(place / "old", place / "new", limits, table))


if __name__ == "__main__":
    main()
