"""`fea export`."""

import sys
from pathlib import Path

from fea.base.choices import UnitSystem
from fea.cli.options import USUAL, Printing, Threads, print_written


def export(run: Path, file: Path, *, printing: Printing = USUAL) -> None:
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
        print_written(made.files)
        for note in made.notes:
            sys.stdout.write(f"Note: {note}.\n")

    printing.show(made, table)


def report(
    run: Path, *, units: UnitSystem | None = None, threads: Threads = None, printing: Printing = USUAL
) -> None:
    """Write the report of an earlier run: the whole analysis in one file, with the rod in 3-D.

    Parameters
    ----------
    run
        The folder of a run, such as results/leon-2001-6000rpm, or that of a run at several speeds. The
        report is report.html in the folder of each speed.
    units
        Units that are shown: si or us; default: those of the run.
    """
    from fea.machine.threads import limit_threads

    limit_threads(threads)

    from fea.apps.export_run import report_run
    from fea.machine.clock import stages
    from fea.output.target import near

    with stages(silent=printing.silent) as listener:
        reports = report_run(run, listener, units)
    printing.show({"files": reports}, lambda: None, written=map(near, reports))


def view(
    file: Path, *, field: str | None = None, out: Path | None = None, units: UnitSystem = UnitSystem.SI
) -> None:
    """Draw a result: a load case, the envelope of the crank cycle, or a mode; or open a report.

    Parameters
    ----------
    file
        The .vtu file of a run or of `fea modes`; or a report, report.html, which your browser opens.
    field
        Field to draw. Load case: von_mises, principal_1, principal_3, safety_factor or displacement;
        envelope.vtu: also mean, amplitude, fatigue_safety_factor or crossland_safety_factor; modes: mode_1,
        mode_2, …. Default: the first of these that the file has.
    out
        The .png file to write; default: next to the result.
    units
        Units of the picture: si or us.
    """
    if file.suffix.lower() == ".html":
        from fea.output.report.page import open_report
        from geometry.errors import require

        for option, value in (("--field", field), ("--out", out)):
            rule = "cannot be used with a report, which shows every field"
            require(value is None, option, None if value is None else str(value), rule, "Leave it out.")
        open_report(file)
        sys.stdout.write(f"Opened {file}\n")
        return
    from fea.output.pictures.picture import picture_of
    from fea.output.target import require_target
    from fea.output.units import shown_in

    require_target("--out", out, (".png",))
    with shown_in(units):
        picture = picture_of(file, out or file.with_suffix(".png"), field)
    print_written([picture])
