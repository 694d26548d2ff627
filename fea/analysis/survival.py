"""Does the rod survive? The one list of safety factors by which every answer is given, and the answer."""

from collections.abc import Mapping, Sequence
from math import isfinite

from fea.analysis.defect_figures import DefectFigures
from fea.analysis.figures import CaseFigures
from fea.analysis.life_figures import CycleFigures
from fea.analysis.overload_figures import OverloadFigures
from fea.analysis.summary_figures import AssemblyFigures, BucklingFigures, PlasticFigures, SurvivalFigures
from fea.base.shipped import shipped_toml
from fea.judge.safety_factor import SafetyFactor, SurvivalAnswer, printed

# A factor that differs from the required one by less, in percent, is not decided by any practical mesh.
_CLOSEST_PERCENT = 0.5
# Share of the difference from the required factor that the error bar may have for a decision.
_AIM = 0.9
# A joint that slides has a reserve of 1, as friction carries no more: what rounding may add to it.
_SLIDING = 1e-3
_FAILS: Mapping[str, str] = shipped_toml("base/failures.toml")["run"]
FATIGUE, LASTING_FLOW, OVERLOAD, SET = "fatigue", "lasting flow", "overload", "permanent set"
COLLAPSE = "collapse"  # of the shank, which is bowed from the beginning
# What is left for good, in words, by the names of `fea.analysis.permanent_set`.
SET_WORDS = {
    "length": "distance of the bores",
    "bend": "bend",
    "twist_deg": "twist",
    "bow": "bow of the shank",
    "big_end": "big end's bore out of round",
    "small_end": "small end's bore out of round",
}
# Ordinary scatter: an engine is turned 10 % beyond its speed by a missed shift, so that inertia grows by the
# square of that; single cycles have a peak pressure of 15 % more than the mean, three times the 5 % by which
# peaks scatter in steady running (Heywood 1988, §9.4.1).
OVER_REV, SINGLE_CYCLE = 1.10, 1.15
GIVEN = "the given forces"  # which do not scatter
_PRESSED = ("gas", "compression")


def factors(
    results: Mapping[str, CaseFigures],
    buckling: BucklingFigures,
    envelope: CycleFigures | None,
    assembly: AssemblyFigures | None = None,
    plastic: PlasticFigures | None = None,
    *,
    overload: OverloadFigures | None = None,
    defect: DefectFigures | None = None,
) -> list[SafetyFactor]:
    """Return the safety factors of a run: of load cases, of the whole cycle, against buckling, of bolts.

    Where plastic flow was followed, what it leads to takes the place of first yield.

    At a sharp edge the structural stress counts. The bar of the whole cycle is that of the smallest factor of
    its load cases, that of fatigue the bar of the factor between them; buckling, bolts and joint have none.
    """
    first_yield = [case.min_safety_factor.against("yielding", name) for name, case in results.items()]
    found = first_yield if plastic is None else [plastic.settling_factor]
    found += [
        edge.safety_factor.against("yielding", name, f"edge {edge.name}")
        for name, case in results.items()
        for edge in case.sharp_edges or ()
    ]
    if envelope is not None:
        found += [] if plastic else [envelope.min_safety_factor.against("yielding")]
        if envelope.min_fatigue_safety_factor is not None:
            found.append(envelope.min_fatigue_safety_factor.against(FATIGUE))
    if plastic is not None and plastic.collapse_factor is not None:
        found.append(SafetyFactor(plastic.collapse_factor, mode=COLLAPSE))
    if plastic is not None and plastic.fatigue is not None:
        found.append(plastic.fatigue.safety_factor)
    found += [*_left_behind(plastic, overload), *flaw_factors(defect)]
    if buckling.min_safety_factor is not None:
        found.append(buckling.min_safety_factor.against("buckling"))
    return found if assembly is None else [*found, *factors_of_assembly(assembly)]


def _left_behind(plastic: PlasticFigures | None, overload: OverloadFigures | None) -> list[SafetyFactor]:
    """Return the factor of an overload that bends the rod, and the ratio of limits of a set that it exceeds.

    Where they are above 1 the rod bears what it bears once, and needs no reserve; a set is not in proportion.
    """
    bends = overload is not None and overload.safety_factor < 1
    found = [overload.safety_factor.against(OVERLOAD)] if overload is not None and bends else []
    for what, source in (("running", plastic), ("the overload", overload)):
        left = None if source is None else source.set_judged
        if left is not None and left.exceeded and left.least_factor is not None:
            place = f"{SET_WORDS[left.exceeded[0]]}, {what}"
            found.append(SafetyFactor(left.least_factor, mode=SET, place=place))
    return found


def flaw_factors(defect: DefectFigures | None) -> list[SafetyFactor]:
    """Return the factor of a given flaw, over the duty if there is one, unless it lasts until inspection."""
    flaw = None if defect is None else defect.flaw
    if flaw is None or (judged := flaw.duty or flaw).depth_after_service_mm is not None:
        return []
    return [judged.factor.against(judged.factor.mode, place=f"the given flaw, {flaw.where}")]


def factors_of_assembly(assembly: AssemblyFigures) -> list[SafetyFactor]:
    """Return the safety factors of bolts and joint; bolts without play carry what friction does not."""
    bolts, joint = assembly.bolts, assembly.joint
    found = [bolts.yield_safety_factor.against("yielding of the bolts", bolts.max_case or "")]
    if bolts.bending_fatigue_safety_factor is not None:
        found.append(bolts.bending_fatigue_safety_factor.against("fatigue of the bolts"))
    reserves = {name: case.slip_reserve for name, case in joint.by_case.items()}
    reserves |= {} if joint.cycle is None else {"": joint.cycle.min_slip_reserve}
    found += [
        SafetyFactor(reserve - _SLIDING, mode="slip of the joint", instant=name)
        for name, reserve in reserves.items()
        if reserve is not None and bolts.hole_play_mm > 0
    ]
    parts = joint.separates
    if parts is not None and parts.load_factor is not None:
        found.append(SafetyFactor(parts.load_factor, mode="separation of the joint", instant=parts.case))
    return found


def survival(
    found: Sequence[SafetyFactor],
    required: float | None = None,
    *,
    given_mesh: bool = False,
    fatigue_at_most: SafetyFactor | None = None,
    by_duty: bool = False,
    unanalysed: str | None = None,
    stands_on: str | None = None,
) -> SurvivalFigures:
    """Judge the safety factors of a run against the required one (``--min-safety``; 1 by default).

    A mesh from a file cannot be refined, so that no tolerance would decide. `fatigue_at_most` is a bound on
    the factor against fatigue from the load cases, where the cycle is not computed: below the required factor
    it decides like a factor. Fatigue is judged by its factor or, `by_duty`, by hours; a rod of which it
    is not judged does not survive, however large its other factors are, nor does one with loads that are left
    out, which `unanalysed` says in words. `stands_on` says for which operation the answer is.
    """
    least = 1.0 if required is None else required
    bounded = fatigue_at_most is not None and fatigue_at_most.answer(least) is SurvivalAnswer.FAILS
    counted = [*found, fatigue_at_most] if bounded and fatigue_at_most is not None else [*found]
    judged = by_duty or any(factor.mode == FATIGUE for factor in counted)
    failed, undecided = (
        sorted((one for one in counted if one.answer(least) is answer), key=lambda factor: factor.low)
        for answer in (SurvivalAnswer.FAILS, SurvivalAnswer.UNDECIDED)
    )
    governing = min(failed or undecided or counted, key=lambda factor: factor.low)
    if failed:
        answer, text = SurvivalAnswer.FAILS, _failed(failed, required, fatigue_at_most)
    elif undecided:
        remedy = _remedy(governing, least, given_mesh=given_mesh or governing.mode == LASTING_FLOW)
        answer = SurvivalAnswer.UNDECIDED
        text = f"undecided, safety factor {governing.named} includes {least:g}; {remedy}"
    else:
        flowed = any(factor.mode == LASTING_FLOW for factor in counted)
        answer = SurvivalAnswer.SHAKES_DOWN if flowed else SurvivalAnswer.NOT_JUDGED
        answer = SurvivalAnswer.SURVIVES if judged and unanalysed is None else answer
        scatters = answer is SurvivalAnswer.SURVIVES and stands_on != GIVEN
        reserve = _no_reserve(governing, least) if scatters else ""
        text = _met(counted, governing, answer, required, reserve)
    if not judged:
        text += f"; fatigue is not judged{_most(fatigue_at_most)}"
    if unanalysed is not None:
        text += f"; {unanalysed}"
    return SurvivalFigures(
        answer=answer.value,
        text=text,
        required_safety_factor=least,
        mode=governing.mode,
        case=governing.instant or None,
        place=None if governing.mode == FATIGUE else governing.place or None,
        safety_factor=governing,
        assured_safety_factor=governing.low,
        fatigue_at_most=fatigue_at_most,
        fatigue_where=None if fatigue_at_most is None else fatigue_at_most.place,
        stands_on=stands_on if answer is SurvivalAnswer.SURVIVES else None,
        ends_at_load=governing.low / least
        if answer is SurvivalAnswer.SURVIVES and isfinite(governing.low)
        else None,
    )


def _no_reserve(governing: SafetyFactor, least: float) -> str:
    """Return the ordinary scatter that the factor does not cover, in words; empty where it covers that."""
    by_gas = governing.instant in _PRESSED or governing.mode in {"buckling", COLLAPSE}
    needed = SINGLE_CYCLE if by_gas else OVER_REV**2
    if governing.low >= needed * least:
        return ""
    more = f"{100 * ((SINGLE_CYCLE if by_gas else OVER_REV) - 1):.0f} %"
    what = f"single cycles of {more} more pressure" if by_gas else f"{more} over-rev"
    return f"without reserve against {what}"


def _most(bound: SafetyFactor | None) -> str:
    return "" if bound is None else f", its factor is at most {printed(bound)} (--cycle)"


def _remedy(governing: SafetyFactor, least: float, *, given_mesh: bool) -> str:
    apart = 100 * abs(governing / least - 1)
    if apart < _CLOSEST_PERCENT and governing.mode != LASTING_FLOW:
        return f"the factor is within {_CLOSEST_PERCENT:g} % of it, within the mesh's accuracy"
    return "a finer mesh may decide" if given_mesh else f"--tolerance {_AIM * apart:.2g} would decide"


def _met(
    found: Sequence[SafetyFactor],
    governing: SafetyFactor,
    answer: SurvivalAnswer,
    required: float | None,
    reserve: str = "",
) -> str:
    met = f"{answer.value}, {reserve}; safety factor" if reserve else f"{answer.value}, safety factor"
    if answer is not SurvivalAnswer.SURVIVES and governing.mode not in {"yielding", LASTING_FLOW}:
        met = f"{answer.value}; least safety factor"
    if required is not None:
        met = f"meets the required safety factor of {required:g}:"
    smallest = min(found)
    if smallest < governing:  # of another place, whose bar reaches lower
        return f"{met} {smallest.named}; {governing.named} could be as low as {governing.low:.2f}"
    return f"{met} {governing.named}"


def _failed(failed: Sequence[SafetyFactor], required: float | None, bound: SafetyFactor | None) -> str:
    """Return the modes that fail, the one with the least factor first."""
    worst: dict[str, SafetyFactor] = {}
    for factor in failed:
        worst.setdefault(factor.mode, factor)
    said = {mode: f"{'at most ' if factor is bound else ''}{factor.text}" for mode, factor in worst.items()}
    if required is None:
        return "; ".join(f"{_FAILS[mode]}, safety factor {text}" for mode, text in said.items())
    below = ", ".join(f"{text} against {mode}" for mode, text in said.items())
    return f"below the required safety factor of {required:g}: {below}"
