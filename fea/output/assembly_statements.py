"""Statements on the parts around the rod: bolts, joint and fits, linings, oil films and pins."""

from collections.abc import Iterator
from math import inf

from fea.analysis.summary_figures import AssemblyFigures, FitFigures, OnsetFigures, Summary
from fea.base.units import KN, UM
from fea.output.units import bar, factor, number, quantity
from loads.instants import ASSEMBLY


def opening_text(gap: float) -> str:
    """Say by how much a joint opens, µm."""
    return f"opens by up to {quantity(gap, '.0f', 'µm')}" if gap >= 0.5 else "opens by less than 1 µm"


def bolts_and_joint(assembly: AssemblyFigures) -> Iterator[str]:
    """Yield a line on the bolts and one on the joint."""
    bolts, joint = assembly.bolts, assembly.joint
    where = bolts.max_case or f"{number(bolts.max_crank_deg, '.0f')}°"
    force = quantity(bolts.max_force_N / KN, ".1f", "kN")
    bending = quantity(bolts.max_bending_MPa, ".0f", "MPa")
    factors = f"yield {factor(bolts.yield_safety_factor)}"
    if (fatigue := bolts.bending_fatigue_safety_factor) is not None:
        factors += f", fatigue {factor(fatigue)}"
    yield f"Bolts, {bolts.thread}: {force} ({where}), bending {bending}; {factors}."
    widest = max(joint.by_case, key=lambda case: joint.by_case[case].opening_um)
    gap = joint.by_case[widest].opening_um
    parts = [f"{opening_text(gap)} ({widest})" if gap > 0 else "stays closed"]
    if joint.opens is not None and (load := joint.opens.load_factor) is not None:
        opening = f"{load:.2g} times the load of {joint.opens.case}"
        since = f", at the bore from {opening} on" if load > 1 else f", from {opening} on"
        parts[0] += since if gap > 0 else f" up to {opening}"
    reserves = {name: one.slip_reserve for name, one in joint.by_case.items() if one.slip_reserve is not None}
    if reserves:
        least = min(reserves, key=lambda name: reserves[name])
        parts.append(f"slip safety {number(reserves[least], '.3g')} ({least})")
    yield f"Joint: {', '.join(parts)}."


def fits(assembly: AssemblyFigures) -> Iterator[str]:
    """Yield how the bolts were tightened, where they say so, and a line on the fits."""
    if assembly.bolts.tightened is not None:
        yield f"Bolts tightened to {assembly.bolts.tightened}."
    each = [_fit(name, fit) for name, fit in assembly.fits.items()]
    if each:
        yield f"Fits, micro-slip: {'; '.join(each)}."


def _fit(name: str, fit: FitFigures) -> str:
    faces = fit.by_case.values()
    pressures = [face.mean_pressure_MPa for face in faces]
    slips, opens = max(face.slipping_percent for face in faces), max(face.open_percent for face in faces)
    lifted = f", lifts {opens:.0f} %" if opens >= 1 else ""
    low, high = number(min(pressures), ".0f", "MPa"), quantity(max(pressures), ".0f", "MPa")
    return f"{name} {low}–{high}, {slips:.0f} %{lifted}"


MICRO_SLIP = (
    "Micro-slip: where friction is at its limit and the faces shift by micrometres. The parts stay in place "
    "as long as the slip safety, friction's limit over the shear force of the whole joint, is above 1."
)


def assembly_lines(assembly: AssemblyFigures) -> Iterator[str]:
    """Yield all on bolts, joint and fits: when these open, too, and how round the bores stay."""
    yield from bolts_and_joint(assembly)
    yield from fits(assembly)
    yield from _openings(assembly)
    for bore, cases in assembly.ovality.items():
        assembled = cases[ASSEMBLY].ovality_mm / UM
        worst = max(cases, key=lambda case: cases[case].ovality_mm)
        most = quantity(cases[worst].ovality_mm / UM, ".0f", "µm")
        warm = f", {quantity(assembled, '.0f', 'µm')} when warm" if assembled >= 1 else ""
        yield f"Ovality, {bore.replace('_', ' ')}: {most} ({worst}), round as made{warm}."
    yield MICRO_SLIP


def _openings(assembly: AssemblyFigures) -> Iterator[str]:
    joint, cycle = assembly.joint, assembly.joint.cycle
    onsets = {"opens at the bore": joint.opens, "comes apart": joint.separates}
    begins = [f"{what} {_when(onset)}" for what, onset in onsets.items() if onset is not None]
    if begins:
        yield f"Joint: {'; '.join(begins)}."
    if cycle is not None:
        least = quantity(cycle.min_clamp_force_N / KN, ".1f", "kN")
        gap = quantity(cycle.max_opening_um, ".0f", "µm")
        yield (
            f"Joint over the cycle: clamped by at least {least} ({cycle.min_clamp_crank_deg:.0f}°), gap at "
            f"most {gap} ({cycle.max_opening_crank_deg:.0f}°), open at the bore in "
            f"{cycle.open_percent:.0f} % of it."
        )
    for name, fit in assembly.fits.items():
        if fit.lifts_off is not None:
            verb = "lift" if name.endswith("s") else "lifts"
            yield f"{name.capitalize()}: {verb} off the seat {_when(fit.lifts_off)}."


def _when(onset: OnsetFigures) -> str:
    if onset.load_factor is None:
        return f"beyond {onset.largest_factor:g} times the load of {onset.case}"
    if onset.load_factor == 0:
        return "without any load"
    return f"at {onset.load_factor:.2g} times the load of {onset.case}"


def film_lines(summary: Summary) -> Iterator[str]:
    """Yield a line per bearing whose oil film was computed."""
    for end, film in (summary.film or {}).items():
        thinnest = f"{quantity(film.h_min_um, '.2f', 'µm')} ± {bar(film.h_min_error_percent)} %"
        rough = "" if film.lambda_min is None else f" ({film.lambda_min:.1f} × roughness)"
        highest = f"{quantity(film.p_max_MPa, '.0f', 'MPa')} ± {bar(film.p_max_error_percent)} %"
        friction = f"{film.power_W:.0f} W ± {bar(film.power_error_percent)} %"
        oil = f"{film.flow_l_min:.2g} l/min ± {bar(film.flow_error_percent)} %"
        hot = "" if film.temperature_C is None else f" at {quantity(film.temperature_C, '.0f', '°C')}"
        carried = film.asperity_percent
        asperities = "" if carried < 1 else f" Asperities carry up to {carried:.0f} %."
        lining = "" if film.lining_factor is None else f" Lining: factor {factor(film.lining_factor)}."
        yield (
            f"Oil film, {end.replace('_', ' ')}: {film.verdict}, min. {thinnest} at {film.h_min_deg:.0f}°"
            f"{rough}, max. {highest} at {film.p_max_deg:.0f}°; friction {friction}, oil {oil}{hot}."
            f"{asperities}{lining}"
        )


def linings(summary: Summary, below: float = inf) -> Iterator[str]:
    """Yield the factors of bushing and shells, which the answer leaves out, as far as they are `below`."""
    worst: dict[str, tuple[float, float, str]] = {}
    for case, result in summary.results.items():
        for part, lining in (result.linings or {}).items():
            name, one = part.split()[-1], (lining.safety_factor, lining.specific_load_MPa, case)
            worst[name] = min(worst.get(name, one), one)
    low = [
        f"{name} {factor(least)} ({case}; {quantity(load, '.0f', 'MPa')} over its bore)"
        for name, (least, load, case) in worst.items()
        if least < below
    ]
    meaning = "A lining beds in where it yields, which does not end the rod"
    if low:
        yield f"Linings, against yielding: {'; '.join(low)}. {meaning}."


def contact(summary: Summary) -> Iterator[str]:
    """Yield the largest pressure on each bore that touches its pin."""
    largest: dict[str, tuple[float, str]] = {}
    for case, result in summary.results.items():
        for bore, touched in (result.contact or {}).items():
            largest[bore] = max(largest.get(bore, (0.0, "")), (touched.max_pressure_MPa, case))
    each = [
        f"{bore.removesuffix('_bore').replace('_', ' ')} {quantity(pressure, '.0f', 'MPa')} ({case})"
        for bore, (pressure, case) in largest.items()
    ]
    if each:
        yield f"Contact pressure of the pins: {', '.join(each)}."
