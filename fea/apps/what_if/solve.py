"""What is solved beside a run for its report, at the cost of one or two runs."""

from contextlib import suppress
from dataclasses import replace
from typing import TypeVar

from fea.analysis.result import Change, RunResult, WhatIf
from fea.apps.what_if.assumed import assumed_changes
from fea.apps.what_if.draft import Draft
from fea.apps.what_if.remedies import bolt_remedy, dimension_remedy, steel_remedy
from fea.judge.safety_factor import SurvivalAnswer
from fea.machine.clock import Clock
from fea.output.report.advice import Advice
from fea.output.report.sheet import place_that_fails
from fea.output.stored_run import StoredRun
from fea.solid.errors import ContactError, SingularMatrixError, UnderconstrainedError
from fea.study.pin_models import FILM
from geometry.errors import GeometryError, InvalidValue
from mesh.tetmesh import MeshError

AnyRun = TypeVar("AnyRun", RunResult, StoredRun)
# What may keep a change from being solved; the report does without it.
_REFUSALS = (
    InvalidValue, GeometryError, MeshError, ContactError, SingularMatrixError, UnderconstrainedError
)  # fmt: skip


def with_what_if(run: AnyRun, clock: Clock) -> AnyRun:
    """Return a run with what its assumptions change and, if it fails, with what would make it pass.

    Assumptions and sensitivities are solved on a coarse mesh; the remedy is a whole run. Of a rod on oil
    films, and where a solution is refused, there is none.
    """
    if run.summary.model.pressure == FILM:
        return run
    with clock("what if"):
        return replace(run, what_if=_solved(run))


def _solved(run: RunResult | StoredRun) -> WhatIf:
    study, summary, found, remedies = run.study, run.summary, list[Change](), list[str]()
    place, mode = place_that_fails(summary), summary.survival.mode
    fails = summary.survival.answer in {SurvivalAnswer.FAILS, SurvivalAnswer.UNDECIDED}
    with suppress(*_REFUSALS):
        draft = Draft(study, summary, alone="shank" in place)
        for change in assumed_changes(draft, summary, place):
            found.append(change)
        if fails and study.assembly is not None and mode.endswith(("bolts", "joint")):
            remedies.append(bolt_remedy(study, summary)[0])
        elif fails:
            text, passes = dimension_remedy(draft, summary, place)
            remedies += [text] * bool(text)
            if not passes and (steel := Advice(run).steel()) is not None:
                remedies.append(steel_remedy(study, steel, summary)[0])
    return WhatIf(tuple(found), tuple(remedies))
