"""Does the contact of random rods end, at every crank angle, with exact resultants?

    python tests/benchmarks/contact_campaign.py [--rods 300] [--first 120000] [--resume FILE.jsonl]

Every rod has a random engine and speed, random pins (rigid or elastic, solid or hollow) and clearances from a
press fit to 0.2 mm. At each of 721 crank angles the contact is solved; a rod is either solved at all of them
or refused with a reason.
"""

import dataclasses
import statistics
import sys
import time
from pathlib import Path
from typing import cast

import numpy as np
from scripts import Row, campaign, command, table

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from rod_studies import random_study

from fea.analysis.pipeline import prepare
from fea.base.choices import CONTACT, PinBody
from fea.contact.active_set import MOST_CHANGES
from fea.pins.contact import ContactPins
from fea.solid.errors import ContactError
from fea.study.option_tables import AnalysisTable, ContactTable, MeshTable
from fea.study.speed_tables import SpeedTable
from fea.study.study import Study
from geometry.errors import GeometryError, InvalidValue
from mesh.sizing import default_size
from mesh.tetmesh import MeshError


def drawn(seed: int) -> Study | None:
    """A random rod with random pins on a coarse mesh; None where the rod is refused."""
    study = random_study(seed)
    if study is None:
        return None
    draw, rod = np.random.default_rng([seed, 71]), study.rod.dimensions
    clearance = draw.choice([-1, 0, 1], size=2, p=[0.25, 0.1, 0.65])
    size = np.where(clearance < 0, 1e-3 * np.array([rod.small_end_bore, rod.big_end_bore]), 0.2)
    small, big = (clearance * draw.uniform(0, 1, 2) * size).tolist()
    pins = ContactTable(
        small_end_clearance_mm=small,
        big_end_clearance_mm=big,
        piston_pin=PinBody(draw.choice(["elastic", "elastic", "rigid"])),
        piston_pin_bore_mm=float(draw.choice([0.0, 0.4, 0.6, 0.75]) * rod.small_end_bore),
    )
    return dataclasses.replace(
        study,
        contact=pins,
        analysis=AnalysisTable(pressure=CONTACT),
        mesh=MeshTable(size_mm=float(2 * default_size(rod.length))),
        speed=SpeedTable(float(study.speed.speeds()[0] * draw.uniform(0.2, 1.2))),
    )


def outcome(seed: int) -> Row | None:
    """Solve a rod at every degree: the worst of all angles, or why there is nothing."""
    study = drawn(seed)
    if study is None:
        return None
    try:
        rod = prepare(study)
        pins, instants = cast("ContactPins", rod.pins), rod.crank_cycle(study.speed.speeds()[0]).degrees
        start = time.perf_counter()
        found = pins.states(instants)
        seconds = time.perf_counter() - start
    except (InvalidValue, GeometryError, MeshError, ContactError) as error:
        return {"seed": seed, "refused": f"{type(error).__name__}: {error}"}
    changes = [each.changes for each in found]
    return {
        "seed": seed,
        "unknowns": pins.contact.problem.unfolding.size,
        "residual": max(each.residual for each in found),
        "imbalance": max(each.imbalance for each in found),
        "most_changes": max(changes),
        "exchanged": sum(count > MOST_CHANGES for count in changes),
        "milliseconds": 1e3 * seconds / len(found),
    }


def report_text(found: list[Row]) -> str:
    """The report."""
    solved = [row for row in found if "residual" in row]
    refused = [
        f"- rod {row['seed']}: {row.get('refused') or row['lost']}" for row in found if row not in solved
    ]
    angles, exchanged = 721 * len(solved), sum(row["exchanged"] for row in solved)
    unknowns, times = [row["unknowns"] for row in solved], [row["milliseconds"] for row in solved]
    rows = {
        "angles solved": f"{angles}",
        "largest overlap or gap under pressure, relative": f"{max(row['residual'] for row in solved):.1e}",
        "largest error of a resultant, relative": f"{max(row['imbalance'] for row in solved):.1e}",
        "angles that needed single exchanges": f"{exchanged} ({100 * exchanged / angles:.2g} %)",
        "most contact areas tried at an angle": f"{max(row['most_changes'] for row in solved)}",
        "unknowns, median and most": f"{statistics.median(unknowns):.0f}, {max(unknowns)}",
        "mean time per angle, ms, median and longest": f"{statistics.median(times):.2f}, {max(times):.2f}",
    }
    head = (
        f"Made by `{command()}`: {len(found)} random rods, of which {len(solved)} were solved at each of 721 "
        f"crank angles and {len(refused)} refused."
    )
    lines = [
        "# Contact of random rods at every crank angle",
        "",
        head,
        "",
        *table(("over all angles of all rods", ":"), rows.items()),
    ]
    return "\n".join([*lines, *(["", "Refused:", "", *refused] if refused else []), ""])


if __name__ == "__main__":
    campaign(__doc__, outcome, report_text, count=300, first=120000)
