"""Whether two versions of the program leave the same results, nodes matched by place.

    python tests/benchmarks/same_results.py runs OLD_FEA NEW_FEA FOLDER    run the cases below, compare
    python tests/benchmarks/same_results.py compare OLD_FOLDER NEW_FOLDER  compare what is there already

OLD_FEA and NEW_FEA are the programs of two virtual environments. Fields are compared relative to the largest
of their file: stresses to the largest von Mises stress, displacements to the largest displacement. Text,
checks (whose values are rounding) and timings are not compared.
"""

import csv
import json
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from itertools import zip_longest
from pathlib import Path

import numpy as np
import pyvista
from scipy.spatial import KDTree

CASES = {
    "leon": ["leon-2001", "--rpm", "6000"],
    "published": ["leon-2001-as-published"],
    "columba": ["columba-2022"],
    "molina": ["molina-2024"],
    "cycle": ["leon-2001", "--cycle", "--buckling", "--size", "7"],
    "parts": ["parts.toml", "--cycle"],
    "first order": ["molina-2024", "--element", "p1", "--size", "7"],
    "half": ["leon-2001", "--symmetry", "half", "--size", "9", "--pressure", "uniform-120", "--cycle"],
    "whole": ["leon-2001", "--symmetry", "none", "--size", "9"],
    "sweep": ["leon-2001", "--rpm", "1000:9000:500", "--size", "8", "--cycle"],
    "tolerance": ["leon-2001", "--size", "12.1", "--tolerance", "5"],
    "multigrid": ["leon-2001", "--size", "7", "--solver", "amg"],
}
BUSHED = """
[rod]
preset = "leon-2001"
bushing_mm = 2.0
[material.bushing]
E_GPa = 110.0
nu = 0.34
density_kg_m3 = 8800.0
yield_MPa = 300.0
[engine]
stroke_mm = 94.0
bore_mm = 76.0
piston_mass_kg = 1.3345
gas = "leon-2001"
"""
PARTS = BUSHED.replace('preset = "leon-2001"\nbushing_mm = 2.0', 'step = "parts.step"').replace(
    "material.bushing", 'material."part 2"'
)
FIGURES = 2e-5  # six digits are written
NOT_COMPARED = {"checks", "environment", "files", "left_out", "notes", "passes", "peak_memory_MiB"}
NOT_COMPARED |= {"shared_files", "timings_s", "total_s", "solved_dofs", "assembly", "history_MPa"}


def run(fea: str, folder: Path) -> None:
    """Run every case with a program."""
    for name, (study, *flags) in CASES.items():
        out = str(folder / name)
        done = subprocess.run(
            [fea, "run", study, *flags, "--quiet", "--threads", "1", "--out", out], check=False
        )
        print(f"{name}: exit code {done.returncode}", flush=True)


def figures(old: object, new: object, where: str) -> list[str]:
    """Differences of two JSON values beyond `FIGURES`."""
    if isinstance(old, dict) and isinstance(new, dict):
        keys = old.keys() - NOT_COMPARED
        return [line for key in sorted(keys) for line in figures(old[key], new.get(key), f"{where}/{key}")]
    if isinstance(old, list) and isinstance(new, list):
        if len(old) != len(new):
            return [f"{where}: {len(old)} and {len(new)} entries"]
        if old and all(isinstance(value, int | float) for value in old):
            one, other = np.abs(old), np.abs(new)  # of two places that mirror each other either may be named
            return [] if np.abs(one - other).max() <= FIGURES * one.max() else [f"{where}: {old} and {new}"]
        pairs = enumerate(zip(old, new, strict=True))
        return [line for k, (a, b) in pairs for line in figures(a, b, f"{where}[{k}]")]
    same = old == new
    if isinstance(old, float | int) and isinstance(new, float | int):
        same = abs(old - new) <= FIGURES * max(abs(old), abs(new))
    return [] if same else [f"{where}: {old} and {new}"]


def rows(old: Path, new: Path) -> list[str]:
    """Differences of two CSV files beyond `FIGURES` of each column's largest value."""
    one, other = ([*csv.reader(path.read_text().splitlines())] for path in (old, new))
    found = []
    for name, *values in zip(*one, strict=True):
        theirs = [row[one[0].index(name)] for row in other[1:]]
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


def fields(old: Path, new: Path) -> dict[str, float]:
    """Largest relative difference of each field of two VTU files."""
    one, other = pyvista.read(old), pyvista.read(new)
    node, cell = (
        KDTree(b).query(a)[1]
        for a, b in ((one.points, other.points), (one.cell_centers().points, other.cell_centers().points))
    )
    stress = float(np.nanmax(one.point_data["von_mises"])) if "von_mises" in one.point_data else None
    found = {"places": float(np.abs(one.points - other.points[node]).max())}
    for kind, order in (("point_data", node), ("cell_data", cell)):
        for name in getattr(one, kind).keys():  # noqa: SIM118 - VTK's attributes are no mapping
            a, b = (np.asarray(getattr(grid, kind)[name], float) for grid in (one, other))
            of_stress = name.startswith(("principal", "stress", "von", "mean", "amplitude"))
            largest = stress if of_stress and name != "stress_ratio" and stress else np.nanmax(np.abs(a))
            away = np.abs(a - b[order])
            if name.startswith("mode_"):  # the sign of a mode is free
                away = np.minimum(away, np.abs(a + b[order]))
            found[f"{kind[:-5]} {name}"] = float(np.nanmax(away) / largest)
    return found


def compare(old: Path, new: Path) -> int:
    """Print the differences of two folders of runs; return how many figures differ."""
    worst: dict[str, tuple[float, str]] = defaultdict(lambda: (0.0, ""))
    said = []
    for path in sorted(old.rglob("*")):
        other, name = new / path.relative_to(old), str(path.relative_to(old))
        if path.is_dir() or path.suffix in {".png", ".toml"}:
            continue
        if not other.exists():
            said.append(f"{name} is missing")
        elif path.suffix == ".json":
            said += figures(json.loads(path.read_text()), json.loads(other.read_text()), name)
        elif path.suffix == ".csv":
            said += [f"{name}: {line}" for line in rows(path, other)]
        elif path.suffix == ".vtu":
            for field, away in fields(path, other).items():
                worst[field] = max(worst[field], (away, name))
    for field, (away, name) in sorted(worst.items()):
        print(f"{field:32} {away:.1e}  {name}")
    print(*said, f"{len(said)} figures differ", sep="\n")
    return len(said)


def main() -> None:
    """Compare two programs or two folders."""
    task, *arguments = sys.argv[1:]
    if task == "compare":
        sys.exit(compare(*map(Path, arguments)) > 0)
    old, new, folder = arguments
    place = Path(folder).resolve()
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / "bushed.toml").write_text(BUSHED)
        (Path(scratch) / "parts.toml").write_text(PARTS)
        command = [str(Path(old).resolve()), "rod", "bushed.toml", "--step", "parts.step", "--quiet"]
        subprocess.run(command, cwd=scratch, check=True)
        programs = [(str(Path(fea).absolute()), place / name) for fea, name in ((old, "old"), (new, "new"))]
        os.chdir(scratch)
        for program, target in programs:
            run(program, target)
    sys.exit(compare(place / "old", place / "new") > 0)


if __name__ == "__main__":
    main()
