"""Are random assembled rods put together and loaded, or refused by name?

    python tests/benchmarks/assembly_campaign.py [--rods 300] [--first 190000] [--resume FILE.jsonl]

Every rod has cap bolts, a random engine and speed, random preload, fits, shells, friction and temperature,
some of them too much for it. It is drawn, meshed and put together, and its five load cases are solved from
that state; or it is refused with a reason.
"""

import collections
import statistics
import sys
import time
from pathlib import Path

from scripts import Row, campaign, command, table

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from rod_studies import assembled_study

from fea.analysis.pipeline import prepare
from fea.pins.assembly import AssemblyPins
from fea.solid.errors import ContactError
from geometry.errors import GeometryError, InvalidValue
from mesh.tetmesh import MeshError

# After this long a rod counts as one that does not end, s.
PATIENCE = 900.0
# More states than these are tried only where an end of the rod no longer changes all places at once.
MANY = 80


def outcome(seed: int) -> Row | None:
    """Put a rod together and solve its load cases: the worst of them, or why there is nothing."""
    start = time.perf_counter()
    study = assembled_study(seed)
    if study is None:
        return None
    try:
        if isinstance(study, InvalidValue):
            raise study
        rod = prepare(study)
        pins = rod.pins
        assert isinstance(pins, AssemblyPins)
        found = pins.states(rod.loading.at(rod.mass, study.speed.speeds()[0]).cases)
    except (InvalidValue, GeometryError, MeshError, ContactError) as error:
        seconds = time.perf_counter() - start
        return {"seed": seed, "seconds": seconds, "refused": f"{type(error).__name__}: {error}"}
    changes = [each.changes for each in found]
    return {
        "seed": seed,
        "seconds": time.perf_counter() - start,
        "unknowns": pins.contact.problem.unfolding.size,
        "residual": max(each.residual for each in [*found, pins.assembly.assembled.start]),
        "imbalance": max(each.imbalance for each in found),
        "most_changes": max(changes),
        "long": sum(count > MANY for count in changes),
    }


def report_text(found: list[Row]) -> str:
    """The report."""
    solved = [row for row in found if "residual" in row]
    refused = [row for row in found if "refused" in row]
    endless = [row for row in found if "lost" in row]
    unknowns = [row["unknowns"] for row in solved]
    times = [row["seconds"] for row in found if "seconds" in row]
    rows = {
        "load cases solved": f"{5 * len(solved)}",
        "largest violation of contact or friction, relative": f"{max(row['residual'] for row in solved):.1e}",
        "largest error of a pin's resultant, relative": f"{max(row['imbalance'] for row in solved):.1e}",
        f"load cases of more than {MANY} states": f"{sum(row['long'] for row in solved)}",
        "most states tried in a load case": f"{max(row['most_changes'] for row in solved)}",
        "unknowns, median and most": f"{statistics.median(unknowns):.0f}, {max(unknowns)}",
        "seconds per rod, median and longest": f"{statistics.median(times):.1f}, {max(times):.1f}",
        f"rods without an end after {PATIENCE:g} s": f"{len(endless)}",
    }
    kinds = collections.Counter(row["refused"].split(" = ")[0].split(";")[0][:90] for row in refused)
    lines = [
        "# Random assembled rods",
        "",
        f"Made by `{command()}`: {len(found)} random rods with cap and bolts,",
        f"of which {len(solved)} were put together and solved in five load cases,",
        f"and {len(refused)} refused.",
        "",
        *table(("over all rods", ":"), rows.items()),
        "",
        "Reasons of the refusals:",
        "",
        *(f"- {count} × {kind}" for kind, count in kinds.most_common()),
    ]
    if endless:
        lines += ["", f"Without an end: {', '.join(str(row['seed']) for row in endless)}"]
    return "\n".join([*lines, ""])


if __name__ == "__main__":
    campaign(__doc__, outcome, report_text, count=300, first=190000, patience=PATIENCE)
