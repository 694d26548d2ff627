"""How long are rods that are known to live predicted to live? Hours and B10 at the redline, by default.

    python tests/benchmarks/known_lives.py [--resume FILE.json] [--report results/known-lives.md]

The rods are those of twelve engines of the library, as `fea init` writes them, and the four of
`production_rods.py`. Each is run as `fea run --cycle` does, with an empty table [scatter], which asks for
B-lives although strength or peak pressure is assumed. A rod with hours is run again with one assumption
changed at a time. Other flags, as `--size 14 --tolerance 0` for a trial, go to the runs.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from production_rods import ENGINES, study_of
from scripts import command, keep, kept_in, publish, reporting, table

from fea.analysis.engine_study import engine_study
from fea.analysis.summary_figures import Summary
from fea.apps.result import analyse
from fea.output.life_statements import lasting
from fea.output.units import hours_text
from fea.study.study import Study, parse_study

LIBRARY = (
    "audi-2.2", "bmw-m52b28", "chevrolet-454", "ford-4.6", "honda-b18c5", "jeep-4.0", "leon-2001", "sd195",
    "subaru-ej25", "suzuki-g10", "suzuki-hayabusa", "toyota-2jz",
)  # fmt: skip
SOON = 1000.0  # hours: a B10 below is one of hours, not of the life of an engine
# What is assumed of a rod with hours, each alone made as favourable as is plausible.
CHANGES: dict[str, dict[str, Any]] = {
    "a piston of 0.45 g/cm³ × bore³": {},
    "a steel of 1000 MPa (endurance 451 MPa)": {"material": {"ultimate_MPa": 1000.0, "endurance_MPa": 451.0}},
    "bores finished as polished": {"material": {"bore_surface": "polished"}},
}
HEAD = (
    "rod", "rpm:", "mass g:", "fatigue factor", "fails first", "mean ± amplitude MPa", "lasts", "B10", "B50",
    "peak pressure bar",
)  # fmt: skip


def studies() -> Iterator[tuple[str, Study]]:
    """Yield the sixteen rods with their names."""
    for name in LIBRARY:
        yield name, parse_study(engine_study(name), name, Path.cwd())
    for engine in ENGINES:
        yield f"{engine.name}, production", study_of(engine)


def found(study: Study, flags: dict[str, Any]) -> dict[str, Any]:
    """Figures of a run."""
    summary: Summary = analyse(study.with_(scatter={}), cycle=True, **flags).summary
    envelope = summary.envelope
    life, worst = envelope.life, envelope.fatigue
    sure = life.reliability
    return {
        "rpm": summary.rpm,
        "mass": 1e3 * summary.rod.mass_kg,
        "factor": worst.fatigue_safety_factor,
        "where": worst.where,
        "mean": worst.mean_MPa,
        "amplitude": worst.amplitude_MPa,
        "lasts": lasting(life),
        "b10": None if sure is None else sure.b10_hours,
        "b50": None if sure is None else sure.b50_hours,
        "sure": sure is not None,
        "conditional": sure is not None and sure.conditional,
        "said": summary.survival.text,
    }


def main() -> None:
    """Ask of every rod."""
    parser = reporting(__doc__)
    parser.add_argument("--resume", type=Path, help="JSON file that keeps the outcomes")
    parser.add_argument("--size", type=float)
    parser.add_argument("--tolerance", type=float)
    options = parser.parse_args()
    flags = {name: value for name in ("size", "tolerance") if (value := getattr(options, name)) is not None}
    kept = kept_in(options.resume)
    for name, study in studies():
        if name not in kept:
            kept[name] = found(study, flags)
            print(name, kept[name], file=sys.stderr, flush=True)
            keep(options.resume, kept)


if __name__ == "__main__":
    main()
