"""Five questions whose first answer is wrong: the figures behind docs/understand/questions.md.

    python tests/benchmarks/questions.py --report results/questions.md

Each is computed with the product on the shipped rods, on one coarse mesh, without refinement and
without plastic flow: the tables compare, and their single figures have the error of such a mesh.
"""

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from scripts import command, publish, reporting, table

from fea import analyse, load_study
from fea.study.study import Study
from loads.instants import Instants
from mesh.slices import cut

COARSE = {"tolerance": 0, "elastic": True}


def film() -> Iterator[str]:
    """Does a stiffer big end carry the oil film better?"""
    leon = load_study("leon-2001")
    thicker = leon.with_(rod={"big_end_ring_mm": 14.72})
    stiffer = leon.with_(material={"E_GPa": 1000})
    rows = []
    for name, study in (("as drawn", leon), ("ring 6 mm thicker", thicker), ("E = 1000 GPa", stiffer)):
        found = analyse(study, rpm=6000, size=14, film=True, **COARSE).as_dict()
        big = found["film"]["big_end"]
        rows.append(
            (
                name,
                f"{found['rod']['mass_kg']:.2f}",
                *(with_bar(big, figure, form) for figure, form in (("h_min", ".2f"), ("p_max", ".0f"))),
                f"{big['p_max_deg']:.0f}",
                f"{big['flow_l_min']:.2f}",
                f"{big['temperature_C']:.0f}",
            )
        )
    yield from table(
        (
            "big end of leon-2001, 6000 rpm",
            "rod, kg:",
            "thinnest film, µm:",
            "highest pressure, MPa:",
            "at, °:",
            "oil, l/min:",
            "film, °C:",
        ),
        rows,
    )


def with_bar(found: dict[str, Any], figure: str, form: str) -> str:
    """A figure of a film with its error bar in per cent."""
    value = found["h_min_um" if figure == "h_min" else "p_max_MPa"]
    return f"{value:{form}} ± {found[figure + '_error_percent']:.0f} %"


def bending() -> Iterator[str]:
    """Where does the rod bend most?"""
    study = load_study("leon-2001")
    found = analyse(study, rpm=6000, size=10, **COARSE)
    case, rows = found.cases["bending"], []
    bar = cut(case.mesh, study.rod.dimensions.length / 2).section().area
    for x in (46, 60, 74, 88, 100, 114):
        section = cut(case.mesh, x)
        sigma, height = section.at_corners(case.stress[:, [0]])[..., 0], section.places[..., 0]
        products = height.sum(axis=1) * sigma.sum(axis=1) + (height * sigma).sum(axis=1)
        moment = float(section.areas @ products) / 12
        fibre = moment * np.abs(height).max() / section.section().inertia_z
        whip, couples = by_hand(study, case.load, bar, x)
        columns = (x / study.rod.dimensions.length, whip / 1000, (whip + couples) / 1000, moment / 1000)
        rows.append(
            (f"{x}", *(f"{value:.{2 - (i > 0)}f}" for i, value in enumerate(columns)), f"{fibre:.0f}")
        )
    yield from table(
        (
            f"x, mm, at {math.degrees(case.load.crank_angle.item()):.0f}°:",
            "of the length:",
            "uniform bar, N·m:",
            "and both rings, N·m:",
            "computed, N·m:",
            "± at the outer fibre, MPa:",
        ),
        rows,
    )


def by_hand(study: Study, instant: Instants, area: float, x: float) -> tuple[float, float]:
    """Moments at x, mm, in N·mm: of a uniform bar on two pins, and of the rings that turn with it.

    The bar, of an area in mm², has the load ρ A ω² r, which falls to nothing at the piston pin. A ring on a
    pin without friction gets its angular acceleration from the shank alone, by a couple I α.
    """
    rod, density = study.rod.dimensions, 7.85e-9
    omega, radius = 2 * math.pi * 6000 / 60, study.engine.stroke_mm / 2
    far, share = rod.length - x, x / rod.length
    whip = density * area * omega**2 * radius * far * (rod.length**2 - far**2) / (6 * rod.length)

    def couple(bore: float, ring: float, width: float) -> float:
        inner, outer = bore / 2, bore / 2 + ring
        inertia = density * width * math.pi * (outer**4 - inner**4) / 2
        return inertia * abs(float(instant.motions[..., 3].item()))

    big = couple(rod.big_end_bore, rod.big_end_ring, rod.big_end_width)
    small = couple(rod.small_end_bore, rod.small_end_ring, rod.small_end_width)
    return whip, small * share - big * (1 - share)


def steel() -> Iterator[str]:
    """Does steel that is twice as strong last at a higher load?"""
    rows = []
    for finish in ("as-forged", "ground"):
        for strength in (700, 1000, 1400):
            study = load_study("leon-2001").with_(
                material={
                    "preset": None,
                    "E_GPa": 207,
                    "nu": 0.3,
                    "density_kg_m3": 7850,
                    "yield_MPa": 0.8 * strength,
                    "ultimate_MPa": strength,
                    "surface": finish,
                    "bore_surface": finish,
                    "face_surface": finish,
                }
            )
            cycle = analyse(study, rpm=6000, size=12, cycle=True, **COARSE).as_dict()["envelope"]
            shank = cycle["endurance"]["rod"]["regions"]["rest"]
            rows.append(
                (
                    finish,
                    f"{strength}",
                    f"{shank['endurance_MPa']:.0f}",
                    f"{cycle['fatigue']['support_factor']:.3f}",
                    f"{cycle['min_safety_factor']:.2f}",
                    f"{cycle['min_fatigue_safety_factor']:.3f}",
                )
            )
    yield from table(
        (
            "surface",
            "ultimate strength, MPa:",
            "endurance limit of the part, MPa:",
            "support:",
            "factor against yielding:",
            "fatigue factor:",
        ),
        rows,
    )


def preload() -> Iterator[str]:
    """Does more preload help the bolts, at a speed that opens the joint and at one that does not?"""
    rows = []
    for rpm in (6000, 2000):
        for force in (15, 25, 33, 42):
            study = load_study("leon-2001-bolted").with_(assembly={"bolt_preload_kN": float(force)})
            bolts = analyse(study, rpm=rpm, size=14, **COARSE).as_dict()["assembly"]["bolts"]
            rows.append(
                (
                    f"{rpm}",
                    f"{force}",
                    f"{bolts['max_force_N'] / 1000:.1f}",
                    f"{bolts['amplitude_N'] / 1000:.2f}",
                    f"{bolts['bending_alternating_stress_MPa']:.1f}",
                    f"{bolts['yield_safety_factor']:.2f}",
                    f"{bolts['bending_fatigue_safety_factor']:.2f}",
                )
            )
    yield from table(
        (
            "rpm:",
            "preload, kN:",
            "largest force, kN:",
            "amplitude, kN:",
            "with bending, MPa:",
            "factor against yielding:",
            "fatigue factor:",
        ),
        rows,
    )


def instants() -> Iterator[str]:
    """Are the instants that make fatigue among the peaks of the forces?"""
    rows = []
    for name, rpm in (("leon-2001", 6000), ("molina-2024", 9000)):
        study = load_study(name)
        rows += [(f"{name}, {rpm} rpm", *row) for row in spots(study, rpm)]
    yield from table(
        (
            "rod",
            "place",
            "largest stress, MPa, at °",
            "smallest stress, MPa, at °",
            "amplitude, MPa:",
            "of pull and push alone, MPa:",
            "of all four peaks, MPa:",
        ),
        rows,
    )


def spots(study: Study, rpm: float) -> Iterator[tuple[str, ...]]:
    """The most stressed places, one for each pair of mirror images, over the cycle and at the peak cases."""
    found = analyse(study, rpm=rpm, size=12, cycle=True, **COARSE).as_dict()
    # The case without inertia is not an instant of this speed.
    cases = {name: load["crank_deg"] for name, load in found["loads"].items() if name != "gas"}
    seen: set[tuple[float, float]] = set()
    for spot in found["envelope"]["spots"]:
        x, y, _ = spot["at_mm"]
        place = (round(x, 1), round(abs(y), 1))
        if place in seen:
            continue
        seen.add(place)
        history = np.array(spot["history_MPa"])
        at_cases = {case: np.interp(at, np.arange(len(history)), history) for case, at in cases.items()}
        yield (
            f"{spot['where']}, x = {x:.0f} mm",
            f"{history.max():.0f}, {history.argmax()}",
            f"{history.min():.0f}, {history.argmin()}",
            f"{np.ptp(history) / 2:.0f}",
            f"{(at_cases['tension'] - at_cases['compression']) / 2:.0f}",
            f"{np.ptp(list(at_cases.values())) / 2:.0f}",
        )


QUESTIONS: dict[str, Callable[[], Iterator[str]]] = {
    "film": film,
    "bending": bending,
    "steel": steel,
    "preload": preload,
    "instants": instants,
}


def main() -> None:
    """Answer all questions, or those that are named."""
    parser = reporting(__doc__)
    parser.add_argument("--only", nargs="*", choices=QUESTIONS, default=list(QUESTIONS))
    asked = parser.parse_args()
    lines = ["# Questions whose first answer is wrong", "", f"`{command()}`", ""]
    for name in asked.only:
        lines += [f"**{QUESTIONS[name].__doc__}**", "", f"<!-- {name} -->", "", *QUESTIONS[name]()]
        lines += ["", f"<!-- end of {name} -->", ""]
    publish("\n".join([*lines[:-1], ""]), asked.report)


if __name__ == "__main__":
    main()
