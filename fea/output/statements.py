"""The answer of a run in sentences, the gravest first: one list for the terminal and the report."""

from collections.abc import Callable, Iterable, Iterator
from math import sqrt
from typing import NamedTuple

from fea.analysis.figures import CaseFigures, SharpEdgeFigures
from fea.analysis.life_figures import PlaceFigures, SurfaceFigures
from fea.analysis.summary_figures import AssemblyFigures, Summary
from fea.analysis.survival import LASTING_FLOW
from fea.base.choices import Finish
from fea.base.note import CANNOT_GOVERN, HEADING, SINGULAR, UNITS, Note, NoteKind
from fea.base.units import KN, with_power
from fea.judge.case_error import SHARP_EDGE
from fea.judge.safety_factor import SurvivalAnswer
from fea.judge.verdict import ConvergenceVerdict
from fea.output.assembly_statements import (
    assembly_lines,
    bolts_and_joint,
    contact,
    film_lines,
    fits,
    linings,
)
from fea.output.defect_answer import defect_sizes, given_flaw
from fea.output.flow_statements import flow, flow_in_full, overload, overload_in_full
from fea.output.fretting import fretting, fretting_in_full
from fea.output.life_statements import fatigue_test, life, log_lines
from fea.output.tables import SIDES
from fea.output.units import bar, factor, number, place, quantity

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


def failed_checks(summary: Summary) -> Iterator[str]:
    """Yield the checks that failed, if any did."""
    failed = [
        f"{name} ({number(check.value, '.3g')}, limit {check.limit:.3g})"
        for name, check in summary.checks.items()
        if not check.passed
    ]
    if failed:
        yield f"NOT TO BE TRUSTED: failed checks: {', '.join(failed)}."


def basis(summary: Summary) -> Iterator[str]:
    """Yield for which operation the rod survives, and which multiple of its loads ends that."""
    survival = summary.survival
    if survival.stands_on is None or survival.ends_at_load is None:
        return
    more = f"{survival.ends_at_load:.2f}"
    until = "holds at least until" if summary.assembly or survival.mode == LASTING_FLOW else "ends where"
    ends = f"it {until} all loads are {more} times as large"
    if summary.rpm:
        rpm = 10 * round(sqrt(survival.ends_at_load) * summary.rpm / 10)
        ends += f", as at {rpm} rpm with {more} times the pressure"
    yield f"This stands on {survival.stands_on}; {ends}."


def governs(summary: Summary) -> Iterator[str]:
    """Yield the mode of failure that decides, with its place."""
    survival, envelope = summary.survival, summary.envelope
    load = summary.loads.get(survival.case or "")
    angle = "" if load is None or load.crank_deg is None else f" at {load.crank_deg:.0f}°"
    case = "" if survival.case is None else f", {_CASES.get(survival.case, survival.case)}{angle}"
    edge = _governing_edge(summary)
    if edge is not None:
        mode = f"structural stress at sharp edge {edge.name}{case}; {fillet(edge)}"
    elif survival.mode == "fatigue" and survival.safety_factor.place and not survival.fatigue_at_most:
        mode = f"fatigue, {survival.safety_factor.place}"
    elif survival.mode == "fatigue" and envelope is not None and envelope.fatigue is not None:
        mode = f"fatigue, {_spot(envelope.fatigue)}"
    elif survival.mode == "fatigue":
        mode = f"fatigue between the load cases, {survival.fatigue_where}{case}"
    elif survival.mode != "yielding":
        mode = f"{survival.mode}{case}"
    elif summary.governing is not None:
        mode = f"yielding, {_weakest(summary.governing)}{case}"
    elif envelope is not None:
        where = envelope.where or place(envelope.at_mm)
        mode = f"yielding, {where}, at {number(envelope.crank_deg, '.0f')}° of the cycle"
    else:
        mode = "yielding"
    yield f"Governs: {mode}."


def _weakest(case: CaseFigures) -> str:
    weakest = case.weakest
    if weakest is None:
        return place(case.at_mm)
    part = "" if weakest.part in {"rod", "cap"} else f" ({weakest.part})"
    at = "" if weakest.at_mm == case.at_mm else f" at {place(weakest.at_mm)}"
    return f"{weakest.where}{part}{at}"


def _spot(spot: PlaceFigures) -> str:
    at = place(spot.at_mm)
    return at if spot.where is None else f"{spot.where}, {at}"


def _governing_edge(summary: Summary) -> SharpEdgeFigures | None:
    edges = () if summary.governing is None else summary.governing.sharp_edges or ()
    return next((edge for edge in edges if summary.survival.place == f"edge {edge.name}"), None)


def head_gap(summary: Summary) -> Iterator[str]:
    """Yield how far the piston comes nearer to the head than at rest."""
    if (gap := summary.head_clearance) is not None:
        sums = gap.cold_mm, gap.hot_iron_block_mm, gap.hot_aluminium_block_mm
        cold, iron, aluminium = (quantity(value, ".2f", "mm") for value in sums)
        yield (
            f"The piston comes {cold} nearer to the head than at rest in the cold engine; in the warm one "
            f"{iron} with an iron block, {aluminium} with one of aluminium."
        )


def not_converged(summary: Summary) -> Iterator[str]:
    """Yield the load cases whose peaks finer elements would change."""
    cases = [
        name for name, case in summary.results.items() if case.verdict == ConvergenceVerdict.NOT_CONVERGED
    ]
    names = "all cases" if len(cases) == len(summary.results) > 2 else ", ".join(cases)
    fixed = summary.passes or summary.model.mesh_from_file
    if cases:
        yield f"Not converged: {names}{'' if fixed else ' (try --tolerance 5 or less)'}"


def singular(summary: Summary) -> Iterator[str]:
    """Yield where the exact stress is infinite, with the largest value that the mesh gives there.

    Sharp edges that are judged are left out.
    """
    cases = [
        case
        for case in summary.results.values()
        if case.singular_where is not None and not (case.sharp_edges and case.singular_where == SHARP_EDGE)
    ]
    if cases:
        worst = max(cases, key=lambda case: case.singular_max_von_mises_MPa or 0.0)
        where, stress = worst.singular_where or "", quantity(worst.singular_max_von_mises_MPa, ".0f", "MPa")
        remedy = f" ({_REMEDIES[where]})" if where in _REMEDIES else ""
        yield f"Singular, left out: {where}, {stress}{remedy}"


def levers(summary: Summary) -> Iterator[str]:
    """Yield what would change the answer, as far as it follows from the figures without a further run."""
    survival, notes = summary.survival, summary.notes
    if any(note.kind is NoteKind.ASSUMPTION and note.topic == "material" for note in notes):
        yield "The material is assumed: [material] or --material."
    weakest = None if summary.governing is None else summary.governing.weakest
    spot = None if summary.envelope is None else summary.envelope.fatigue
    where = ""
    if survival.mode == "fatigue" and not survival.safety_factor.place:
        yield from _endurance(summary)
        where = (spot and spot.where) or ""
    elif survival.mode == "yielding" and weakest is not None:
        where = weakest.where
        needed = weakest.yield_MPa * survival.required_safety_factor / survival.assured_safety_factor
        helps = not survival.place and survival.answer != SurvivalAnswer.SURVIVES
        if helps and needed < _MOST_STRENGTH * weakest.yield_MPa:
            strength, now = (quantity(value, ".0f", "MPa") for value in (needed, weakest.yield_MPa))
            yield f"Against yielding, a yield strength of {strength} there would suffice (now {now})."
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
    surfaces = [surface for surface in regions if surface is not None]
    finish = f" ({_finish(surfaces[0])})" if surfaces else ""
    least, gain = envelope.min_fatigue_safety_factor_without_support, spot.support_factor
    if least is not None and gain is not None and f"{gain:.3g}" != "1":
        without = f"without it the factor is {number(least, '.3g')}"
        finish += f", with {number(gain, '.3g')} for the gradient of stress ({without})"
    shown = quantity(spot.endurance_MPa, ".4g", "MPa")
    cycles = next((limit.cycles for limit in limits if limit.cycles is not None), None)
    what = (
        "Endurance limit"
        if cycles is None
        else f"No endurance limit; strength at {with_power(format(cycles, '.3g'))} cycles"
    )
    yield f"{what} there: {shown}{estimated}{finish}: endurance_MPa, surface"


def _finish(surface: SurfaceFigures) -> str:
    """Return the finish of a surface with its factor, and what else an assumed one may be."""
    made = "shot-peened forging" if surface.finish == Finish.SHOT_PEENED else surface.finish
    text = f"{made}, factor {surface.surface_factor:.3g}"
    if not surface.assumed:
        return text
    other = f'; of a machined and peened bar surface = "{Finish.MACHINED_PEENED}"'
    return f"{text}, assumed{other if surface.finish == Finish.SHOT_PEENED else ''}"


def cycle(summary: Summary) -> Iterator[str]:
    """Yield the least factors over the whole cycle."""
    if (envelope := summary.envelope) is None:
        return
    least = f"yielding {factor(envelope.min_safety_factor)} at {number(envelope.crank_deg, '.0f')}°"
    if envelope.fatigue is None:
        yield f"Cycle: {least}; fatigue is not judged."
        return
    mean, amplitude = (
        quantity(stress, ".0f", "MPa")
        for stress in (envelope.fatigue.mean_MPa, envelope.fatigue.amplitude_MPa)
    )
    fatigue = f"fatigue {factor(envelope.fatigue.fatigue_safety_factor)} ({envelope.fatigue_criterion})"
    yield f"Cycle: {least}; {fatigue}, mean {mean}, amplitude {amplitude}."


# A fillet radius, mm, that any tool leaves.
_SMALL = 0.1


def worst_edge(summary: Summary) -> Iterator[str]:
    """Yield the sharp edge with the least factor, if it does not govern."""
    edges = [edge for case in summary.results.values() for edge in case.sharp_edges or ()]
    if edges and _governing_edge(summary) is None:
        worst, names = min(edges, key=lambda edge: edge.safety_factor), {edge.name for edge in edges}
        which = f"Sharp edge {worst.name}" + (f", the worst of {len(names)}" if len(names) > 1 else "")
        yield f"{which}: structural stress with a factor of {factor(worst.safety_factor)}; {fillet(worst)}."


def sharp_edges(summary: Summary) -> Iterator[str]:
    """Yield a line for each sharp edge that matters, in its worst load case, and which figure decides."""
    worst: dict[str, tuple[str, SharpEdgeFigures]] = {}
    for case, result in summary.results.items():
        for edge in result.sharp_edges or ():
            if edge.name not in worst or edge.safety_factor < worst[edge.name][1].safety_factor:
                worst[edge.name] = case, edge
    for name in sorted(worst, key=lambda name: (len(name), name)):
        case, edge = worst[name]
        one, other = edge.between
        notch = f"{edge.opening_deg:.0f}° open, {quantity(edge.length_mm, '.0f', 'mm')} long"
        stress = f"{quantity(edge.structural_von_mises_MPa, '.0f', 'MPa')} ± {bar(edge.error_percent)} %"
        yield (
            f"Sharp edge {name} at {place(edge.at_mm)}, between {one} and {other} ({notch}): structural "
            f"stress {stress} in {case}, safety factor {factor(edge.safety_factor)}; {fillet(edge)}."
        )
    if worst:
        left_out = " (the fatigue factors of the cycle leave these edges out)" if summary.envelope else ""
        yield (
            "Which to use: against yielding under static load, the factor of the first line, the least of "
            "the peaks away from sharp edges and the structural stresses at them (extrapolated from 0.4 and "
            "1.0 thicknesses beside the edge, IIW), where the elastic stress is infinite; against fatigue, "
            f"give the edges the fillets above and run again{left_out}."
        )


def fillet(edge: SharpEdgeFigures) -> str:
    """Return which fillet the edge needs."""
    required = f"a factor of {edge.required_safety_factor:g}"
    if edge.safety_factor < edge.required_safety_factor:
        return f"no fillet gives {required}, the section itself is too weak"
    if edge.largest_fillet_mm is None:
        return "the fillet it needs could not be determined: short flanks, a narrow notch or large elements"
    if edge.fillet_radius_mm is None:
        largest = quantity(edge.largest_fillet_mm, ".1f", "mm")
        return f"the peak has {required} only with a fillet of more than {largest}"
    if edge.fillet_radius_mm < _SMALL:
        return f"even with a fillet of {quantity(_SMALL, 'g', 'mm')} the peak there would have {required}"
    radius = quantity(edge.fillet_radius_mm, ".2g", "mm")
    least = f"a fillet of {radius} is the least with which the peak there has {required}"
    return f"{least} against yielding (no recommendation: fatigue needs more)"


def buckling(summary: Summary) -> Iterator[str]:
    """Yield the least factor of the column formulas, and that of the modes of the solid."""
    column = summary.buckling.column
    planes = column.planes.items()
    factors = {side: plane.safety_factor for side, plane in planes if plane.safety_factor is not None}
    if column.case is None or not factors:
        if summary.buckling.modes is not None:
            yield "No load case compresses the rod, so it cannot buckle."
        return
    side = min(factors, key=lambda name: factors[name])
    under = f"under {quantity(column.force_N / KN, '.1f', 'kN')} ({column.case})"
    least = summary.buckling.min_mode_factor
    modes = "" if least is None else f"; modes of the solid {factor(least)}"
    yield f"Buckling: {factor(factors[side])} {SIDES[side]}, {under}{modes}."


def near_buckling(summary: Summary) -> Iterator[str]:
    """Yield what `buckling` does, where it nearly governs or was asked for."""
    least = summary.buckling.min_safety_factor
    near = least is not None and least < _NEAR * summary.survival.required_safety_factor
    if near or summary.buckling.modes:
        yield from buckling(summary)


def of_kind(notes: Iterable[Note], kind: NoteKind) -> list[str]:
    """Return the notes of a kind as sentences, without those that stand elsewhere."""
    elsewhere = {SINGULAR, UNITS, *HEADING}
    return [_sentence(note) for note in notes if note.kind is kind and note.topic not in elsewhere]


def _sentence(note: Note) -> str:
    text = str(note)
    return f"{text[0].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"


Lines = Callable[[Summary], Iterable[str]]


def _if_assembled(lines: Callable[[AssemblyFigures], Iterator[str]]) -> Lines:
    return lambda summary: () if summary.assembly is None else lines(summary.assembly)


def _notes(kind: NoteKind) -> Lines:
    return lambda summary: of_kind(summary.notes, kind)


def _nothing(_summary: Summary) -> tuple[()]:
    return ()


class Statement(NamedTuple):
    """A topic of the answer."""

    brief: Lines  #: below the table of a run, as long as there is room
    full: Lines = _nothing  #: with `--verbose`; what is missing stands in tables or in the list of notes
    section: str = ""  #: of the report, that has the full lines


# The answer, by consequence: failed checks, what governs, doubts, remedies, the rest.
STATEMENTS = (
    Statement(failed_checks, failed_checks),
    Statement(given_flaw, given_flaw, "defects"),
    Statement(basis, basis, "results"),
    Statement(governs, governs),
    Statement(overload, overload_in_full, "results"),
    Statement(life, life, "fatigue"),
    Statement(fatigue_test, fatigue_test, "results"),
    Statement(lambda _summary: (), log_lines, "fatigue"),
    Statement(_if_assembled(bolts_and_joint), _if_assembled(assembly_lines), "assembly"),
    Statement(film_lines, film_lines, "film"),
    Statement(flow, flow_in_full, "results"),  # the headline has its outcome
    Statement(_notes(NoteKind.DOUBT)),
    Statement(not_converged, not_converged),
    Statement(fretting, fretting_in_full, "fretting"),
    Statement(lambda summary: linings(summary, summary.survival.required_safety_factor), linings, "results"),
    Statement(singular, singular),
    Statement(levers, levers),
    Statement(cycle, cycle),
    Statement(defect_sizes, defect_sizes, "defects"),
    Statement(lambda _summary: (), head_gap, "head-clearance"),
    Statement(worst_edge, sharp_edges, "results"),
    Statement(_if_assembled(fits)),
    Statement(near_buckling, buckling, "buckling"),
    Statement(lambda summary: (_sentence(note) for note in summary.notes if note.topic == CANNOT_GOVERN)),
    Statement(contact),
    Statement(_notes(NoteKind.WARNING)),
)


def brief_statements(summary: Summary) -> Iterator[str]:
    """Yield the statements for the terminal, the gravest first."""
    for statement in STATEMENTS:
        yield from statement.brief(summary)


def full_statements(summary: Summary, section: str | None = None) -> Iterator[str]:
    """Yield all lines of the statements, or of those of a section of the report."""
    for statement in STATEMENTS:
        if section in {None, statement.section}:
            yield from statement.full(summary)
