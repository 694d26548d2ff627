"""Are random assembled rods put together and loaded, or refused by name?

    python tests/benchmarks/assembly_campaign.py [--rods 300] [--first 190000] [--report FILE.md]

Every rod has cap bolts, a random engine and speed, random preload, fits, shells, friction and temperature,
some of them too much for it. It is drawn, meshed and put together, and its five load cases are solved from
that state; or it is refused with a reason.
"""

import collections
import dataclasses
import statistics
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scripts import campaign, command, publish, reporting, table

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from rod_studies import random_study

from fea.analysis.prepare import prepare
from fea.base.choices import CONTACT, PinBody
from fea.pins.assembly import AssemblyPins
from fea.solid.errors import ContactError
from fea.study.assembly_table import AssemblyTable
from fea.study.option_tables import AnalysisTable, ContactTable, MeshTable, SpeedTable
from fea.study.study import Study
from geometry.errors import GeometryError, InvalidValue
from mesh.sizing import default_size
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


def drawn(seed: int) -> Study | InvalidValue | None:
    """A random assembled rod on a coarse mesh, or its refusal; None where no rod or no bolts were drawn."""
    study = random_study(seed)
    if study is None or not study.rod.dimensions.cap_bolt:
        return None
    draw, rod = np.random.default_rng([seed, 191]), study.rod.dimensions
    head = rod.cap_bolt * float(draw.uniform(1.35, 1.7))

    def some(chance: float, value: float) -> float | None:
        return float(value) if draw.random() < chance else None

    shell = some(0.6, draw.uniform(0.1, 0.4) * rod.big_end_ring)
    try:
        wider = dataclasses.replace(
            rod, cap_bolt_spacing=rod.cap_bolt_spacing + head * draw.uniform(0.3, 1.0)
        )
        table = AssemblyTable(
            bolt_preload_kN=float(0.35 * rod.cap_bolt**2 * draw.uniform(0.3, 1.3)),
            bolt_head_mm=head,
            bolt_nut_mm=some(0.5, head * draw.uniform(0.85, 1.05)),
            bushing_interference_mm=some(0.7, 1.5e-3 * rod.small_end_bore * draw.random())
            if rod.bushing
            else None,
            shell_thickness_mm=shell,
            shell_interference_mm=None
            if shell is None
            else some(0.8, 1.2e-3 * rod.big_end_bore * draw.random()),
            joint_friction=some(0.8, draw.choice([0.0, 0.05, 0.15, 0.3, 0.6])),
            temperature_C=some(0.5, draw.uniform(-20, 160)),
        )
        return dataclasses.replace(
            study,
            rod=dataclasses.replace(study.rod, dimensions=wider),
            assembly=table,
            contact=ContactTable(piston_pin=PinBody(draw.choice(["elastic", "rigid"]))),
            analysis=AnalysisTable(pressure=CONTACT),
            mesh=MeshTable(size_mm=float(2 * default_size(rod.length))),
            speed=SpeedTable(float(study.speed.speeds()[0] * draw.uniform(0.2, 1.3))),
        )
    except InvalidValue as refusal:
        return refusal


def outcome(seed: int) -> Outcome | None:
    """Put a rod together and solve its load cases."""
    start = time.perf_counter()
    study = drawn(seed)
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
