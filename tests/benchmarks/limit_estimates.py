"""Do the estimates that `fea limits` prints first of rods in parts hold, once the limits are solved?

    python tests/benchmarks/limit_estimates.py [--rods 60] [--first 0] [--resume FILE.jsonl]

Random rods with cap bolts in random engines, fits, preloads and temperatures, on coarse meshes. Each has up
to three limits: the speed at full load, the peak pressure at its speed, and the speed with closed throttle.
An estimate holds if the limit that is solved lies within its error bar, both on the same mesh.
"""

import math
import statistics
import sys
import time
from dataclasses import replace
from pathlib import Path

from scripts import Row, campaign, command, table

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from rod_studies import assembled_study

from fea.analysis.pipeline import refined_rod
from fea.apps.limits.explore import RodLimits, explore
from fea.apps.limits.figures import largest_values
from fea.machine.clock import Clock
from fea.solid.errors import ContactError
from fea.study.option_tables import MeshTable
from geometry.errors import GeometryError, InvalidValue
from mesh.tetmesh import MeshError

COARSER = 1.7  # than the campaign of assembled rods, whose states are not estimated
LINES = ("speed", "pressure", "closed")


def outcome(seed: int) -> Row | None:
    """Estimate and solve the limits of a rod; None where no rod in parts was drawn."""
    study = assembled_study(seed)
    if study is None or isinstance(study, InvalidValue):
        return None
    size = study.mesh.size_mm
    study = replace(study, mesh=MeshTable(size_mm=None if size is None else COARSER * size))
    start, estimated = time.perf_counter(), list[tuple[float, RodLimits]]()
    try:
        rpm = study.speed.speeds()[0]
        adapted = refined_rod(study, [rpm], Clock())
        found = explore(
            adapted,
            rpm,
            answered=lambda first: estimated.append((time.perf_counter() - start, first)),
            mapped=False,
        )
    except (InvalidValue, GeometryError, MeshError, ContactError) as error:
        return {"seed": seed, "refused": f"{type(error).__name__}: {error}"}
    after, first = estimated[0]
    row: Row = {"seed": seed, "estimated_s": after, "solved_s": time.perf_counter() - start}
    for line, own, other in zip(LINES, largest_values(first), largest_values(found), strict=True):
        told = {} if own is None else {"estimate": own.value, "bar": own.bar, "mode": own.mode}
        solved = {} if other is None else {"solved": other.value, "solved_mode": other.mode}
        row[line] = told | solved
    return row


def limits_of(rows: list[Row]) -> list[Row]:
    """Limits that were estimated, each with its error and its bar over the value that is solved."""
    return [
        {"seed": row["seed"], "line": line, **row[line]}
        for row in rows
        for line in LINES
        if "estimate" in row.get(line, {})
    ]


def report_text(rows: list[Row]) -> str:
    """The report."""
    solved = [row for row in rows if "solved_s" in row]
    told = [row for row in solved if any("estimate" in row[line] for line in LINES)]
    limits = limits_of(solved)
    barred = [one for one in limits if one.get("bar") is not None]
    held = [one for one in barred if abs(one.get("solved", math.inf) - one["estimate"]) <= one["bar"]]
    bars = [100 * one["bar"] / one["estimate"] for one in barred]
    errors = [100 * abs(one["estimate"] / one["solved"] - 1) for one in limits if "solved" in one]
    waited = [row["estimated_s"] / row["solved_s"] for row in told]
    facts = [
        ("rods whose limits were sought", f"{len(rows)}"),
        ("of these refused by name", f"{sum('refused' in row for row in rows)}"),
        ("that took too long", f"{sum('lost' in row for row in rows)}"),
        ("rods with an estimate", f"{len(told)} of {len(solved)}"),
        ("estimates of limits; with a bar", f"{len(limits)}; {len(barred)}"),
        ("the solved limit lies within the bar", f"{len(held)} of {len(barred)}"),
        ("bar, median, %", f"{statistics.median(bars):.2g}" if bars else "–"),
        ("error of the estimate, median and largest, %",
         f"{statistics.median(errors):.2g}, {max(errors):.2g}" if errors else "–"),
        ("time to the estimate over that to the solution, median",
         f"{statistics.median(waited):.2f}" if waited else "–"),
    ]  # fmt: skip
    missed = [
        (f"{one['seed']}", one["line"], one["mode"], f"{one['estimate']:.4g}", f"{one['bar']:.2g}",
         f"{one.get('solved', math.nan):.4g}", one.get("solved_mode", "none"))
        for one in barred if one not in held
    ]  # fmt: skip
    head = ("seed", "limit", "ended by", "estimate", "±", "solved", "ended by")
    lines = ["# Estimated limits of rods in parts", "", f"Made by `{command()}`.", ""]
    lines += table(("what", "found"), facts)
    if missed:
        lines += ["", "## Outside their bars", "", *table(head, missed)]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    campaign(__doc__, outcome, report_text, count=60)
