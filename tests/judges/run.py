"""Files that cross between `fea` and programs that did not write or will not read them by our rules.

    python tests/judges/run.py [JUDGE ...] [--break] [--report FILE]

Every `NAME_judge.py` of this folder judges one program. Its first line names what it needs behind ``#
requires:``: packages of Python with their versions, for which this script makes an environment of its own
in the directory for temporary files, and Debian packages (``debian:NAME``), which must be there. What
cannot be had is listed. With ``--break`` every row is tried again on a file that has one fault, and must
turn wrong. The report of all judges goes to results/crossings.md. Outside CI, as the packages are large.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
SCRATCH = Path(tempfile.gettempdir()) / "conrod-fea-judges"
FILES = SCRATCH / "files"
OUR_FILES = (sys.executable, str(HERE / "our_files.py"))
# What runs the judges of programs that bring their own Python.
OWN_PYTHON = {"debian:python3-paraview": "pvpython", "debian:freecad-python3": "/usr/bin/python3"}
ABSENT = {
    "Code_Aster, SALOME": "not in PyPI or Debian 12; their library MEDCoupling is judged",
    "Abaqus, Ansys, MSC Nastran, NX, SolidWorks, CATIA, Creo": "not free; others judge their formats",
    "gmsh, for our .vtk and .inp": "it reads VTK's legacy files in text alone, and no Abaqus decks",
    "ParaView's .vtu compressed with LZ4": "refused, with the remedy: meshio does not read them",
    "Netgen, for our binary .msh": "its reader takes text: gmsh converts the file first",
}
INTRODUCTION = """# Crossings: files between `fea` and other programs

Made by `python tests/judges/run.py --break`. Each row is one crossing: what `fea` wrote and another program
read, or what another program wrote and `fea` read. The right answer comes from the side that did not read:
the run itself, or the volume that a program measures of its own solid or mesh. A figure is right within the
bar behind ±, relative. *With a fault* is what the same row said of a file with one fault put in; a row that
does not turn wrong there proves nothing.

Faults: `turned` two vertices of every element exchanged; `middles` two mid-side nodes exchanged; `scaled` 1
% too large (a pressure, too); `lost` one element left out; `tensor` YZ and XZ exchanged, von Mises stress 1
% larger; `names` both bores exchanged; `times` another crank angle; `unit` another unit declared; `placed`
the cap 2 mm away.
"""


@dataclass
class Heard:
    """What a judge said: its version, its rows by crossing and question, and an error."""

    version: str = ""
    rows: dict[tuple[str, str], Mapping[str, Any]] = field(default_factory=dict)
    error: str = ""
    refused: Mapping[str, str] = field(default_factory=dict)  #: the error by the fault of the first file


def python_for(judge: Path) -> Path | str:
    """Return what runs a judge. Raises `OSError`: a package is not there, or cannot be had."""
    needs = judge.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# requires:").split()
    for package in (need for need in needs if need.startswith("debian:")):
        name = package.removeprefix("debian:")
        found = subprocess.run(["dpkg-query", "-W", name], capture_output=True, check=False)
        if found.returncode:
            raise OSError(f"the Debian package {name} is not installed")
        if package in OWN_PYTHON:
            return OWN_PYTHON[package]
    place = SCRATCH / judge.stem
    python, packages = place / "bin" / "python", [need for need in needs if not need.startswith("debian:")]
    if not (place / "made").exists():
        subprocess.run([sys.executable, "-m", "venv", "--clear", str(place)], check=True)
        install = [str(python), "-m", "pip", "install", "--quiet", "--no-compile", *packages]
        told = subprocess.run(install, capture_output=True, text=True, check=False)
        if told.returncode:
            raise OSError(f"pip could not install {' '.join(packages)}: {told.stderr.strip()[-120:]}")
        (place / "made").touch()
    return python


def lines_of(command: list[str], given: str | None = None) -> tuple[list[Any], str]:
    """Run a command with this checkout on its path; return its lines of JSON, and its error."""
    known = os.environ | {"PYTHONPATH": str(ROOT)}
    told = subprocess.run(command, input=given, env=known, capture_output=True, text=True, check=False)
    lines = [json.loads(line) for line in told.stdout.splitlines() if line.startswith("{")]
    return lines, told.stderr.strip()[-300:] if told.returncode else ""


def heard(judge: Path, python: Path | str, *breaking: str) -> Heard:
    """Run a judge, and let `fea` read what it wrote."""
    lines, error = lines_of([str(python), str(judge), str(FILES), *breaking])
    kinds = "version", "row", "item", "refused"
    told = {kind: [line[kind] for line in lines if kind in line] for kind in kinds}
    items = "".join(f"{json.dumps(item)}\n" for item in told["item"])
    read, failure = lines_of([*OUR_FILES, "read"], items)
    rows = {(row["crossing"], row["tried"]): row for row in [*told["row"], *read]}
    refused = {fault: f"refused ({why})" for line in told["refused"] for fault, why in line.items()}
    return Heard("".join(told["version"]), rows, error or failure, refused)


def report(all_heard: Mapping[str, tuple[Heard, Heard | None]]) -> Iterator[str]:
    """Yield the lines of the report."""
    yield f"{INTRODUCTION}\n| program | version | crossings | right | seen to fail |\n|---|---|--:|--:|--:|"
    for name, (plain, broken) in all_heard.items():
        right = sum(row["right"] for row in plain.rows.values())
        rows = plain.rows.values()
        failed = "" if broken is None else sum(spoiled_figure(row, broken) is not None for row in rows)
        yield f"| {name} | {plain.version or plain.error} | {len(plain.rows)} | {right} | {failed} |"
    yield from ("", "Not judged:", "", *(f"- {name}: {why}." for name, why in ABSENT.items()))
    for name, (plain, broken) in all_heard.items():
        yield from ("", f"## {name}", "", "| file | what was tried | figure | expected | | with a fault |")
        yield "|---|---|---|---|---|---|"
        for row in plain.rows.values():
            verdict = "right" if row["right"] else "**wrong**"
            again = "" if broken is None else spoiled_figure(row, broken) or "**as before**"
            said = f"{row['fault']}: {again}"
            cells = (row["crossing"], row["tried"], row["found"], row["expected"], verdict, said)
            yield f"| {' | '.join(str(cell).replace('|', '/') for cell in cells)} |"


def spoiled_figure(row: Mapping[str, Any], broken: Heard) -> str | None:
    """Return what a row says of a file with a fault; None where it does not turn wrong."""
    again = broken.rows.get((row["crossing"], row["tried"]))
    if again is None:
        return broken.refused.get(row["fault"])
    return None if again["right"] else again["found"]


def main() -> int:
    """Run the judges; return the exit code: 1 where a row is wrong, or does not fail where it must."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("judges", nargs="*")
    parser.add_argument("--break", action="store_true", dest="breaking", help="see every row fail")
    parser.add_argument("--report", type=Path, help="default, where all judges run: results/crossings.md")
    given = parser.parse_args()
    judges = {path.stem.removesuffix("_judge"): path for path in sorted(HERE.glob("*_judge.py"))}
    chosen, found, wrong = given.judges or [*judges], {}, 0
    _, error = lines_of([*OUR_FILES, "write", str(FILES)])
    if error:
        sys.exit(error)
    for name in chosen:
        try:
            python = python_for(judges[name])
        except OSError as missing:
            found[name] = Heard(error=str(missing)), None
            print(f"{name}: {missing}", flush=True)
            continue
        plain = heard(judges[name], python)
        broken = heard(judges[name], python, "--break") if given.breaking else None
        found[name] = plain, broken
        bad = [key for key, row in plain.rows.items() if not row["right"]]
        rows = plain.rows.items()
        unseen = [] if broken is None else [key for key, row in rows if spoiled_figure(row, broken) is None]
        wrong += len(bad) + len(unseen) + bool(plain.error)
        said = f"{len(rows)} crossings, wrong {bad}, not seen to fail {unseen if broken else ''}"
        print(f"{name} {plain.version}: {said} {plain.error}", flush=True)
    path = given.report or (None if given.judges else ROOT / "results" / "crossings.md")
    if path is not None:
        path.write_text("\n".join(report(found)) + "\n", encoding="utf-8")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
