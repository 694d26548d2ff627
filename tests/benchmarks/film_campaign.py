"""Oil films drawn at random on one rod: each is solved, named by its verdict, or refused; none without end.

    python tests/benchmarks/film_campaign.py --count 300 --resume films.json

Oil, temperature, clearance, hole, roughness and speed (500 to 9 000 rpm) are drawn; the rod is leon-2001. The
grids are coarser than those of a run. A film is bad where a check fails, where the gap is not positive, where
the solver gives up, or beyond `LONGEST` seconds of processor time.
"""

import argparse
import json
import time
from collections import Counter
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from fea.analysis.film import film_at
from fea.analysis.prepare import prepare
from fea.pins import lubrication
from fea.solid.errors import FilmError
from fea.study.film_table import FilmTable
from fea.study.flags import Flags
from fea.study.study import load_study
from geometry.errors import InvalidValue

GRADES = ("8", "0W-16", "0W-20", "5W-30", "10W-40", "20W-50", "60")
LONGEST = 120.0


def main() -> None:
    """Draw, solve and count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--resume", type=Path, help="a JSON file to keep outcomes in")
    arguments = parser.parse_args()
    path = arguments.resume
    kept = json.loads(path.read_text()) if path is not None and path.exists() else {}
    lubrication.FINE, lubrication.COARSE = (64, 5, 120), (48, 4, 72)
    rod = prepare(Flags(size=18.0, pressure="bonded").applied(load_study()))
    for seed in map(str, range(arguments.first, arguments.first + arguments.count)):
        if seed not in kept:
            kept[seed] = outcome(rod, int(seed))
            print(seed, json.dumps(kept[seed]), flush=True)
            if path is not None:
                path.write_text(json.dumps(kept, indent=1))
    print(Counter(entry["verdict"] for entry in kept.values()))
    print("bad:", [seed for seed, entry in kept.items() if entry["bad"]])
    print("longest:", max(entry["seconds"] for entry in kept.values()), "s")


def drawn(seed: int) -> tuple[FilmTable, float]:
    """A bearing's [film] and a speed, rpm."""
    rng = np.random.default_rng(seed)
    table = FilmTable(
        oil=str(rng.choice(GRADES)),
        piezoviscosity_1_GPa=float(rng.uniform(0, 20)),
        radial_clearance_um=float(rng.uniform(12, 60)),
        inlet_bar=float(rng.uniform(1, 8)),
        inlet_C=float(rng.uniform(20, 130)),
        hole_deg=float(rng.uniform(-180, 180)),
        hole_diameter_mm=float(rng.uniform(2, 8)),
        roughness_um=float(rng.uniform(0.1, 1)),
    )
    return table, float(rng.uniform(500, 9000))


def outcome(rod, seed: int) -> dict:
    """Solve one and say what came of it."""
    table, rpm = drawn(seed)
    there = replace(rod, structure=replace(rod.structure, film=table))
    there.films.__dict__["bore"] = rod.films.bore
    started = time.process_time()
    try:
        found = film_at(there, rpm)
    except (FilmError, InvalidValue) as error:
        kind = "refused" if isinstance(error, InvalidValue) else "not solved"
        return {"verdict": kind, "bad": kind != "refused", "why": str(error), "rpm": rpm, "seconds": 0.0}
    seconds = round(time.process_time() - started, 1)
    failed = [name for name, check in found.checks.items() if not check.passed]
    positive = found.cycle.thinnest.min() > 0
    figures = {key: value for key, value in asdict(found.figures).items() if isinstance(value, float)}
    bad = bool(failed) or not positive or seconds > LONGEST
    said = {
        "verdict": found.verdict.value,
        "bad": bad,
        "failed": failed,
        "rpm": round(rpm),
        "seconds": seconds,
    }
    return said | {key: float(f"{value:.4g}") for key, value in figures.items()}


if __name__ == "__main__":
    main()
