"""What is solved beside a run for its report, at about the cost of the run."""

from fea.analysis.result import Change, WhatIf
from fea.apps.what_if.remedies import Draft, assumed_changes, bolt_remedy, dimension_remedy, steel_remedy
from fea.judge.safety_factor import SurvivalAnswer
from fea.machine.clock import Clock
from fea.output.report.advice import Advice
from fea.output.report.sheet import place_that_fails
from fea.output.stored_run import Run
from fea.solid.errors import ContactError, SingularMatrixError, SolverUnavailableError, UnderconstrainedError
from fea.study.pin_models import FILM
from geometry.errors import GeometryError, InvalidValue
from mesh.tetmesh import MeshError

# What may keep something from being solved again; a report does without it.
REFUSALS = (
    InvalidValue, GeometryError, MeshError, ContactError, SingularMatrixError, SolverUnavailableError,
    UnderconstrainedError,
)  # fmt: skip


def what_if(run: Run, clock: Clock) -> WhatIf:
    """Return what a run's assumptions change and, if it fails, what would make it pass.

    Assumptions and sensitivities are solved on a coarse mesh; a remedy is checked by a whole run. Of a rod on
    oil films, and where a solution is refused, there is none, and the reason.
    """
    study, summary, found, remedies = run.study, run.summary, list[Change](), list[str]()
    place, mode = place_that_fails(summary), summary.survival.mode
    fails = summary.survival.answer in {SurvivalAnswer.FAILS, SurvivalAnswer.UNDECIDED}
    if summary.model.pressure == FILM:
        return WhatIf(left_out="Other assumptions are not solved for a rod on oil films.")
    left_out = ""
    with clock("what if"):
        try:
            draft = Draft(study, summary, alone="shank" in place)
            found += assumed_changes(draft, summary, place)
            if fails and study.assembly is not None and mode.endswith(("bolts", "joint")):
                remedies.append(bolt_remedy(study, summary))
            elif fails:
                text, passes = dimension_remedy(draft, summary, place)
                remedies += [text] * bool(text)
                if not passes and (steel := Advice(run).steel()) is not None:
                    text, passes = steel_remedy(study, steel, summary)
                    remedies.insert(0 if passes else len(remedies), text)
        except REFUSALS as error:
            left_out = f"Other assumptions were not all solved: {error}"
    return WhatIf(tuple(found), tuple(remedies), left_out)
