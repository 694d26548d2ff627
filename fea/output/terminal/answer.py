"""The answer of a run in a few statements, the gravest first, each of a line or two."""

from collections.abc import Iterable, Iterator
from math import inf, sqrt

from fea.analysis.figures import (
    AssemblyFigures,
    BucklingFigures,
    CaseFigures,
    FitFigures,
    LifeFigures,
    OnsetFigures,
    PlaceFigures,
    SharpEdgeFigures,
    Summary,
    SurfaceFigures,
)
from fea.base.choices import Finish
from fea.base.note import CANNOT_GOVERN, HEADING, SINGULAR, UNITS, Note, NoteKind
from fea.base.units import KN
from fea.judge.case_error import SHARP_EDGE
from fea.judge.safety_factor import Answer
from fea.judge.verdict import Verdict
from fea.output.terminal.run_lines import SIDES, factor, fillet, film_lines, hours_text, number, place
from loads.instants import ASSEMBLY

# Multiple of the required safety factor up to which buckling is worth a line where it does not govern.
_NEAR = 1.5
# Load cases whose names do not say it in a sentence.
_CASES = {"given": "under the given forces", "assembly": "after assembly"}
# Keys of the pins' fit in a bore.
_FITS = {
    "small-end bore": ("contact.small_end_clearance_mm", "contact.small_end_relief_mm"),
    "big-end bore": ("contact.big_end_clearance_mm",),
}
_FITS |= {"bore of the bushing": _FITS["small-end bore"], "bore of the bearing shells": _FITS["big-end bore"]}
# Beyond this multiple of the yield strength another material is no remedy.
_MOST_STRENGTH = 2.0
# What makes the stress at a singular place finite.
_REMEDIES = {
    "small-end bore's edge": "contact.small_end_relief_mm",
    "big-end bore's edge": "of a clamp or an elastic pin",
    SHARP_EDGE: "a fillet makes it finite",
}


def statements(summary: Summary) -> Iterator[str]:
    """Yield the statements by consequence: failed checks, what governs, doubts, remedies, the rest."""
    yield from failed_checks(summary)
    yield from basis(summary)
    yield governs(summary)
    if summary.assembly is not None:
        yield from bolts_and_joint(summary.assembly)
    yield from film_lines(summary)
    yield from of_kind(summary.notes, NoteKind.DOUBT)
    yield from not_converged(summary)
    yield from linings(summary, summary.survival.required_safety_factor)
    yield from singular(summary)
    yield from life(summary.life)
    yield from levers(summary)
    yield from cycle(summary)
    yield from _edges(summary)
    if summary.assembly is not None:
        yield from fits(summary.assembly)
    least = summary.buckling.min_safety_factor
    near = least is not None and least < _NEAR * summary.survival.required_safety_factor
    if near or summary.buckling.modes:
        yield from buckling(summary.buckling)
    yield from (_sentence(note) for note in summary.notes if note.topic == CANNOT_GOVERN)
    yield from _contact(summary)
    yield from of_kind(summary.notes, NoteKind.WARNING)


def failed_checks(summary: Summary) -> list[str]:
    """Return the checks that failed, if any did."""
    failed = [
        f"{name} ({number(check.value, '.3g')}, limit {check.limit:.3g})"
        for name, check in summary.checks.items()
        if not check.passed
    ]
    return [f"NOT TO BE TRUSTED: failed checks: {', '.join(failed)}."] if failed else []


def basis(summary: Summary) -> list[str]:
    """Return for which operation the rod survives, and which multiple of its loads ends that."""
    found = summary.survival
    if found.stands_on is None or found.ends_at_load is None:
        return []
    more, parts = f"{found.ends_at_load:.2f}", summary.assembly is not None
    ends = f"it {'holds at least until' if parts else 'ends where'} all loads are {more} times as large"
    if summary.rpm:
        rpm = 10 * round(sqrt(found.ends_at_load) * summary.rpm / 10)
        ends += f", as at {rpm} rpm with {more} times the pressure"
    return [f"This stands on {found.stands_on}; {ends}."]


def not_converged(summary: Summary) -> list[str]:
    """Return the load cases whose peaks finer elements would change."""
    cases = [name for name, case in summary.results.items() if case.verdict == Verdict.NOT_CONVERGED]
    said = "all cases" if len(cases) == len(summary.results) > 2 else ", ".join(cases)
    fixed = summary.passes or summary.model.mesh_from_file
    remedy = "" if fixed else " (try --tolerance 5 or less)"
    return [f"Not converged: {said}{remedy}"] if cases else []


def singular(summary: Summary) -> list[str]:
    """Return where the exact stress is infinite, with the largest value that the mesh gives there.

    Sharp edges that are judged are left out.
    """
    cases = [
        case
        for case in summary.results.values()
        if case.singular_where is not None and not (case.sharp_edges and case.singular_where == SHARP_EDGE)
    ]
    if not cases:
        return []
    worst = max(cases, key=lambda case: case.singular_max_von_mises_MPa or 0.0)
    where, stress = worst.singular_where or "", number(worst.singular_max_von_mises_MPa, ".0f")
    remedy = f" ({_REMEDIES[where]})" if where in _REMEDIES else ""
    return [f"Singular, left out: {where}, {stress} MPa{remedy}"]


def governs(summary: Summary) -> str:
    """Return the mode of failure that decides, with its place."""
    found = summary.survival
    load = None if found.case is None else summary.loads.get(found.case)
    degrees = None if load is None else load.crank_deg
    angle = "" if degrees is None else f" at {degrees:.0f}°"
    case = "" if found.case is None else f", {_CASES.get(found.case, found.case)}{angle}"
    edge = _edge(summary)
    if edge is not None:
        return f"Governs: structural stress at sharp edge {edge.name}{case}; {fillet(edge)}."
    if found.mode == "fatigue" and summary.envelope is not None and summary.envelope.fatigue is not None:
        return f"Governs: fatigue, {_spot(summary.envelope.fatigue)}."
    if found.mode != "yielding":
        bound = f" between the load cases, {found.fatigue_where}" if found.mode == "fatigue" else ""
        return f"Governs: {found.mode}{bound}{case}."
    if summary.governing is not None:
        return f"Governs: yielding, {_weakest(summary.governing)}{case}."
    envelope = summary.envelope
    if envelope is None:
        return "Governs: yielding."
    where = envelope.where or f"({place(envelope.at_mm)}) mm"
    return f"Governs: yielding, {where}, at {number(envelope.crank_deg, '.0f')}° of the cycle."


def _weakest(case: CaseFigures) -> str:
    found = case.weakest
    if found is None:
        return f"({place(case.at_mm)}) mm"
    part = "" if found.part in {"rod", "cap"} else f" ({found.part})"
    at = "" if found.at_mm == case.at_mm else f" at ({place(found.at_mm)}) mm"
    return f"{found.where}{part}{at}"


def _spot(spot: PlaceFigures) -> str:
    at = f"({place(spot.at_mm)}) mm"
    return at if spot.where is None else f"{spot.where}, {at}"


def _edge(summary: Summary) -> SharpEdgeFigures | None:
    place, case = summary.survival.place, summary.governing
    edges = () if case is None else case.sharp_edges or ()
    return next((edge for edge in edges if place == f"edge {edge.name}"), None)


def levers(summary: Summary) -> Iterator[str]:
    """Yield what would change the answer, as far as it follows from the figures without a further run."""
    found, notes = summary.survival, summary.notes
    if any(note.kind is NoteKind.ASSUMPTION and note.topic == "material" for note in notes):
        yield "The material is assumed: [material] or --material."
    weakest = None if summary.governing is None else summary.governing.weakest
    if found.mode == "yielding" and not found.place and weakest and found.answer != Answer.SURVIVES:
        needed = weakest.yield_MPa * found.required_safety_factor / found.assured_safety_factor
        if needed < _MOST_STRENGTH * weakest.yield_MPa:
            have = f"now {weakest.yield_MPa:.0f} MPa"
            yield f"Against yielding, a yield strength of {needed:.0f} MPa there would suffice ({have})."
    if found.mode == "fatigue":
        yield from _endurance(summary)
    where = weakest.where if found.mode == "yielding" and weakest else ""
    spot = None if summary.envelope is None else summary.envelope.fatigue
    where = (spot.where or "") if found.mode == "fatigue" and spot else where
    keys = [key for key in _FITS.get(where, ()) if any(f"({key})" in note.text for note in notes)]
    if keys:
        yield f"The fit of the pin there counts, and it is assumed: {', '.join(keys)}."


def _endurance(summary: Summary) -> Iterator[str]:
    envelope = summary.envelope
    spot = None if envelope is None else envelope.fatigue
    if envelope is None or spot is None or spot.endurance_MPa is None:
        return
    limits = (envelope.endurance or {}).values()
    estimated = ", estimated" if any(limit.estimated for limit in limits) else ""
    regions = (limit.regions.get(spot.surface_region or "") for limit in limits)
    surfaces = [skin for skin in regions if skin is not None]
    finish = f" ({_finish(surfaces[0])})" if surfaces else ""
    shown = number(spot.endurance_MPa, ".4g")
    cycles = next((limit.cycles for limit in limits if limit.cycles is not None), None)
    what = "Endurance limit" if cycles is None else f"No endurance limit; strength at {cycles:.3g} cycles"
    yield f"{what} there: {shown} MPa{estimated}{finish}: endurance_MPa, surface"


def _finish(surface: SurfaceFigures) -> str:
    """Say what the surface is taken for, with its factor, and what else an assumed one may be."""
    made = "shot-peened forging" if surface.finish == Finish.SHOT_PEENED else surface.finish
    said = f"{made}, factor {surface.surface_factor:.3g}"
    if not surface.assumed:
        return said
    other = f'; of a machined and peened bar surface = "{Finish.MACHINED_PEENED}"'
    return f"{said}, assumed{other if surface.finish == Finish.SHOT_PEENED else ''}"


def life(found: LifeFigures | None) -> list[str]:
    """Return the hours of a duty, with their band and the speed that takes most of them."""
    if found is None:
        return []
    low, high = (hours_text(hours) for hours in found.band_hours)
    band = "" if low == high else f" ({low} to {high})"
    most = max(found.duty, key=lambda entry: entry.damage_percent or 0.0)
    damage = f"; {number(most.damage_percent, '.3g')} % of the damage at {most.rpm:g} rpm"
    return [f"Life over the duty: {hours_text(found.hours)}{band}{'' if found.endless else damage}."]


def cycle(summary: Summary) -> list[str]:
    """Return the least factors over the whole cycle."""
    found = summary.envelope
    if found is None:
        return []
    said = f"Cycle: yielding {factor(found.min_safety_factor)} at {number(found.crank_deg, '.0f')}°"
    if found.fatigue is None:
        return [f"{said}; fatigue is not judged."]
    stress = f"mean {found.fatigue.mean_MPa:.0f} MPa, amplitude {found.fatigue.amplitude_MPa:.0f} MPa"
    fatigue = factor(found.fatigue.fatigue_safety_factor)
    return [f"{said}; fatigue {fatigue} ({found.fatigue_criterion}), {stress}."]


def _edges(summary: Summary) -> Iterator[str]:
    edges = [edge for case in summary.results.values() for edge in case.sharp_edges or ()]
    if edges and _edge(summary) is None:
        worst, names = min(edges, key=lambda edge: edge.safety_factor), {edge.name for edge in edges}
        which = f"Sharp edge {worst.name}" + (f", the worst of {len(names)}" if len(names) > 1 else "")
        yield f"{which}: structural stress with a factor of {factor(worst.safety_factor)}; {fillet(worst)}."


def assembly(found: AssemblyFigures) -> Iterator[str]:
    """Yield a line on the bolts, one on the joint, one on their tightening and one on the fits."""
    yield from bolts_and_joint(found)
    yield from fits(found)


def bolts_and_joint(found: AssemblyFigures) -> Iterator[str]:
    """Yield a line on the bolts and one on the joint."""
    bolts, joint = found.bolts, found.joint
    where = bolts.max_case or f"{number(bolts.max_crank_deg, '.0f')}°"
    fatigue = bolts.bending_fatigue_safety_factor
    against = "" if fatigue is None else f", fatigue {factor(fatigue)}"
    yield (
        f"Bolts, {bolts.thread}: {bolts.max_force_N / KN:.1f} kN ({where}), bending "
        f"{bolts.max_bending_MPa:.0f} MPa; yield {factor(bolts.yield_safety_factor)}{against}."
    )
    widest = max(joint.by_case, key=lambda case: joint.by_case[case].opening_um)
    reserves = {name: one.slip_reserve for name, one in joint.by_case.items() if one.slip_reserve is not None}
    gap = joint.by_case[widest].opening_um
    said = [f"opens by up to {gap:.0f} µm ({widest})" if gap > 0 else "stays closed"]
    if joint.opens is not None and joint.opens.load_factor is not None:
        opening = f"{joint.opens.load_factor:.2g} times the load of {joint.opens.case}"
        said[0] += f", from {opening} on" if gap > 0 else f" up to {opening}"
    if reserves:
        least = min(reserves, key=lambda name: reserves[name])
        said.append(f"slip safety {number(reserves[least], '.3g')} ({least})")
    yield f"Joint: {', '.join(said)}."


def fits(found: AssemblyFigures) -> Iterator[str]:
    """Yield how the bolts were tightened, where they say so, and a line on the fits."""
    if found.bolts.tightened is not None:
        yield f"Bolts tightened to {found.bolts.tightened}."
    said = [_fit(name, fit) for name, fit in found.fits.items()]
    if said:
        yield f"Fits, micro-slip: {'; '.join(said)}."


def _fit(name: str, fit: FitFigures) -> str:
    faces = fit.by_case.values()
    pressures = [face.mean_pressure_MPa for face in faces]
    slips, opens = max(face.slipping_percent for face in faces), max(face.open_percent for face in faces)
    lifted = f", lifts {opens:.0f} %" if opens >= 1 else ""
    return f"{name} {min(pressures):.0f}–{max(pressures):.0f} MPa, {slips:.0f} %{lifted}"


def linings(summary: Summary, below: float = inf) -> list[str]:
    """Return the factors of bushing and shells, which the answer leaves out, as far as they are `below`."""
    worst: dict[str, tuple[float, float, str]] = {}
    for case, result in summary.results.items():
        for part, found in (result.linings or {}).items():
            name, one = part.split()[-1], (found.safety_factor, found.specific_load_MPa, case)
            worst[name] = min(worst.get(name, one), one)
    said = [
        f"{name} {factor(f)} ({case}; {load:.0f} MPa over its bore)"
        for name, (f, load, case) in worst.items()
        if f < below
    ]
    meaning = "A lining beds in where it yields, which does not end the rod"
    return [f"Linings, against yielding: {'; '.join(said)}. {meaning}."] if said else []


def buckling(found: BucklingFigures) -> list[str]:
    """Return the least factor of the column formulas, and that of the modes of the solid."""
    column = found.column
    factors = {side: plane.safety_factor for side, plane in column.planes.items()}
    known = {side: value for side, value in factors.items() if value is not None}
    if column.case is None or not known:
        return [] if found.modes is None else ["No load case compresses the rod, so it cannot buckle."]
    side = min(known, key=lambda name: known[name])
    said = f"{factor(known[side])} {SIDES[side]}, under {column.force_N / KN:.1f} kN ({column.case})"
    modes = "" if found.min_mode_factor is None else f"; modes of the solid {factor(found.min_mode_factor)}"
    return [f"Buckling: {said}{modes}."]


def _contact(summary: Summary) -> list[str]:
    hardest: dict[str, tuple[float, str]] = {}
    for case, result in summary.results.items():
        for bore, touch in (result.contact or {}).items():
            hardest[bore] = max(hardest.get(bore, (0.0, "")), (touch.max_pressure_MPa, case))
    said = [
        f"{bore.removesuffix('_bore').replace('_', ' ')} {pressure:.0f} MPa ({case})"
        for bore, (pressure, case) in hardest.items()
    ]
    return [f"Contact pressure of the pins: {', '.join(said)}."] if said else []


def of_kind(notes: Iterable[Note], kind: NoteKind) -> list[str]:
    """Return the notes of a kind as sentences, without those that stand elsewhere."""
    elsewhere = {SINGULAR, UNITS, *HEADING}
    return [_sentence(note) for note in notes if note.kind is kind and note.topic not in elsewhere]


def _sentence(note: Note) -> str:
    text = str(note)
    return f"{text[0].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"


MICRO_SLIP = (
    "Micro-slip: where friction is at its limit and the faces shift by micrometres. The parts stay in place "
    "as long as the slip safety, friction's limit over the shear force of the whole joint, is above 1."
)


def assembly_lines(found: AssemblyFigures) -> Iterator[str]:
    """Yield what `assembly` does, when joint and fits open, and how round the bores stay."""
    yield from assembly(found)
    yield from _joint(found)
    for name, fit in found.fits.items():
        if fit.lifts_off is not None:
            verb = "lift" if name.endswith("s") else "lifts"
            yield f"{name.capitalize()}: {verb} off the seat {_when(fit.lifts_off)}."
    for bore, cases in found.ovality.items():
        assembled = cases[ASSEMBLY].ovality_mm
        worst = max(cases, key=lambda case: cases[case].ovality_mm)
        most = cases[worst].ovality_mm
        warm = f", {1e3 * assembled:.0f} µm when warm" if 1e3 * assembled >= 1 else ""
        yield f"Ovality, {bore.replace('_', ' ')}: {1e3 * most:.0f} µm ({worst}), round as made{warm}."
    yield MICRO_SLIP


def _joint(found: AssemblyFigures) -> Iterator[str]:
    joint = found.joint
    onsets = {"opens at the bore": joint.opens, "comes apart": joint.separates}
    said = [f"{what} {_when(onset)}" for what, onset in onsets.items() if onset is not None]
    if said:
        yield f"Joint: {'; '.join(said)}."
    if joint.cycle is not None:
        cycle = joint.cycle
        yield (
            f"Joint over the cycle: clamped by at least {cycle.min_clamp_force_N / KN:.1f} kN "
            f"({cycle.min_clamp_crank_deg:.0f}°), gap at most {cycle.max_opening_um:.0f} µm "
            f"({cycle.max_opening_crank_deg:.0f}°), open at the bore in {cycle.open_percent:.0f} % of it."
        )


def _when(onset: OnsetFigures) -> str:
    if onset.load_factor is None:
        return f"beyond {onset.largest_factor:g} times the load of {onset.case}"
    if onset.load_factor == 0:
        return "without any load"
    return f"at {onset.load_factor:.2g} times the load of {onset.case}"
