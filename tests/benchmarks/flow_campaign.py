"""What does yielding lead to in random rods, and do two meshes agree? Does a wall follow Bree's diagram?

    python tests/benchmarks/flow_campaign.py [--rods 100] [--first 620000] [--resume FILE.jsonl]

Every rod has a random engine and speed. Its yield strength is such that its loads are a random multiple, 0.6
to 1.6, of those at first yield on the finer mesh; the coarser one has elements of 1.4 times the size.
"""

import dataclasses
import sys
from collections import Counter
from pathlib import Path

import numpy as np
from scripts import Row, campaign, command, table

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from rod_studies import random_study

from fea.analysis.flow import FLOW, with_flow
from fea.analysis.meshing import adaptive_mesh
from fea.analysis.pipeline import prepare, solve_speed
from fea.machine.clock import Clock
from fea.plastic.cycling import PlasticAnswer, cycled
from fea.study.option_tables import AnalysisTable, MeshTable
from fea.study.study import Study
from fea.verify.cases.plasticity import YIELD, BentSlice
from geometry.errors import GeometryError, InvalidValue
from mesh.sizing import default_size
from mesh.tetmesh import MeshError

COARSER = 1.4


def outcome(seed: int) -> Row | None:
    """Follow the flow of a rod on two meshes; None where the rod is refused, or in separate parts."""
    study = random_study(seed)
    if study is None or study.rod.dimensions.bushing:
        return None
    multiple = float(np.random.default_rng([seed, 62]).uniform(0.6, 1.6))
    size = float(1.5 * default_size(study.rod.dimensions.length))
    study = dataclasses.replace(study, analysis=AnalysisTable(pressure="cosine-180"))
    row: Row = {"seed": seed, "multiple": multiple}
    try:
        fine = followed(study, size, row, multiple)
        coarse = followed(study, COARSER * size, row)
    except (InvalidValue, GeometryError, MeshError) as error:
        return {"seed": seed, "refused": f"{type(error).__name__}: {error}"}
    return {**row, "fine": fine, "coarse": coarse}


def followed(study: Study, size: float, row: Row, multiple: float = 0.0) -> Row:
    """What happens on one mesh; with a multiple of first yield, the strength follows from it."""
    study = dataclasses.replace(study, mesh=MeshTable(size_mm=size))
    (rpm,), mesh = study.speed.speeds()[:1], adaptive_mesh(study, Clock())
    if multiple:
        elastic = solve_speed(prepare(study, mesh=mesh), rpm)
        row["yield_MPa"] = max(case.max_von_mises for case in elastic.cases.values()) / multiple
    strength = {"yield_MPa": row["yield_MPa"], "cyclic_yield_MPa": row["yield_MPa"]}
    material = dataclasses.replace(study.material, **strength, ultimate_MPa=None, endurance_MPa=None)
    clock = Clock()
    rod = prepare(dataclasses.replace(study, material=material), clock, mesh=mesh)
    found = with_flow(rod, solve_speed(rod, rpm))
    plastic = found.plastic
    failed = [name for name, check in found.checks.items() if name.startswith("plastic") and not check.passed]
    seconds = {name: clock.seconds.get(name, 0.0) for name in ("factor", "plastic flow")}
    if plastic is None:
        why = next((note.text for note in found.notes if note.topic == FLOW), "elastic")
        return {"state": why, "failed": failed, **seconds}
    return {
        "state": plastic.state,
        "strain": plastic.max_plastic_strain,
        "elements": plastic.elements,
        "turns": plastic.turns,
        "factor of settling": float(plastic.settling_factor),
        "failed": failed,
        **seconds,
    }


def bree_grid() -> tuple[list[str], int]:
    """Points of a grid over Bree's diagram that are not in the right region, and how many there are."""
    wall, wrong, points = BentSlice(0.4), list[str](), 0
    for x in np.arange(0.05, 1.0, 0.1).tolist():
        for y in np.arange(0.13, 3.0, 0.3).tolist():  # none on a border
            cases = [wall.elastic(x * YIELD, y * YIELD * on) for on in (0.0, 1.0)]
            found, points = cycled(wall.zone, wall.body, cases).answer, points + 1
            if found is not region(x, y):
                wrong.append(f"X {x:.2f}, Y {y:.2f} ({found}, not {region(x, y)})")
    return wrong, points


def region(x: float, y: float) -> PlasticAnswer:
    """Bree's regions (J. Strain Analysis 2, 1967, 226), without hardening."""
    if x + y <= 1:
        return PlasticAnswer.ELASTIC
    if y <= min(2.0, 4 * (1 - x)):
        return PlasticAnswer.SHAKES_DOWN
    return PlasticAnswer.CYCLIC if y > 2 and x * y < 1 else PlasticAnswer.RATCHETS


def report_text(found: list[Row]) -> str:
    """The report."""
    ended = [row for row in found if "fine" in row]
    same = [row for row in ended if row["fine"]["state"] == row["coarse"]["state"]]
    counts = {mesh: Counter(row[mesh]["state"] for row in ended) for mesh in ("fine", "coarse")}
    states = dict.fromkeys([*(answer.value for answer in PlasticAnswer), *counts["fine"], *counts["coarse"]])
    failed = [row for row in ended if row["fine"]["failed"] or row["coarse"]["failed"]]
    wrong, points = bree_grid()
    head = (
        f"Made by `{command()}`: {len(found)} random rods at 0.6 to 1.6 of the loads at first yield, of "
        f"which {len(ended)} were followed on two meshes; {len(same)} have the same outcome on both, and "
        f"{len(failed)} fail a check of the flow."
    )
    wall = (
        f"Of a wall with a thermal gradient, {points - len(wrong)} of {points} points of a grid are in their "
        f"region of Bree's diagram{'; not so ' + ', '.join(wrong) if wrong else ''}."
    )
    lines = [
        "# Plastic flow of random rods",
        "",
        head,
        "",
        *table(
            ("outcome", "finer mesh:", "coarser mesh:"),
            ([state, *(str(counts[mesh][state]) for mesh in ("fine", "coarse"))] for state in states),
        ),
        "",
        wall,
    ]
    if len(same) < len(ended):
        lines += ["", "Rods whose outcome differs:", ""]
        lines += table(
            ("seed:", "multiple of first yield:", "finer mesh", "coarser mesh"),
            (
                [str(row["seed"]), f"{row['multiple']:.2f}", row["fine"]["state"], row["coarse"]["state"]]
                for row in ended
                if row not in same
            ),
        )
    others = [
        f"- rod {row['seed']}: {row.get('refused') or row['lost']}" for row in found if row not in ended
    ]
    return "\n".join([*lines, *(["", "Not followed:", "", *others] if others else []), ""])


if __name__ == "__main__":
    campaign(__doc__, outcome, report_text, count=100, first=620000)
