"""`fea run`, and what becomes of a run: `fea report`, `fea export` and `fea view`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from fea.base.choices import UnitSystem
from fea.cli import options
from fea.judge.safety_factor import SurvivalAnswer
from fea.machine.clock import stages
from fea.machine.exit_codes import CHECK_FAILED, MACHINE, UNSAFE
from fea.machine.threads import limit_threads
from fea.output.folder import near, require_target
from fea.output.units import shown_in
from fea.study.flags import NO_FLAGS, Flags
from fea.study.study import DEFAULT_STUDY
from geometry.errors import require

if TYPE_CHECKING:
    from fea.analysis.summary_figures import Summary


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
    loaded = options.load_with_flags(study, flags, threads)

    from fea.apps.run_study import AFTER_THE_MESH, run_study

    ahead = AFTER_THE_MESH if printing.silent else (*AFTER_THE_MESH, "fea.output.terminal.run")
    hint = "--draft ends with the first mesh, a larger --tolerance with a coarser one"
    with stages(silent=printing.silent, hint=hint) as listener:
        reports = run_study(loaded, listener, ahead)
    summaries = [report.summary for report in reports]

    def table() -> None:
        from fea.output.terminal.run import print_runs

        print_runs([(report.folder, report.summary) for report in reports], verbose=verbose)

    films = (near(report.film) for report in reports if report.film)
    printing.show(options.one_or_all(summaries), table, loaded, films)
    for text in dict.fromkeys(report.without_pictures for report in reports if report.without_pictures):
        sys.stderr.write(f"fea: {text}\n")
    code = verdict(summaries, loaded.analysis.min_safety)
    return MACHINE if code == 0 and any(report.without_pictures for report in reports) else code


def verdict(summaries: "list[Summary]", min_safety: float | None) -> int:
    """Exit code of finished runs: a failed check takes precedence over a low safety factor."""
    if not all(summary.trusted for summary in summaries):
        return CHECK_FAILED
    unsafe = {SurvivalAnswer.UNDECIDED, SurvivalAnswer.FAILS}
    if min_safety is not None and any(
        SurvivalAnswer(summary.survival.answer) in unsafe for summary in summaries
    ):
        return UNSAFE
    return 0


def export(run: Path, file: Path, *, printing: options.Printing = options.USUAL) -> None:
    """Write a run for another program: a CalculiX deck with its loads, or its mesh with the results.

    Parameters
    ----------
    run
        The folder of a run at one speed, such as results/leon-2001-6000rpm.
    file
        The file to write. .inp: a deck for CalculiX and Abaqus with every load case as a step; .vtu, .vtk,
        .xdmf, .msh, .med: mesh and results; .bdf, .nas: the mesh; .stl, .ply: its surface.
    """
    from fea.apps.export_run import export_run

    made = export_run(run, file)

    def table() -> None:
        options.print_written(made.files)
        for note in made.notes:
            sys.stdout.write(f"Note: {note}.\n")

    printing.show(made, table)


def report(
    run: Path,
    *,
    out: Path | None = None,
    sheet: bool = False,
    pdf: bool = False,
    units: UnitSystem | None = None,
    threads: options.Threads = None,
    printing: options.Printing = options.USUAL,
) -> None:
    """Write the report of an earlier run: the whole analysis in one file, with the rod in 3-D.

    Parameters
    ----------
    run
        The folder of a run, such as results/leon-2001-6000rpm, or that of a run at several speeds. The
        report is report.html in the folder of each speed.
    out
        The .html file to write, of a run at one speed; default: report.html or sheet.html in its folder.
    sheet
        Write its first page alone, the builder's sheet: sheet.html.
    pdf
        Print it as well, into report.pdf or sheet.pdf; needs Chromium, Chrome or Edge.
    units
        Units that are shown: si or us; default: those of the run.
    """
    require_target("--out", out, (".html",))
    limit_threads(threads)

    from fea.apps.export_run import report_run

    with stages(silent=printing.silent) as listener:
        reports = report_run(run, listener, units, out, sheet=sheet, pdf=pdf)
    printing.show({"files": reports}, lambda: None, written=map(near, reports))


def view(
    file: Path, *, field: str | None = None, out: Path | None = None, units: UnitSystem = UnitSystem.SI
) -> None:
    """Draw a result: what governs a run, a load case, the crank cycle, or a mode; or open a report.

    Parameters
    ----------
    file
        The folder of a run: what governs it is drawn and, at a terminal, opened; the .vtu file of a run or of
        `fea modes`; or a report, report.html, which your browser opens.
    field
        Field to draw. Load case: von_mises, principal_1, principal_3, safety_factor or displacement;
        envelope.vtu: also mean, amplitude, fatigue_safety_factor or crossland_safety_factor; modes: mode_1,
        mode_2, …. Default: the first of these that the file has.
    out
        The .png file to write, which is not opened; default: next to the result.
    units
        Units of the picture: si or us.
    """
    if file.suffix.lower() == ".html":
        from fea.output.report.page import open_report

        for option, value in (("--field", field), ("--out", out)):
            rule = "cannot be used with a report, which shows every field"
            require(value is None, option, None if value is None else str(value), rule, "Leave it out.")
        open_report(file)
        sys.stdout.write(f"Opened {file}\n")
        return
    from fea.output.pictures.picture import picture_of, picture_of_run

    require_target("--out", out, (".png",))
    if file.is_dir():
        with shown_in(units):
            picture, governs = picture_of_run(file, out, field)
        sys.stdout.write(f"{governs}\n")
        options.print_written([near(picture)])
        if out is None and sys.stdout.isatty():
            import webbrowser

            webbrowser.open(picture.resolve().as_uri())
        return
    with shown_in(units):
        picture = picture_of(file, out or file.with_suffix(".png"), field)
    options.print_written([picture])
