"""`fea run`."""

import sys
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from fea.machine.exit_codes import CHECK_FAILED, MACHINE, UNSAFE
from fea.study.flags import Flags
from fea.study.study import DEFAULT_STUDY

if TYPE_CHECKING:
    from fea.run.figures import Summary


def run(
    study: str = DEFAULT_STUDY,
    *,
    flags: Annotated[Flags, Parameter(name="*")] = Flags(),  # noqa: B008 - frozen
    threads: int | None = None,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Analyse a rod: stresses and safety factors at the peaks of the crank cycle.

    Parameters
    ----------
    study
        A shipped study (leon-2001, columba-2022, molina-2024, …) or a TOML file.
    threads
        Number of solver threads; default: all processors.
    json
        Print the summary as JSON and nothing else.
    quiet
        Print nothing.
    """
    from fea.machine.threads import limit_threads
    from fea.study.study import load_study

    limit_threads(threads)
    asked = flags.applied(load_study(study))

    from fea.apps.run_study import AFTER_THE_MESH, run_study
    from fea.machine.clock import stages

    ahead = AFTER_THE_MESH if quiet or json else (*AFTER_THE_MESH, "fea.output.terminal.run")
    with stages(silent=quiet or json) as listener:
        reports = run_study(asked, listener, ahead)
    summaries = [report.summary for report in reports]
    if json:
        from fea.output.json_file import json_text

        sys.stdout.write(json_text(summaries[0] if len(summaries) == 1 else summaries))
    elif not quiet:
        from fea.output.target import near
        from fea.output.terminal.run import print_runs

        print_runs([(report.folder, report.summary) for report in reports])
        for film in filter(None, (report.film for report in reports)):
            sys.stdout.write(f"Wrote {near(film)}\n")
    for complaint in dict.fromkeys(report.complaint for report in reports if report.complaint):
        sys.stderr.write(f"fea: {complaint}\n")
    code = verdict(summaries, asked.analysis.min_safety)
    return MACHINE if code == 0 and any(report.complaint for report in reports) else code


def verdict(summaries: "list[Summary]", min_safety: float | None) -> int:
    """Exit code of finished runs: a failed check takes precedence over a low safety factor."""
    from fea.run.survival import Answer

    if not all(summary.trusted for summary in summaries):
        return CHECK_FAILED
    if min_safety is not None and any(summary.survival.answer != Answer.SURVIVES for summary in summaries):
        return UNSAFE
    return 0
