"""Does the rod survive? One line, with the error bar taken off the safety factor."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import ceil, inf, isinf, log10

from fea.analysis.figures import AssemblyFigures, BucklingFigures, CaseFigures, CycleFigures, SurvivalFigures
from fea.base.shipped import shipped_toml

# A factor that differs from the required one by less, in percent, is not decided by any practical mesh.
_CLOSEST_PERCENT = 0.5
# Share of the difference from the required factor that the error bar may have for a decision.
_AIM = 0.9
# Below this a factor has two significant digits, not two decimals.
_SMALL = 0.095
# A joint that slides has a reserve of 1, as friction carries no more: what rounding may add to it.
_SLIDING = 1e-3
_FAILS: Mapping[str, str] = shipped_toml("base/failures.toml")["run"]


class Answer(StrEnum):
    """Whether the rod survives, from good to bad."""

    SURVIVES = "survives"
    UNDECIDED = "undecided"
    FAILS = "fails"


@dataclass(frozen=True)
class Factor:
    """A safety factor with its error bar."""

    mode: str  #: the mode of failure: ``yielding``, ``fatigue`` or ``buckling``, or one of bolts or joint
    case: str  #: the load case; empty for the whole cycle
    value: float  #: the factor
    error_percent: float | None = None  #: error bar of the stress behind it; None where there is no estimate
    place: str = ""  #: the sharp edge whose structural stress it is of; empty elsewhere

    @property
    def low(self) -> float:
        """The factor if the stress is higher by its error bar."""
        return self.value / (1 + (self.error_percent or 0.0) / 100)

    @property
    def high(self) -> float:
        """The factor if the stress is lower by its error bar."""
        share = (self.error_percent or 0.0) / 100
        return self.value / (1 - share) if share < 1 else inf

    def answer(self, required: float) -> Answer:
        """Compare the factor and its bar with a required factor."""
        if self.high < required:
            return Answer.FAILS
        return Answer.SURVIVES if self.low >= required else Answer.UNDECIDED

    @property
    def against(self) -> str:
        """The mode of failure, after a factor in a sentence; nothing for yielding."""
        return "" if self.mode == "yielding" else f" against {self.mode}"

    @property
    def text(self) -> str:
        """The factor with its bar, and its load case."""
        decimals = 2 if self.value >= _SMALL or self.value == 0 else 2 - ceil(log10(self.value))
        bar = ""
        if self.error_percent is not None and not isinf(self.value):
            width = self.value - self.low if isinf(self.high) else (self.high - self.low) / 2
            bar = f" ± {max(width, 10**-decimals):.{decimals}f}"
        said = ", ".join(part for part in (self.case, self.place) if part)
        case = f" ({said})" if said else ""
        return f"{self.value:.{decimals}f}{bar}{case}"


def factors(
    results: Mapping[str, CaseFigures],
    buckling: BucklingFigures,
    envelope: CycleFigures | None,
    assembly: AssemblyFigures | None = None,
) -> list[Factor]:
    """Return the safety factors of a run: of load cases, of the whole cycle, against buckling, of bolts.

    At a sharp edge the structural stress counts. The bar of the whole cycle is that of the smallest factor of
    its load cases, that of fatigue the bar of the factor between them; buckling, bolts and joint have none.
    """
    found = [
        Factor("yielding", name, case.min_safety_factor, case.error_percent) for name, case in results.items()
    ]
    found += [
        Factor("yielding", name, edge.safety_factor, edge.error_percent, f"edge {edge.name}")
        for name, case in results.items()
        for edge in case.sharp_edges or ()
    ]
    if envelope is not None:
        bar = None
        if known := [one for one in found if one.error_percent is not None and not one.place]:
            least, lowest = min(known, key=lambda one: one.value), min(known, key=lambda one: one.low)
            bar = least.error_percent if least is lowest else 100 * (least.value / lowest.low - 1)
        found.append(Factor("yielding", "", envelope.min_safety_factor, bar))
        if envelope.min_fatigue_safety_factor is not None:
            error = envelope.fatigue_error_percent
            found.append(Factor("fatigue", "", envelope.min_fatigue_safety_factor, error))
    if buckling.min_safety_factor is not None:
        found.append(Factor("buckling", "", buckling.min_safety_factor))
    return found if assembly is None else [*found, *factors_of_assembly(assembly)]


def factors_of_assembly(assembly: AssemblyFigures) -> list[Factor]:
    """Return the safety factors of bolts and joint; bolts without play carry what friction does not."""
    bolts, joint = assembly.bolts, assembly.joint
    found = [Factor("yielding of the bolts", bolts.max_case or "", bolts.yield_safety_factor)]
    if bolts.bending_fatigue_safety_factor is not None:
        found.append(Factor("fatigue of the bolts", "", bolts.bending_fatigue_safety_factor))
    reserves = {name: case.slip_reserve for name, case in joint.by_case.items()}
    reserves |= {} if joint.cycle is None else {"": joint.cycle.min_slip_reserve}
    found += [
        Factor("slip of the joint", name, reserve - _SLIDING)
        for name, reserve in reserves.items()
        if reserve is not None and bolts.hole_play_mm > 0
    ]
    parts = joint.separates
    if parts is not None and parts.load_factor is not None:
        found.append(Factor("separation of the joint", parts.case, parts.load_factor))
    return found


def survival(
    found: Sequence[Factor],
    required: float | None = None,
    *,
    given_mesh: bool = False,
    unjudged: Factor | None = None,
    unanalysed: str | None = None,
) -> SurvivalFigures:
    """Judge the safety factors of a run against the required one (``--min-safety``; 1 by default).

    A mesh from a file cannot be refined, so that no tolerance would decide. `unjudged` is the most that the
    factor against fatigue can be, where the cycle that it is of is not computed, `unanalysed` loads that are
    left out, in words: without them, no factor shows that the rod survives.
    """
    least = 1.0 if required is None else required
    failed, open_ = (
        [factor for factor in found if factor.answer(least) is answer]
        for answer in (Answer.FAILS, Answer.UNDECIDED)
    )
    governing = min(failed or open_ or found, key=lambda factor: factor.low)
    if failed:
        answer, text = Answer.FAILS, _failed(failed, required)
    elif open_:
        apart = 100 * abs(governing.value / least - 1)
        if apart < _CLOSEST_PERCENT:
            remedy = f"the factor is within {_CLOSEST_PERCENT:g} % of it, within the mesh's accuracy"
        else:
            remedy = f"--tolerance {_AIM * apart:.2g} would decide"
            remedy = "a finer mesh may decide" if given_mesh else remedy
        text = f"undecided, safety factor {governing.text}{governing.against} includes {least:g}; {remedy}"
        answer = Answer.UNDECIDED
    else:
        met = f"meets the required safety factor of {required or 1:g}:"
        met = "survives, safety factor" if required is None else met
        answer, text = Answer.SURVIVES, f"{met} {governing.text}{governing.against}"
        smallest = min(found, key=lambda factor: factor.value)
        if smallest.value < governing.value:  # of another place, whose bar reaches lower
            less = f"{governing.text}{governing.against} could be as low as {governing.low:.2f}"
            text = f"{met} {smallest.text}{smallest.against}; {less}"
        if unjudged is not None and unjudged.answer(least) is Answer.FAILS:
            text += f", but not the cycle: at most {unjudged.value:.2f} against fatigue (--cycle)"
        if unanalysed is not None:
            held = f"does not fail under these loads, safety factor {smallest.text}{smallest.against}"
            answer, text = Answer.UNDECIDED, f"undecided: {held}, but {unanalysed}"
    return SurvivalFigures(
        answer=answer.value,
        text=text,
        required_safety_factor=least,
        mode=governing.mode,
        case=governing.case or None,
        place=governing.place or None,
        safety_factor=governing.value,
        assured_safety_factor=governing.low,
        fatigue_at_most=None if unjudged is None else unjudged.value,
        fatigue_where=None if unjudged is None else unjudged.place,
    )


def _failed(failed: Sequence[Factor], required: float | None) -> str:
    worst = {factor.mode: factor for factor in sorted(failed, key=lambda factor: -factor.low)}
    if required is None:
        said = [f"{_FAILS[mode]}, safety factor {worst[mode].text}" for mode in _FAILS if mode in worst]
        return "; ".join(said)
    said = [f"{worst[mode].text} against {mode}" for mode in _FAILS if mode in worst]
    return f"below the required safety factor of {required:g}: {', '.join(said)}"
