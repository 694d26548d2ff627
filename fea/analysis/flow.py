"""What yielding leads to: whether a rod that flows settles, and up to which multiple of its loads."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from fea.analysis.bench import bench_cases
from fea.analysis.collapse import bending_figures, overload_table
from fea.analysis.cyclic_life import cyclic_life, takes_too_long
from fea.analysis.flowing_rod import FlowingRod, FollowedFlow, ready
from fea.analysis.permanent_set import judged, permanent_set
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.refinement import between, usage
from fea.analysis.speed_result import SpeedResult
from fea.analysis.summary_figures import PlasticFigures, SettledFatigueFigures
from fea.analysis.survival import FATIGUE, LASTING_FLOW, OVER_REV
from fea.base.checks import Check, check
from fea.base.choices import SolverName
from fea.base.material import PEENING
from fea.base.note import Note, assumption, assumptions, doubt, omission, remark
from fea.base.units import DEG
from fea.judge.case_result import CaseResult, Governing
from fea.judge.fatigue import fatigue_factor
from fea.judge.safety_factor import SafetyFactor
from fea.judge.verdict import peak
from fea.plastic.cycling import Flow, PlasticAnswer
from fea.rod.places import place_name
from geometry.arrays import Floats, vector

# Topic of notes, and modes of failure by what the flow does; of others, it is that flow lasts.
FLOW = "plastic flow"
_MODES = {
    PlasticAnswer.CYCLIC: "cyclic plasticity",
    PlasticAnswer.RATCHETS: "ratcheting",
    PlasticAnswer.COLLAPSES: "plastic collapse",
}
# Halvings of the interval in which the multiple lies up to which a rod settles.
_HALVINGS = 3
# Of a cycle, at most so many instants beside the load cases, so far apart, rad: those at which a place with
# this share of the yield strength is worst.
_INSTANTS, _APART, _NEAR = 12, 5 * DEG, 0.9
# Change of contact between the parts of a rod, relative to the largest, up to which it may be held.
HELD = 0.05


def with_flow(
    rod: PreparedRod, static: SpeedResult, coarser: Mapping[float | None, PlasticAnswer | None] | None = None
) -> SpeedResult:
    """Follow the flow of a rod over its load cases, with a cycle over its worst instants, too.

    Nothing is done where nothing yields. `coarser`: by speed, what `answer_of` gave on the mesh before. A rod
    shakes down only if it does so on both meshes.
    """
    acting = _yielding(static)
    if not acting:
        return static
    if why := left_out(rod):
        return replace(static, notes=(*static.notes, omission(FLOW, why)))
    material, strength = rod.materials[0], rod.materials[0].yield_strength
    with rod.clock("plastic flow"):
        flowing = ready(rod, *_loads(rod, static, acting), acting[0].counts)
        if flowing.nodal.max() <= strength:
            why = "what yields lies beside places where the exact stress is infinite"
            return replace(static, notes=(*static.notes, omission(FLOW, why)))
        followed = _at_strengths(flowing)
        before, flow = (coarser or {}).get(static.rpm), followed.flow
        released = followed.contact_change > HELD and followed.settles
        differs = followed.settles and before not in {None, PlasticAnswer.ELASTIC, PlasticAnswer.SHAKES_DOWN}
        # What whole sections carry is balanced better than the peaks that the bar belongs to.
        bar = 0.0 if flow.answer is PlasticAnswer.COLLAPSES else Governing.of(acting).percent
        multiple = _settling(followed, material.flow_strength, 1 + bar / 100, rod.options.min_safety or 1.0)
        if differs:  # all that is sure is that nothing flows below first yield
            bar = max(bar, 100 * (multiple * float(flowing.nodal.max()) / material.flow_strength - 1))
        bending, notes = bending_figures(rod, static.loads.cases), (*static.notes, *_notes(rod, followed))
        if differs:
            what = (
                f"on the mesh before, {before}; {followed.flow.answer} on this one: a finer mesh may decide"
            )
            notes, followed = (*notes, doubt(what, FLOW)), followed.undecided
        elif released:
            followed = followed.undecided
        elif followed.settles and before is None:
            notes = (*notes, remark("it settles on this mesh, and was not followed on a coarser one", FLOW))
        plastic = replace(
            _figures(followed, multiple, bar),
            fatigue=_fatigue(rod, static, followed),
            cyclic=cyclic_life(followed, static.rpm),
            bending=bending,
            collapse_factor=None if bending is None else bending.limit_N / bending.force_N,
        )
    checks = {**static.checks, **flow_checks(flow, static.checks)}
    return replace(static, checks=checks, notes=notes, plastic=plastic, flows={"plastic": followed})


def flow_checks(flow: Flow, before: Mapping[str, Check]) -> dict[str, Check]:
    """Return the checks of a flow; of those that another flow had before, the worse."""
    values = {
        "plastic_equilibrium": flow.unbalanced,
        "plastic_yield": max(0.0, flow.beyond_yield),
        "plastic_dissipation": max(0.0, -flow.least_dissipation),
    }
    had = {name: each.value for name, each in before.items()}
    return {name: check(name, max(value, had.get(name, 0.0))) for name, value in values.items()}


def answer_of(rod: PreparedRod, static: SpeedResult) -> PlasticAnswer | None:
    """Say what flow leads to on a mesh; None where nothing yields, or where flow is not followed."""
    if not (acting := _yielding(static)) or left_out(rod):
        return None
    with rod.clock("plastic flow"):
        flowing = ready(rod, *_loads(rod, static, acting), acting[0].counts)
        yields = flowing.nodal.max() > rod.materials[0].yield_strength
        if yields and flowing.reversing(rod.materials[0].flow_strength) < 1:
            return PlasticAnswer.CYCLIC  # it never ends, which is all that matters here
        return _at_strengths(flowing).flow.answer if yields else None


def _yielding(static: SpeedResult) -> list[CaseResult]:
    """Load cases with forces, if anything yields under one of them."""
    acting = [case for case in static.cases.values() if case.load.largest_force > 0]
    return acting if max((case.worst.value for case in acting), default=0.0) > 1 else []


def _at_strengths(flowing: FlowingRod) -> FollowedFlow:
    """Follow a rod at its yield strength, and at the cyclic one if it is smaller and the rod settles.

    What does not settle at the yield strength does not at a smaller one.
    """
    material = flowing.rod.materials[0]
    followed = flowing.follow(material.yield_strength)
    if followed.settles and material.flow_strength < material.yield_strength:
        return flowing.follow(material.flow_strength)
    return followed


def _loads(
    rod: PreparedRod, static: SpeedResult, cases: Sequence[CaseResult]
) -> tuple[dict[str, Floats], Floats]:
    """Displacements of the whole rod in the order in which they act, and the largest stress at its nodes."""
    at = {case.load.name: float(np.nan_to_num(case.load.crank_angle, nan=np.inf)) for case in cases}
    loads = {case.load.name: case.displacement for case in cases}
    worst = np.max([case.von_mises for case in cases], axis=0)
    if static.cycle is not None and static.rpm is not None:
        envelope, angles = static.cycle.envelope, list[float]()
        worst = np.maximum(worst, envelope.von_mises)
        usage = np.where(static.cycle.counts, np.abs(envelope.usage), 0.0)
        for angle in envelope.usage_angle[np.argsort(-usage)[: np.count_nonzero(usage > _NEAR)]].tolist():
            if len(angles) < _INSTANTS and all(abs(angle - other) > _APART for other in angles):
                angles.append(angle)
        moved = rod.displacement(static.rpm, np.array(angles)) if angles else worst
        for number, angle in enumerate(angles):
            name = f"{angle / DEG:.0f}°"
            loads[name], at[name] = moved[..., number], angle
    return {name: loads[name] for name in sorted(loads, key=at.__getitem__)}, worst


def _settling(followed: FollowedFlow, strength: float, sure: float, least: float) -> float:
    """Return a multiple of all loads at which the rod settles, or at which what ends it does not happen.

    The rod may settle at larger ones: `sure`, which contains the error bar of the stress, times the `least`
    factor and what an over-rev asks are tried. Where it does not settle now, the multiple is below 1.
    """
    rod, answer = followed.rod, followed.flow.answer
    most = rod.reversing(strength)
    if followed.settles:
        wanted = (each for each in (OVER_REV**2 * least * sure, least * sure, least) if each > 1)
        return next((each for each in wanted if each <= most and rod.follow(strength, each).settles), 1.0)
    if answer is PlasticAnswer.CYCLIC and most < 1:
        return most
    collapses = answer is PlasticAnswer.COLLAPSES
    low, high = min(1.0, strength / float(rod.nodal.max())), 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if collapses:
            borne = rod.followed(strength, middle, most_turns=1).flow.answer is not answer
        else:
            borne = rod.follow(strength, middle).settles
        low, high = (middle, high) if borne else (low, middle)
    return low


def _figures(followed: FollowedFlow, multiple: float, bar: float) -> PlasticFigures:
    flow, rod, mesh = followed.flow, followed.rod, followed.rod.rod.mesh
    left, limits = (
        permanent_set(mesh.whole, mesh.bores.rod_length, followed.whole),
        overload_table(rod.rod).limits,
    )
    names, where = list(rod.loads), place_name(mesh, followed.node)
    case = names[flow.cases[0]] if flow.cases else ""
    named = {"mode": _MODES.get(flow.answer, LASTING_FLOW), "place": where}
    return PlasticFigures(
        state=flow.answer.value,
        max_plastic_strain=float(flow.strain.max()),
        strain_per_turn=0.0 if followed.settles or flow.answer is PlasticAnswer.COLLAPSES else flow.per_turn,
        at_mm=vector(mesh.whole.points[followed.node]),
        where=where,
        elements=followed.elements,
        turns=flow.turns,
        cases=tuple(names[number] for number in flow.cases),
        residual_MPa=followed.residual,
        set_um=left,
        set_judged=None if flow.answer is PlasticAnswer.COLLAPSES else judged(left, limits),
        strength_MPa=float(followed.zone.strength[0, 0]),
        settling_factor=SafetyFactor.of_stress(multiple, bar, instant=case, **named),
    )


def _fatigue(rod: PreparedRod, result: SpeedResult, followed: FollowedFlow) -> SettledFatigueFigures | None:
    """Judge the cycle or the test with what flow has left; None without either, or without strengths.

    What is left moves the mean stress and not the amplitude: where compression has yielded, to tension. A
    benefit counts only if nothing has flowed under load cases beside the cycle. Peening goes where it flows.
    """
    material, criterion, cycle = rod.materials[0], rod.options.fatigue, result.cycle
    cases = [case for case in result.cases.values() if case.load.in_cycle]
    cases = bench_cases(result.cases) if cycle is None else cases
    if not followed.settles or not cases or (used := usage(rod, cases)) is None:
        return None
    masked, regions, (mean, amplitude, _) = ~followed.rod.counts, rod.regions, between(cases)
    if cycle is not None:
        masked, regions = ~(cycle.counts & followed.rod.counts), cycle.regions
        mean, amplitude = cycle.envelope.mean, cycle.envelope.amplitude
    (shift, flowed), names = followed.mean_shift, list(followed.rod.loads)
    others = result.cases.keys() - {case.load.name for case in cases}
    if others & {names[number] for number in followed.flow.cases}:
        shift = np.maximum(shift, 0)
    surface = regions.factors(material)
    bare = surface / PEENING if "peened" in material.marin.rest.finish else surface
    elastic = fatigue_factor(criterion, mean, amplitude, material, surface)
    settled = fatigue_factor(criterion, mean + shift, amplitude, material, np.where(flowed, bare, surface))
    if elastic is None or settled is None:
        return None
    node, bar = peak(1 / settled, 0 * settled, masked).node, peak(*used, masked).error_percent
    where = place_name(rod.mesh, node)
    named = {"mode": FATIGUE, "place": f"after shakedown, {where}"}
    return SettledFatigueFigures(
        safety_factor=SafetyFactor.of_stress(float(settled[node]), bar, **named),
        elastic_safety_factor=SafetyFactor.of_stress(float(elastic[~masked].min()), bar),
        where=where,
        elastic_mean_MPa=float(mean[node]),
        mean_MPa=float(mean[node] + shift[node]),
    )


def _notes(rod: PreparedRod, followed: FollowedFlow) -> Iterator[Note]:
    material = rod.materials[0]
    strength, key = "the yield strength in repeated loading, too", "material.cyclic_yield_MPa"
    if material.cyclic_estimated and material.cyclic_yield is not None:
        strength = f"{material.cyclic_yield:.0f} MPa as cyclic yield strength"
        key += "; uniform material law, Bäumel & Seeger 1990"
    yield from assumptions(
        FLOW,
        (
            "no hardening, small strain, and what the pins press as in the elastic rod",
            "load cases that follow one another by crank angle",
            *((f"{strength} ({key})",) if material.cyclic_estimated else ()),
        ),
    )
    yield from held_contact(followed, FLOW)
    if followed.flow.answer is PlasticAnswer.UNDECIDED:
        yield doubt(f"what flows did not settle within {followed.flow.turns} turns", FLOW)
    if takes_too_long(followed):
        why = "followed at the cyclic strength with --cycle, where at most 2 % of the elements exceed it"
        yield omission("range of strain of what flows to and fro", why)


def held_contact(followed: FollowedFlow, topic: str) -> Iterator[Note]:
    """Yield what flow would do to the contact between parts, which is that of the elastic rod."""
    if followed.rod.rod.assembly_contact is not None:
        change = f"would change the largest pressure or bolt force by {100 * followed.contact_change:.2g} %"
        yield assumption(
            f"contact between the parts as in the elastic rod; flow {change} if all stuck", topic
        )
        if followed.contact_change > HELD:
            yield doubt(f"what flows {change}, too much to be left out", topic)


def left_out(rod: PreparedRod) -> str:
    """Why the flow of a rod is not followed, as a rule; empty where it can be."""
    reasons = {
        "not asked for (elastic)": rod.options.elastic,
        "not followed in rods of separate parts without contact between them": len(rod.materials) > 1
        and rod.assembly_contact is None,
        "not followed in mixed elements": bool(rod.structure.soft),
        "first-order elements are too stiff for flow, which keeps the volume": rod.mesh.cell.order == 1,
        "it needs a direct solver": rod.model.solver == SolverName.AMG,
    }
    return next((why for why, applies in reasons.items() if applies), "")
