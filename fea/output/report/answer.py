"""The answer that stands first: does the rod survive, with which factor, where and when."""

from typing import NamedTuple

from fea.analysis.figures import CaseFigures, Summary
from fea.output.terminal.run_lines import bar, factor, number, place

_VERDICTS = {
    "survives": ("The rod survives", "The rod meets the required safety factor of {:g}"),
    "fails": ("The rod does not survive", "The rod does not meet the required safety factor of {:g}"),
    "undecided": ("Undecided", "Undecided: the error bar includes the required safety factor of {:g}"),
}


class Fact(NamedTuple):
    """A figure of the answer: what it is, the figure, and what else is to be said of it."""

    name: str
    value: str
    more: str


class Answer(NamedTuple):
    """The answer."""

    #: verdict, text: in a few words, and in a line with the factors
    verdict: str
    text: str
    kind: str  #: ``survives``, ``fails``, ``undecided``, or ``untrusted`` where a check failed
    doubts: tuple[str, ...]  #: the checks that failed
    facts: tuple[Fact, ...]  #: the figures that matter most


def answer(summary: Summary) -> Answer:
    """Return the answer of a run."""
    found = summary.survival
    plain, required = _VERDICTS[found.answer]
    verdict = plain if found.required_safety_factor == 1 else required.format(found.required_safety_factor)
    failed = [name.replace("_", " ") for name, check in summary.checks.items() if not check.passed]
    return Answer(
        verdict=verdict,
        text=f"{found.text[0].upper()}{found.text[1:]}.",
        kind=found.answer if summary.trusted else "untrusted",
        doubts=tuple(failed),
        facts=tuple(_facts(summary)),
    )


def _facts(summary: Summary) -> list[Fact]:
    name = summary.worst_case
    worst = summary.results[name]
    found = [
        Fact("Safety factor against yielding", _with_bar(worst), _when(summary, name)),
        Fact("Largest von Mises stress", f"{number(worst.max_von_mises_MPa, '.0f')} MPa", _where(worst)),
    ]
    envelope = summary.envelope
    if envelope is not None and envelope.fatigue is not None:
        at = f"at x, y, z = {place(envelope.fatigue.at_mm)} mm".replace("-", "−")
        criterion = envelope.fatigue_criterion.capitalize()
        found.append(
            Fact(
                "Safety factor against fatigue",
                factor(envelope.min_fatigue_safety_factor),
                f"{criterion}; {at}",
            )
        )
    if summary.buckling.min_safety_factor is not None:
        under = summary.buckling.column.case
        said = f"as a column, under {under}" if under else "as a column"
        found.append(Fact("Safety factor against buckling", factor(summary.buckling.min_safety_factor), said))
    passed = sum(check.passed for check in summary.checks.values())
    mesh = f"{summary.model.elements} elements, {summary.model.element}"
    found.append(Fact("Checks passed", f"{passed} of {len(summary.checks)}", mesh))
    return found


def _with_bar(case: CaseFigures) -> str:
    value = factor(case.min_safety_factor)
    if case.error_percent is None:
        return value
    low = case.min_safety_factor / (1 + case.error_percent / 100)
    return f"{value} ± {max(case.min_safety_factor - low, 0.01):.2f}"


def _when(summary: Summary, name: str) -> str:
    angle = summary.loads[name].crank_deg
    return name if angle is None else f"{name}, crank angle {angle:.1f}°"


def _where(case: CaseFigures) -> str:
    at = f"at x, y, z = {place(case.at_mm)} mm".replace("-", "−")
    return at if case.error_percent is None else f"± {bar(case.error_percent)} %, {at}"
