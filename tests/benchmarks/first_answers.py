"""What `fea run --cycle` says first of other people's rods and of the library's engines, without more flags.

    python tests/benchmarks/first_answers.py --cad FOLDER --report results/first-answers.md

The CAD files are not ours to pass on: FOLDER holds them by the names in `CAD_RODS`, from where it says. A
file that is not there is left out. Other flags, as `--size 14` for a trial, go to `fea run`.
"""

import json
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from scripts import publish, reporting

from fea.analysis.engine_study import engine_study
from fea.study.engine_library import engine_names, engine_preset


class CadRod(NamedTuple):
    """A rod that somebody published, by its name in the folder."""

    file: str
    source: str  #: repository, commit and path on GitHub; none of them states a licence
    engine: str  #: of the library, whose rod is about as long
    capless: bool = False  #: whether the file lacks the cap


CAD_RODS = (
    CadRod("R-r632.step", "R-r632/Buckling-Of-A-Connecting-Rod@93629a0: connecting rod.stp", "sd195"),
    CadRod("EngiAditya.igs", "EngiAditya/Single-Cylinder-Engine@8a0ba5c: single cylinder.IGS", "suzuki-g10"),
    CadRod("Aqib12664.step", "Aqib12664/4-Stroke-Engine-Solidworks@865a405: EngineUNiversal.STEP", "sd195"),
    CadRod(
        "MohammadHaris13.step",
        "MohammadHaris13/Multiphysics-Structural-and-Thermal-FEA-of-a-Single-Cylinder-Engine-Crank-Assembly"
        "@f290be5: Assembly_SP_SW.STEP",
        "sd195",
    ),
    CadRod(
        "AAYUS2004.igs",
        "AAYUS2004/connecting-rod-static-structural-validation@bd66d88: connecting rod.IGS",
        "sd195",
        capless=True,
    ),
    CadRod(
        "KylerLimata.step",
        "KylerLimata/mme540-connecting-rod-project@53d0878: Connecting Rod.step",
        "sd195",
        capless=True,
    ),
)
NUMBER = re.compile(r"(?<![\w.-])-?\d+(?:\.\d+)?(?![\w]|\.\d)")
HEAD = (
    "rod",
    "speed rpm",
    "mass g",
    "yielding",
    "by",
    "fatigue",
    "on",
    "at x, y, z mm",
    "mean ± amplitude MPa",
    "limit MPa",
    "widest bar %",
    "assumptions",
    "s",
)


def cad_study(rod: CadRod, folder: Path) -> str:
    """A study with nothing but what a newcomer has: the file, an engine and its redline."""
    cap = '\ncap = "assumed"' if rod.capless else ""
    return f"""[rod]
cad = "{(folder / rod.file).resolve()}"{cap}
[material]
preset = "forged-steel-2005"
[engine]
preset = "{rod.engine}"
[speed]
rpm = {engine_preset(rod.engine).redline_rpm}
"""


def answered(name: str, text: str, flags: list[str]) -> tuple[str, dict[str, Any] | None]:
    """Run a study as a user does; return its line of the table, and its summary."""
    with TemporaryDirectory() as folder:
        (Path(folder) / f"{name}.toml").write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "fea", "run", f"{name}.toml", "--cycle", "--out", "o", *flags]
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        print(f"{name}: exit {run.returncode}\n{run.stdout}{run.stderr}", file=sys.stderr, flush=True)
        written = Path(folder) / "o" / "summary.json"
        if not written.exists():
            said = (run.stderr.strip().splitlines() or ["no result"])[-1]
            return f"| {name} | {said} |" + " |" * (len(HEAD) - 2), None
        summary = json.loads(written.read_text(encoding="utf-8"))
    return row(name, summary), summary


def row(name: str, summary: dict[str, Any]) -> str:
    """A line of the table."""
    cases, envelope = summary["results"], summary["envelope"]
    fatigue, region = envelope["fatigue"], "inside"
    worst = min(cases, key=lambda case: cases[case]["min_safety_factor"])
    cells = (
        name,
        f"{summary['rpm']:.0f}",
        f"{1000 * summary['rod']['mass_kg']:.0f}",
        f"{envelope['min_safety_factor']:.2f}",
        worst,
        f"{fatigue['fatigue_safety_factor']:.2f}",
        fatigue.get("surface_region", region),
        ", ".join(f"{value:.0f}" for value in map(abs, fatigue["at_mm"])),
        f"{fatigue['mean_MPa']:.0f} ± {fatigue['amplitude_MPa']:.0f}",
        f"{fatigue['endurance_MPa']:.0f}",
        f"{max(case['error_percent'] for case in cases.values()):.1f}",
        str(sum("assumed" in note for note in summary["notes"])),
        f"{summary['total_s']:.0f}",
    )
    return "| " + " | ".join(cells) + " |"


def table(studies: dict[str, str], flags: list[str]) -> tuple[list[str], dict[str, dict[str, Any]]]:
    """The lines of a table, and the summaries of the rods that could be solved."""
    lines, found = ["| " + " | ".join(HEAD) + " |", "| --- " * len(HEAD) + "|"], {}
    for name, text in studies.items():
        line, summary = answered(name, text, flags)
        lines.append(line)
        if summary is not None:
            found[name] = summary
    return lines, found


def assumed(summaries: dict[str, dict[str, Any]]) -> list[str]:
    """The notes on the rods: those that differ only in numbers are one line, with their ranges."""
    texts: dict[str, list[str]] = {}
    rods: dict[str, list[str]] = {}
    for name, summary in summaries.items():
        for note in summary["notes"]:
            text = re.sub(r"engine [\w.-]+: assumed", "engine: assumed", note)
            kind = NUMBER.sub("#", text)
            texts.setdefault(kind, []).append(text)
            rods.setdefault(kind, []).append(name)
    lines = []
    for kind, notes in texts.items():
        ranges = [
            f"{least} to {most}" if least != most else least
            for least, most in (
                (min(values, key=float), max(values, key=float))
                for values in zip(*(NUMBER.findall(note) for note in notes), strict=True)
            )
        ]
        names = dict.fromkeys(rods[kind])
        who = "all" if len(names) == len(summaries) else ", ".join(names)
        lines.append(f"- {who}: {kind.replace('#', '{}').format(*ranges)}")
    return lines


def main() -> None:
    """Ask of every rod."""
    parser = reporting(__doc__)
    parser.add_argument("--cad", type=Path)
    options, flags = parser.parse_known_args()
    engines, of_engines = table({name: engine_study(name) for name in engine_names()}, flags)
    there = [rod for rod in CAD_RODS if options.cad and (options.cad / rod.file).exists()]
    cad, of_cad = table({Path(rod.file).stem: cad_study(rod, options.cad) for rod in there}, flags)
    text = TEXT.format(
        engines="\n".join(engines),
        cad="\n".join(cad),
        sources="\n".join(f"- `{Path(rod.file).stem}` (engine: {rod.engine}): {rod.source}" for rod in there),
        notes="\n".join([*assumed(of_engines), "", *assumed(of_cad)]),
    )
    publish(text, options.report)


TEXT = """# First answers: what a newcomer is told, and whether it is believable

Made by `python tests/benchmarks/first_answers.py --cad FOLDER --report results/first-answers.md`: `fea run
STUDY --cycle` at each engine's redline, without other flags than those named below a table. "By" is the
load case with the smallest factor against yielding; "on" the region of the surface where fatigue governs.
Coordinates count from the crank pin, +x towards the piston pin; s are seconds on a machine with other work.
The widest bar is mostly that of a case which cannot govern.

## Rods of the engines in the library

`fea init --engine NAME` wrote the studies: length and bores are the engine's, everything else has the usual
proportions of this program, in forged steel.

{engines}

## Rods that other people drew

{cad}

{sources}

## Is it believable?

- *Rods of usual proportions without a known mass come out heavy*: the Honda's and the Toyota's weigh 40 to
  55 % more than the rods of engine-sim in [production-rods.md](production-rods.md). Their factors are
  those of heavy rods. Cause: the mass is not given, and the proportions are those of the León rod.
- *Rods with a known mass* (454, Jeep, EJ25, Hayabusa): gas pressure governs yielding, and fatigue a bore or
  the fillets beside the rings, with factors above 1, the smallest of the lightest rod at the highest speed.
  That is what is expected of rods that last.
- *León*: its published piston weighs 1.33 kg for a bore of 76 mm, five times the usual 0.6 g/cm³ × bore³. Its
  answer follows from loads that no such engine has; the study reproduces a thesis.
- *CAD*: an engine of the library stands for one that is not known, so that the loads are wrong by as much as
  the engines differ. The rods by Aqib12664, MohammadHaris13 and AAYUS2004 are those of one tutorial.
  KylerLimata's shank is a bar of 50 × 30 mm, four times the mass of a rod of that length: hence its factors.

## What was assumed

{notes}
"""

if __name__ == "__main__":
    main()
