"""Whether all that one run says of a rod agrees: terminal, report, files, studio, limits and exit code."""

import html
import io
import json
import math
import re
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from pathlib import Path

import numpy as np
from rod_studies import assembled_study, random_study

from fea.__main__ import call
from fea.apps.limits.run_limits import limits
from fea.apps.studio.live_rod import fresh
from fea.judge.safety_factor import SafetyFactor, interval, printed
from fea.study.option_tables import MeshTable, OutputTable
from fea.study.study import Study
from geometry.errors import InvalidValue
from mesh.sizing import default_size

# How the headline begins, by the mode of failure that governs a rod that fails.
FAILS = {
    "yielding": "yields",
    "fatigue": "fails by fatigue",
    "buckling": "buckles",
    "cyclic plasticity": "flows to and fro in every turn",
    "ratcheting": "is deformed further in every turn",
    "plastic collapse": "collapses plastically",
    "lasting flow": "does not shake down",
    "yielding of the bolts": "the bolts yield",
    "fatigue of the bolts": "the bolts fail by fatigue",
    "slip of the joint": "the joint slips",
    "separation of the joint": "cap and rod come apart",
}
REPORTED = {
    "survives": ("The rod survives", "The rod meets"),
    "does not yield": ("The rod does not yield", "The rod meets"),
    "shakes down": ("The rod flows at first and is elastic then", "The rod meets"),
    "fails": ("The rod does not survive", "The rod does not meet"),
    "undecided": ("Undecided", "Undecided"),
}
# By what plastic flow does.
FLOWS = {
    "elastic": "lasting flow",
    "shakes down": "lasting flow",
    "cyclic": "cyclic plasticity",
    "ratchets": "ratcheting",
    "collapses": "plastic collapse",
    "undecided": "lasting flow",
}
BOLTS = ("yielding of the bolts", "fatigue of the bolts", "slip of the joint", "separation of the joint")
# In what limits and runs differ: limits look at every few crank angles, to half a percent.
NEAR = 0.02
_ROUNDED = 1e-5  # of the numbers in files


def random_asked(seed: int, size: float = 1.6) -> Study | None:
    """A random rod, in one piece or in parts, with some of what `fea run` offers; None if refused.

    `size`: of the elements, over the default.
    """
    draw = np.random.default_rng([seed, 57])
    in_parts, cycle, film = draw.random() < 0.5, draw.random() < 0.5, draw.random() < 0.1
    min_safety = float(draw.choice([1.0, 1.2, 2.0])) if draw.random() < 0.4 else None
    study = assembled_study(seed) if in_parts else random_study(seed)
    if study is None or isinstance(study, InvalidValue):
        return None
    length = study.rod.dimensions.length
    analysis = replace(
        study.analysis,
        cycle=bool(cycle),
        film=bool(film and cycle and not in_parts),
        min_safety=min_safety,
        tolerance_percent=0.0,
    )
    faster = study.speeds()[0] * draw.uniform(0.6, 1.6)
    return replace(
        study,
        analysis=analysis,
        mesh=MeshTable(size_mm=float(size * default_size(length))),
        speed=replace(study.speed, rpm=round(float(faster), -1)),
        output=OutputTable(report=True, screenshot=False),
    )


def disagreements(study: Study, folder: Path) -> list[str] | None:
    """Run a study as the command line does, and say what disagrees; None where it is refused.

    Where the whole cycle is known the studio is asked, too, and the limits of a rod of one piece.
    """
    path = folder / "asked.toml"
    path.write_text(study.text(), encoding="utf-8")
    said, error = io.StringIO(), io.StringIO()
    with redirect_stdout(said), redirect_stderr(error):
        code = call(["run", str(path), "--out", str(folder / "run")])
    if code not in (0, 5, 6):
        return None
    summary = json.loads((folder / "run" / "summary.json").read_text(encoding="utf-8"))
    text = " ".join(said.getvalue().split())
    page = html.unescape((folder / "run" / "report.html").read_text(encoding="utf-8"))
    wrong = [
        *_verdict(summary),
        *_headline(summary, text),
        *_table(summary, said.getvalue()),
        *_report(summary, page),
        *_exit_code(summary, code, study.analysis.min_safety),
    ]
    if study.analysis.cycle and not study.analysis.film:
        wrong += _studio(summary, study)
        if study.assembly is None:
            wrong += _limits(summary, study)
    return wrong


def _known(found: dict, name: str, mode: str, instant: str = "") -> list[SafetyFactor]:
    value = found.get(name)
    if value is None:
        return []
    return [SafetyFactor(value, found[f"{name}_low"], found[f"{name}_high"], mode=mode, instant=instant)]


def every_factor(summary: dict, *, elastic: bool = False) -> list[SafetyFactor]:
    """Every factor of `summary.json` that decides, with its interval; `elastic`: first yield in any case."""
    flow = None if elastic else summary.get("plastic")
    found = [] if flow is None else _known(flow, "settling_factor", FLOWS[flow["state"]])
    if (bends := flow and flow.get("collapse_factor")) is not None:
        found.append(SafetyFactor(bends, mode="collapse"))
    found += [
        one
        for case, result in summary["results"].items()
        for one in (
            *(_known(result, "min_safety_factor", "yielding", case) if flow is None else ()),
            *(
                factor
                for edge in result.get("sharp_edges") or ()
                for factor in _known(edge, "safety_factor", "yielding", case)
            ),
        )
    ]
    if (cycle := summary.get("envelope")) is not None:
        found += _known(cycle, "min_safety_factor", "yielding") if flow is None else []
        found += _known(cycle, "min_fatigue_safety_factor", "fatigue")
    found += _known(summary["buckling"], "min_safety_factor", "buckling")
    if (parts := summary.get("assembly")) is not None:
        found += _known(parts["bolts"], "yield_safety_factor", "yielding of the bolts")
        found += _known(parts["bolts"], "bending_fatigue_safety_factor", "fatigue of the bolts")
    return found


def _verdict(summary: dict) -> list[str]:
    """The answer, by the rule alone: what is surely below fails; else what may be below; else the least."""
    verdict, required = summary["survival"], summary["survival"]["required_safety_factor"]
    every = every_factor(summary)
    bound = _known(verdict, "fatigue_at_most", "fatigue")
    every += [one for one in bound if one.high < required]
    failing = [one for one in every if one.high < required]
    open_ = [one for one in every if one.low < required <= one.high]
    judged = any(one.mode == "fatigue" for one in every)
    answer = "fails" if failing else "undecided" if open_ else "survives" if judged else "does not yield"
    if answer == "does not yield" and any(one.mode == "lasting flow" for one in every):
        answer = "shakes down"
    worst = min(failing or open_ or every, key=lambda one: one.low)
    [own] = _known(verdict, "safety_factor", verdict["mode"])
    if verdict["mode"] in BOLTS[2:]:  # slip and separation are known of by their reserve alone
        return []
    wrong = []
    if verdict["answer"] != answer:
        wrong.append(f"summary.json says {verdict['answer']}, its factors {answer}")
    if (own, own.low, own.high) != (worst, worst.low, worst.high):
        wrong.append(f"summary.json is governed by {own.text}, its factors by {worst.named}")
    if verdict["mode"] != worst.mode:
        wrong.append(f"summary.json is governed by {verdict['mode']}, its factors by {worst.mode}")
    return wrong


def _headline(summary: dict, text: str) -> list[str]:
    verdict = summary["survival"]
    words = verdict["text"]
    wrong = [] if words in text else [f"the terminal does not say: {words}"]
    [known] = _known(verdict, "safety_factor", verdict["mode"])
    bar = interval(known)
    number = f"{printed(known)} {bar[:-1] if bar.startswith('(') else bar}".strip()
    if "could be as low as" not in words and number not in words:
        wrong.append(f"the headline has another factor than {number}: {words}")
    least = verdict["required_safety_factor"]
    begins = "meets the required safety factor" if least != 1 else verdict["answer"]
    if verdict["answer"] == "fails":
        begins = "below the required safety factor" if least != 1 else FAILS[verdict["mode"]]
    elif verdict["answer"] == "undecided":
        begins = "undecided"
    asked = least == 1 and re.match(r"(meets|below) the required safety factor of 1:", words)
    if not words.startswith(begins) and not asked:
        wrong.append(f"the headline does not begin with {begins!r}: {words}")
    return wrong


def _table(summary: dict, said: str) -> list[str]:
    wrong = []
    for case, result in summary["results"].items():
        row = next((line.split() for line in said.splitlines() if line.split()[:1] == [case]), None)
        factor = result["min_safety_factor"]
        if row is None or {printed(factor * (1 + by)) for by in (-_ROUNDED, 0, _ROUNDED)}.isdisjoint(row):
            wrong.append(f"the table has no {printed(factor)} for {case}: {row}")
    return wrong


def _report(summary: dict, page: str) -> list[str]:
    verdict = summary["survival"]
    words = verdict["text"][0].upper() + verdict["text"][1:]
    wrong = [] if words in " ".join(page.split()) else [f"the report does not say: {words}"]
    plain, required = REPORTED[verdict["answer"]]
    title = plain if verdict["required_safety_factor"] == 1 else required
    if title not in page:
        wrong.append(f"the report has no title {title}")
    return wrong


def _exit_code(summary: dict, code: int, min_safety: float | None) -> list[str]:
    below = min_safety is not None and summary["survival"]["answer"] in ("fails", "undecided")
    expected = 5 if not summary["trusted"] else 6 if below else 0
    return [] if code == expected else [f"exit code {code} where the verdict asks for {expected}"]


def _studio(summary: dict, study: Study) -> list[str]:
    shown, verdict = fresh(study).figures, summary["survival"]
    if verdict["mode"] in {*FLOWS.values(), "collapse"}:  # the studio ends at first yield
        return []
    known = getattr(shown, shown.governs).factor
    mode = "bolts" if verdict["mode"] in BOLTS else verdict["mode"]
    wrong = []
    if shown.governs != mode:
        wrong.append(f"the studio is governed by {shown.governs}, the run by {mode}")
    for own, other in ((known, "safety_factor"), (known.low, "safety_factor_low")):
        if not math.isclose(own, verdict[other], rel_tol=_ROUNDED):
            wrong.append(f"the studio's {other} is {float(own):.9g}, the run has {verdict[other]:.9g}")
    return wrong


def _limits(summary: dict, study: Study) -> list[str]:
    verdict, found = summary["survival"], limits(study)
    least = min(every_factor(summary, elastic=True)) / verdict["required_safety_factor"]
    if found.largest_rpm is None or found.largest_rpm.mode == "collapse" or abs(least - 1) < NEAR:
        return []
    inside = (found.largest_rpm.safe_from or 0.0) <= summary["rpm"] <= found.largest_rpm.value
    if inside != (least > 1):
        end = f"{found.largest_rpm.value:.0f} rpm, the run has {summary['rpm']:g} rpm and {least:.3f}"
        return [f"fea limits ends at {end} of the required factor"]
    return []
