"""`fea run`."""

import sys
from typing import TYPE_CHECKING

from fea.cli import options
from fea.machine.exit_codes import CHECK_FAILED, MACHINE, UNSAFE
from fea.study.flags import NO_FLAGS, Flags
from fea.study.study import DEFAULT_STUDY

if TYPE_CHECKING:
    from fea.analysis.figures import Summary


@options.takes()
def run(
    study: options.StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    threads: options.Threads = None,
    printing: options.Printing = options.USUAL,
    verbose: options.Verbose = False,
) -> int:
    """Analyse a rod: stresses and safety factors at the peaks of the crank cycle."""
    asked = options.asked_for(study, flags, threads)

    from fea.apps.run_study import AFTER_THE_MESH, run_study
    from fea.machine.clock import stages
    from fea.output.target import near

    ahead = AFTER_THE_MESH if printing.silent else (*AFTER_THE_MESH, "fea.output.terminal.run")
    hint = "--draft ends with the first mesh, a larger --tolerance with a coarser one"
    with stages(silent=printing.silent, hint=hint) as listener:
        reports = run_study(asked, listener, ahead)
    summaries = [report.summary for report in reports]

    def table() -> None:
        from fea.output.terminal.run import print_runs

        print_runs([(report.folder, report.summary) for report in reports], verbose=verbose)

    films = (near(report.film) for report in reports if report.film)
    printing.show(options.one_or_all(summaries), table, asked, films)
    for text in dict.fromkeys(report.without_pictures for report in reports if report.without_pictures):
        sys.stderr.write(f"fea: {text}\n")
    code = verdict(summaries, asked.analysis.min_safety)
    return MACHINE if code == 0 and any(report.without_pictures for report in reports) else code


def verdict(summaries: "list[Summary]", min_safety: float | None) -> int:
    """Exit code of finished runs: a failed check takes precedence over a low safety factor."""
    from fea.judge.safety_factor import Answer

    if not all(summary.trusted for summary in summaries):
        return CHECK_FAILED
    unsafe = {Answer.UNDECIDED, Answer.FAILS}
    if min_safety is not None and any(Answer(summary.survival.answer) in unsafe for summary in summaries):
        return UNSAFE
    return 0
