"""`fea loads`."""

from pathlib import Path
from typing import Literal

from fea.cli.options import FILE_FLAGS, Json, Quiet, StudyName, one_or_all, print_json, print_written, takes
from fea.study.flags import NO_FLAGS, Flags
from fea.study.study import DEFAULT_STUDY, load_study
from geometry.errors import require


@takes("rpm", "engine", "units", *FILE_FLAGS)
def loads(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    cylinders: Literal["one", "all"] = "one",
    csv: Path | None = None,
    plot: Path | None = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Compute the forces over the crank cycle, without a mesh.

    Parameters
    ----------
    cylinders
        The first cylinder only, or all cylinders with their phase offsets and the sums of the engine.
    csv
        Write the cycle to this .csv file, one row per degree.
    plot
        Plot the cycle to this file (.png, .pdf, .svg).
    """
    from fea.analysis.forces import study_forces
    from fea.output.target import require_target

    require_target("--csv", csv, (".csv",))
    require_target("--plot", plot, (".png", ".pdf", ".svg"))
    asked = flags.applied(load_study(study))
    same = asked.engine is not None and csv is not None and Path(asked.engine.gas) == csv.resolve()
    rule = "is the study's own pressure trace, which must not be overwritten"
    require(not same, "--csv", str(csv), rule, "Name another file.")
    reports = study_forces(asked, every_cylinder=cylinders == "all")
    from fea.output.units import shown_in

    if csv is not None:
        from fea.analysis.forces import stacked
        from fea.output.text import write_columns

        write_columns(csv, stacked(reports))
    if plot is not None:
        from fea.output.plots.forces import plot_forces

        with shown_in(asked.output.units):
            plot_forces(plot, reports, asked.name)
    if json:
        print_json(one_or_all([report.figures(asked.name) for report in reports]))
    elif not quiet:
        from fea.output.terminal.forces import print_forces

        with shown_in(asked.output.units):
            print_forces(reports, asked.name)
        print_written((csv, plot))
