"""`fea sweep`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from fea.base.choices import UnitSystem
from fea.cli.options import USUAL, Printing, print_written
from fea.machine.exit_codes import CHECK_FAILED

if TYPE_CHECKING:
    from fea.apps.sweep.run_sweep import SweepReport

_MOST_REASONS = 10


def sweep(
    file: Path,
    *,
    workers: int | None = None,
    cluster: str | None = None,
    out: Path | None = None,
    retry_failed: bool = False,
    limit_minutes: float = 60.0,
    study: int | None = None,
    units: UnitSystem = UnitSystem.SI,
    printing: Printing = USUAL,
) -> int:
    """Compute many variants of a study: ranges, tolerances, the Pareto front, sensitivities.

    Parameters
    ----------
    file
        The sweep: a study, what varies in it, and how the designs are chosen.
    workers
        Number of workers on this machine, each a process with one thread (or OMP_NUM_THREADS of them);
        default: its physical cores.
    cluster
        Address of a Dask scheduler (tcp://host:8786), or a scheduler file, in place of this machine.
    out
        Directory of the results; default: results/SWEEP. An interrupted sweep resumes.
    retry_failed
        Compute failed rods again.
    limit_minutes
        Minutes that a rod may take; one that takes longer is ended and listed as failed.
    study
        Print the study of this row of the table, which fea run takes, and compute nothing.
    units
        Units of the report: si or us; the table is in those that its columns name.
    """
    from fea.apps.sweep.sweep_file import load_sweep, require_extra, study_text

    asked = load_sweep(file)
    if study is not None:
        sys.stdout.write(study_text(asked, study))
        return 0
    require_extra()
    from fea.apps.sweep.run_sweep import run_sweep
    from fea.output.units import shown_in

    with shown_in(units):
        report = run_sweep(
            asked,
            Path("results") / asked.name if out is None else out,
            workers=workers,
            address=cluster,
            retry_failed=retry_failed,
            minutes=limit_minutes,
            silent=printing.silent,
        )
    printing.show(report, lambda: _print(report))
    return CHECK_FAILED if report.failed or report.untrusted else 0


def _print(report: "SweepReport") -> None:
    from fea.output.target import near
    from fea.output.terminal.prose import print_lines, terminal

    said = f"{report.done} rows done, {report.computed} rods computed now"
    lines = [f"{said}; {report.failed} failed, {report.untrusted} not to be trusted"]
    often = sorted(report.reasons.items(), key=lambda item: -item[1])[:_MOST_REASONS]
    lines += [f"  {count} ×: {reason}" for reason, count in often]
    if report.reasons:
        lines.append("Failed rods are tried again with --retry-failed.")
    for one in report.statistics.probabilities:
        bounds = f"{one.low:.3g} and {one.high:.3g}"
        lines.append(f"P({one.name} < 1) = {one.estimate:.3g}, 95 % between {bounds}")
    print_lines(terminal(), lines)
    print_written(near(file) for file in sorted(report.folder.glob("[rs]*")))
