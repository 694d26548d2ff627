"""Are random assembled rods put together and loaded, or refused by name?

    python tests/benchmarks/assembly_campaign.py [--rods 300] [--first 190000] [--report FILE.md]

Every rod has cap bolts, a random engine and speed, random preload, fits, shells, friction and temperature,
some of them too much for it. It is drawn, meshed and put together, and its five load cases are solved from
that state; or it is refused with a reason.
"""

import collections
import statistics
import sys
import time
from pathlib import Path
from typing import NamedTuple

from scripts import campaign, command, publish, reporting, table

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from assembled_studies import assembled_study

from fea.analysis.pipeline import prepare
from fea.pins.assembly import AssemblyPins
from fea.solid.errors import ContactError
from geometry.errors import GeometryError, InvalidValue
from mesh.tetmesh import MeshError

# After this long a rod counts as one that does not end, s.
PATIENCE = 900.0
# More states than these are tried only where an end of the rod no longer changes all places at once.
MANY = 80


class Outcome(NamedTuple):
    """What came of a rod: the worst of its cases, or why there is nothing."""

    seed: int
    unknowns: int = 0
    residual: float = 0.0
    imbalance: float = 0.0
    most_changes: int = 0
    long: int = 0
    seconds: float = 0.0
    refused: str = ""


def outcome(seed: int) -> Outcome | None:
    """Put a rod together and solve its load cases."""
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
        return Outcome(seed, seconds=seconds, refused=f"{type(error).__name__}: {error}")
    changes = [each.changes for each in found]
    return Outcome(
        seed,
        unknowns=pins.contact.problem.unfolding.size,
        residual=max(each.residual for each in [*found, pins.assembly.assembled.start]),
        imbalance=max(each.imbalance for each in found),
        most_changes=max(changes),
        long=sum(count > MANY for count in changes),
        seconds=time.perf_counter() - start,
    )


def report_text(found: list[Outcome], endless: list[int]) -> str:
    """The report."""
    solved = [each for each in found if not each.refused]
    refused = [each for each in found if each.refused]
    unknowns, times = [e.unknowns for e in solved], [e.seconds for e in found]
    rows = {
        "load cases solved": f"{5 * len(solved)}",
        "largest violation of contact or friction, relative": f"{max(e.residual for e in solved):.1e}",
        "largest error of a pin's resultant, relative": f"{max(e.imbalance for e in solved):.1e}",
        f"load cases of more than {MANY} states": f"{sum(e.long for e in solved)}",
        "most states tried in a load case": f"{max(e.most_changes for e in solved)}",
        "unknowns, median and most": f"{statistics.median(unknowns):.0f}, {max(unknowns)}",
        "seconds per rod, median and longest": f"{statistics.median(times):.1f}, {max(times):.1f}",
        f"rods without an end after {PATIENCE:g} s": f"{len(endless)}",
    }
    kinds = collections.Counter(each.refused.split(" = ")[0].split(";")[0][:90] for each in refused)
    lines = [
        "# Random assembled rods",
        "",
        f"Made by `{command()}`: {len(found) + len(endless)} random rods with cap and bolts,",
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
        lines += ["", f"Without an end: {', '.join(map(str, endless))}"]
    return "\n".join([*lines, ""])


def main() -> None:
    """Solve all rods and print the report."""
    parser = reporting(__doc__)
    parser.add_argument("--rods", type=int, default=300)
    parser.add_argument("--first", type=int, default=190000)
    parser.add_argument("--processes", type=int, default=2)
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + 100 * arguments.rods)
    found, endless = campaign(outcome, seeds, arguments.rods, arguments.processes, PATIENCE)
    publish(report_text(found, endless), arguments.report)


if __name__ == "__main__":
    main()
