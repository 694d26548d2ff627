"""Effect of the pins' model: prescribed pressures against contact over clearance.

    python tests/benchmarks/contact_models.py --report results/contact.md

The three shipped rods at their highest speed, and three random rods with cap bosses that went through a STEP
file. All models of a rod are solved on elements of the same size.
"""

import dataclasses
import gc
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scripts import publish, reporting

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from rod_studies import random_study

from fea.analysis.pipeline import prepare, solve_speed, with_cycle
from fea.analysis.prepared_rod import PreparedRod
from fea.base.choices import CONTACT
from fea.pins.fits import BIG_CLEARANCE, SMALL_CLEARANCE
from fea.study.option_tables import ContactTable, MeshTable
from fea.study.rod_table import rod_of_file
from fea.study.speed_tables import SpeedTable
from fea.study.study import Study, load_study
from geometry.cad.formats import step_file
from geometry.session import session
from geometry.surfaces import Surface
from mesh.sizing import default_size

PRESCRIBED = ("cosine-180", "uniform-120", "webster")
# Clearances over those that are assumed where a study says nothing.
CLEARANCES = {
    "contact, neat fit": 0.0,
    "contact, half": 0.5,
    "contact, as assumed": 1.0,
    "contact, 4 times": 4.0,
}
FIRST_SEED, STEP_RODS = 130000, 3
BORES = {"small bore": Surface.SMALL_END_BORE, "big bore": Surface.BIG_END_BORE}
HEAD = (
    "model",
    "safety",
    "case, at x, y, z mm",
    "fatigue",
    "small bore MPa",
    "its fatigue",
    "big bore MPa",
    "its fatigue",
)


class Found(NamedTuple):
    """Results of a model: the smallest factors, and the largest stress and smallest factor on each bore."""

    safety: float
    where: str
    fatigue: float
    peaks: tuple[float, float]
    tired: tuple[float, float]


def studies(folder: Path) -> Iterator[tuple[str, Study]]:
    """The rods, each at its highest speed."""
    for name in ("leon-2001", "columba-2022", "molina-2024"):
        study = load_study(name)
        rpm = max(study.speed.speeds())
        yield f"{name}, {rpm:g} rpm", dataclasses.replace(study, speed=SpeedTable(rpm))
    seed, found = FIRST_SEED, 0
    while found < STEP_RODS:
        study = random_study(seed)
        if study is not None and study.rod.dimensions.cap_bolt:
            path = folder / f"rod-{seed}.step"
            with session():
                path.write_bytes(step_file(study.rod.dimensions))
            table = rod_of_file(path)
            name = f"random rod {seed} (STEP), {study.speed.speeds()[0]:.0f} rpm"
            yield name, dataclasses.replace(study, rod=table)
            found += 1
        seed += 1


def models(study: Study) -> Iterator[tuple[str, PreparedRod]]:
    """The rod under each model, all with elements of the default size."""
    plain = prepare(study)
    bores = plain.mesh.bores
    size = MeshTable(size_mm=default_size(bores.rod_length))

    def under(pressure: str, contact: ContactTable) -> PreparedRod:
        options = dataclasses.replace(study.analysis, pressure=pressure, cycle=True)
        return prepare(dataclasses.replace(study, analysis=options, contact=contact, mesh=size))

    for pressure in PRESCRIBED:
        gc.collect()  # a rod and the basis of its cycle refer to each other
        yield pressure, under(pressure, ContactTable())
    for name, share in CLEARANCES.items():
        gc.collect()
        pins = ContactTable(
            small_end_clearance_mm=share * SMALL_CLEARANCE * 2 * bores.small_radius,
            big_end_clearance_mm=share * BIG_CLEARANCE * 2 * bores.big_radius,
        )
        yield name, under(CONTACT, pins)


def found(rod: PreparedRod, rpm: float) -> Found:
    """Solve the peak cases and the cycle of a rod at a speed."""
    result = with_cycle(rod, solve_speed(rod, rpm))
    mesh = rod.mesh.whole
    counts = np.all([case.counts for case in result.cases.values()], axis=0)
    least = {name: np.where(counts, case.safety_factor, np.inf) for name, case in result.cases.items()}
    case = min(least, key=lambda name: least[name].min())
    node = int(least[case].argmin())
    x, y, z = mesh.points[node]
    fatigue = result.cycle.envelope.fatigue_factor
    fatigue = np.full(len(mesh.points), np.nan) if fatigue is None else np.where(counts, fatigue, np.nan)
    on = [np.intersect1d(mesh.facets[bore], np.flatnonzero(counts)) for bore in BORES.values()]
    stress = np.max([each.von_mises for each in result.cases.values()], axis=0)
    return Found(
        safety=float(least[case][node]),
        where=f"{case}, {x:.0f}, {abs(y):.0f}, {abs(z):.0f}",
        fatigue=least_known(fatigue),
        peaks=tuple(float(stress[nodes].max()) for nodes in on),
        tired=tuple(least_known(fatigue[nodes]) for nodes in on),
    )


def least_known(factors: np.ndarray) -> float:
    """The smallest factor; NaN where the strengths of the material are not known."""
    return float(np.nanmin(factors)) if np.isfinite(factors).any() else float("nan")


def row(name: str, each: Found) -> str:
    """A line of the table."""
    (small, big), (small_tired, big_tired) = each.peaks, each.tired
    cells = (
        name,
        f"{each.safety:.2f}",
        each.where,
        f"{each.fatigue:.2f}",
        f"{small:.0f}",
        f"{small_tired:.2f}",
        f"{big:.0f}",
        f"{big_tired:.2f}",
    )
    return ("| " + " | ".join(cells) + " |").replace("nan", "–")


def main() -> None:
    """Solve every rod under every model."""
    parser = reporting(__doc__)
    report = parser.parse_args().report
    lines, ratios = [], {name: [] for name in PRESCRIBED}
    with tempfile.TemporaryDirectory() as scratch:
        for title, study in studies(Path(scratch)):
            lines += ["", f"## {title}", "", "| " + " | ".join(HEAD) + " |", "| --- " * len(HEAD) + "|"]
            table = {name: found(rod, study.speed.speeds()[0]) for name, rod in models(study)}
            lines += [row(name, each) for name, each in table.items()]
            assumed = table["contact, as assumed"]
            for name in PRESCRIBED:
                ratios[name].append((table[name], assumed))
            print("\n".join(lines[-9:]), file=sys.stderr, flush=True)
    text = TEXT.format(tables="\n".join(lines), summary="\n".join(summary(ratios)))
    publish(text, report)


def summary(ratios: dict[str, list[tuple[Found, Found]]]) -> Iterator[str]:
    """How far each prescribed pressure is from contact with the assumed clearances, over all rods."""
    head = ("pressure", "safety factor / contact's", "mean difference", "small bore's stress / contact's")
    yield "| " + " | ".join([*head, "big bore's"]) + " |"
    yield "| --- | --- | --- | --- | --- |"
    for name, pairs in ratios.items():
        safety = [one.safety / other.safety for one, other in pairs]
        small, big = ([one.peaks[k] / other.peaks[k] for one, other in pairs] for k in (0, 1))
        spans = [f"{min(each):.2f} … {max(each):.2f}" for each in (safety, small, big)]
        mean = 100 * sum(abs(ratio - 1) for ratio in safety) / len(safety)
        yield f"| {name} | {spans[0]} | {mean:.0f} % | {spans[1]} | {spans[2]} |"


TEXT = """# What the model of the pins changes

Made by `python tests/benchmarks/contact_models.py --report results/contact.md`.

The smallest safety factors against yielding (over the peak cases) and against fatigue (over the cycle), and
the largest stress on each bore with the smallest fatigue factor there. All models of a rod are solved on
elements of the default size, without refinement: the differences between models are what counts here.
Under contact the small end's bore widens towards its ends by as much as the pin bends, as in a run that is
told nothing of it. *As assumed* are the clearances of such a run, 0.6 ‰ of the small end's bore and 1 ‰ of
the big end's; the others are multiples of them. The piston pin is elastic, hollow to 0.6 of its diameter, the
crank pin rigid.

## The prescribed pressures against contact with the assumed clearances

{summary}

A ratio above 1 in the second column is unsafe: the prescribed pressure promises more than contact does. None
of the three is always on the safe side, and none can be: contact depends on the clearance (the last rows of
each table below), on the flexibility of the ring and on that of the pin. *cosine-180* is the nearest in the
mean and takes the place of contact where that cannot be computed.

Which one to use: contact, the default, with the clearances of the drawing, for every decision; *cosine-180*
where contact is not possible (a clamped big end, soft parts); *uniform-120* and *webster* only to repeat a
published calculation that used them.
{tables}
"""

if __name__ == "__main__":
    main()
