"""Oil films of random rods: each is solved, named by its verdict, or refused by name; none unlimited.

    python tests/benchmarks/film_campaign.py --count 300 --resume films.json --report results/film-campaign.md

Rod, engine, both clearances, oil and its supply, roughness, piston pin and speed (500 to 9 000 rpm, at most
30 m/s of the piston in the mean) are drawn; the loads are not limited to what a bearing endures. Mesh and
grids are coarser than those of a run. A film is bad where a check fails, where the gap is negative, where
anything but a refusal ends it, or beyond `LONGEST` seconds of processor time.
"""

import dataclasses
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
from scripts import Row, campaign, command, table

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from rod_studies import random_study

from fea.analysis.film import film_at
from fea.analysis.pipeline import prepare
from fea.analysis.prepared_rod import PreparedRod
from fea.pins import lubrication
from fea.pins.yielding import End
from fea.solid.errors import FilmError
from fea.study.film_table import TURNS, FilmTable
from fea.study.option_tables import AnalysisTable, ContactTable, MeshTable
from fea.study.speed_tables import SpeedTable
from fea.study.study import Study
from geometry.errors import GeometryError, InvalidValue
from mesh.sizing import default_size
from mesh.tetmesh import MeshError

GRADES = ("8", "0W-16", "0W-20", "5W-30", "10W-40", "20W-50", "60")
FASTEST, LONGEST = 30e3, 30.0  # mean speed of the piston, mm/s; s
REFUSED, BEYOND, CRASHED = "refused", "beyond the model", "crashed"


def drawn(seed: int) -> Study | None:
    """A random rod, its bearings and a speed; None where the rod is refused."""
    study = random_study(seed)
    if study is None:
        return None
    rng, rod = np.random.default_rng([seed, 38]), study.rod.dimensions
    grooves = {
        "grooves_deg": (90.0, 270.0),
        "groove_arc_deg": 20.0,
        "groove_width_mm": 0.6 * rod.big_end_width,
    }
    film = FilmTable(
        oil=str(rng.choice(GRADES)),
        piezoviscosity_1_GPa=float(rng.uniform(0, 20)),
        radial_clearance_um=float(rng.uniform(0.3, 2.0) * rod.big_end_bore / 2),
        inlet_bar=float(rng.uniform(1, 8)),
        inlet_C=float(rng.uniform(20, 130)),
        hole_deg=float(rng.uniform(-180, 180)),
        hole_diameter_mm=float(rng.uniform(0.04, 0.15) * rod.big_end_bore),
        roughness_um=float(rng.choice([0.0, 1.0], p=[0.1, 0.9]) * rng.uniform(0.1, 1)),
        piston_pin=str(rng.choice(list(TURNS))),
        small_end_C=float(rng.uniform(60, 180)),
        small_end_inlet_bar=float(rng.uniform(0.5, 3)),
        **(grooves if rng.random() < 0.25 else {}),
    )
    contact = ContactTable(small_end_clearance_mm=float(rng.uniform(0.4, 3.0) * 1e-3 * rod.small_end_bore))
    most = 30 * FASTEST / study.engine.stroke_mm
    return dataclasses.replace(
        study,
        film=film,
        contact=contact,
        analysis=AnalysisTable(pressure="bonded"),
        mesh=MeshTable(size_mm=float(2 * default_size(rod.length))),
        speed=SpeedTable(float(rng.uniform(500, min(9000, most)))),
    )


def outcome(seed: int) -> Row | None:
    """Outcomes of the films of a rod, by the end."""
    study = drawn(seed)
    if study is None:
        return None
    lubrication.FINE, lubrication.COARSE = (64, 5, 96), (48, 4, 72)
    try:
        rod = prepare(study)
    except (InvalidValue, GeometryError, MeshError) as error:
        why = f"{type(error).__name__}: {error}"
        return {"seed": seed} | {end: {"verdict": REFUSED, "bad": False, "why": why} for end in End}
    return {"seed": seed} | {end: film_outcome(rod, end, study.speed.speeds()[0]) for end in End}


def film_outcome(rod: PreparedRod, end: End, rpm: float) -> dict:
    """Solve the film of an end and say what came of it."""
    started = time.process_time()
    said = {"rpm": round(rpm), "length": round(rod.mesh.bores.rod_length, 1)}
    try:
        found = film_at(rod, rpm, rod.films if end is End.BIG else rod.small_end_films)
        figures = dataclasses.asdict(found.figures)
    except (FilmError, InvalidValue, ArithmeticError) as error:
        kinds = {FilmError: BEYOND, InvalidValue: REFUSED}
        kind, seconds = kinds.get(type(error), CRASHED), time.process_time() - started
        bad = kind == CRASHED or seconds > LONGEST
        return said | {"verdict": kind, "bad": bad, "why": str(error), "seconds": seconds}
    seconds = time.process_time() - started
    failed = [f"{name} {check.value:.2g}" for name, check in found.checks.items() if not check.passed]
    least = min(float(film.thinnest.min()) for film in (found.cycle, found.coarse))
    said |= {"bad": bool(failed) or not least >= 0 or seconds > LONGEST, "why": ", ".join(failed)}
    kept = {name: value for name, value in figures.items() if isinstance(value, float)}
    repeats = found.cycle.repeats or not found.sound
    return said | kept | {"verdict": found.verdict.value, "seconds": seconds, "repeats": repeats}


def report_text(rods: list[Row]) -> str:
    """The report."""
    lost = [{"verdict": CRASHED, "bad": True, "why": rod["lost"]} if "lost" in rod else {} for rod in rods]
    rods = [rod | dict.fromkeys(End, film) if film else rod for rod, film in zip(rods, lost, strict=True)]
    head = (
        f"Made by `{command()}`: {len(rods)} random rods, oils and speeds from 500 to 9 000 rpm, a film at "
        "both ends of each."
    )
    lines = ["# Oil films of random rods", "", head, ""]
    columns: dict[End, dict[str, str]] = {end: column([rod[end] for rod in rods]) for end in End}
    rows = [
        (name, *(columns[end].get(name, "0") for end in End))
        for name in {**columns[End.BIG], **columns[End.SMALL]}
    ]
    lines += [*table(("films", "big end:", "small end:"), rows), ""]
    for title, wanted in (("Refused:", REFUSED), ("Beyond the model:", BEYOND), ("Bad:", None)):
        listed = [
            f"- rod {rod['seed']}, {end.words}: {rod[end]['why'] or rod[end]['seconds']}"
            for rod in rods
            for end in End
            if (rod[end]["verdict"] == wanted if wanted else rod[end]["bad"])
        ]
        lines += [title, "", *listed, ""] if listed else []
    return "\n".join(lines)


def column(films: list[dict]) -> dict[str, str]:
    """Counts and extremes of the films of an end."""
    solved = [each for each in films if "h_min_um" in each]
    counts = Counter(each["verdict"] for each in films)
    times = [each["seconds"] for each in films if "seconds" in each]
    return {
        **{name: str(count) for name, count in sorted(counts.items())},
        "bad: failed check, negative gap, crashed, too long": str(sum(each["bad"] for each in films)),
        "not repeated within the most cycles": str(sum(not each["repeats"] for each in solved)),
        "smallest gap of all, µm": f"{min(each['h_min_um'] for each in solved):.2g}",
        "processor time, s, median and longest": f"{np.median(times):.1f} and {max(times):.1f}",
    }


if __name__ == "__main__":
    campaign(__doc__, outcome, report_text, count=300, what="count")
