"""`fea loads`."""

import sys
from pathlib import Path
from typing import Literal

from fea.study.study import DEFAULT_STUDY, Study


def loads(
    study: str = DEFAULT_STUDY,
    *,
    rpm: str | None = None,
    engine: str | None = None,
    cylinders: Literal["one", "all"] = "one",
    csv: Path | None = None,
    plot: Path | None = None,
    json: bool = False,
    quiet: bool = False,
) -> None:
    """Compute the forces over the crank cycle, without a mesh.

    Parameters
    ----------
    study
        A shipped study (leon-2001, columba-2022, molina-2024, …) or a TOML file.
    rpm
        Engine speeds, rpm: one (6000), a list (800,3000,6000) or from:to:step (800:9000:200).
    engine
        Engine of the library in place of the study's: toyota-2jz, jeep-4.0, …; any other name lists all.
    cylinders
        The first cylinder only, or all cylinders with their phase offsets and the sums of the engine.
    csv
        Write the cycle to this .csv file, one row per degree.
    plot
        Plot the cycle to this file (.png, .pdf, .svg).
    json
        Print extreme and mean values as JSON and nothing else.
    quiet
        Print nothing.
    """
    from fea.output.target import require_target
    from fea.run.study_forces import study_forces
    from fea.study.flags import Flags
    from fea.study.study import load_study

    require_target("--csv", csv, (".csv",))
    require_target("--plot", plot, (".png", ".pdf", ".svg"))
    asked = Flags(rpm=rpm, engine=engine).applied(load_study(study))
    _keep_trace(asked, csv)
    reports = study_forces(asked, every_cylinder=cylinders == "all")
    if csv is not None:
        from fea.output.columns_csv import write_columns
        from fea.run.forces import stacked

        write_columns(csv, stacked(reports))
    if plot is not None:
        from fea.output.plots.forces import plot_forces

        plot_forces(plot, reports, asked.name)
    if json:
        from fea.output.json_file import json_text

        figures = [report.figures(asked.name) for report in reports]
        sys.stdout.write(json_text(figures[0] if len(figures) == 1 else figures))
    elif not quiet:
        from fea.output.terminal.forces import print_forces

        print_forces(reports, asked.name)
        for path in filter(None, (csv, plot)):
            sys.stdout.write(f"Wrote {path}\n")


def _keep_trace(study: Study, csv: Path | None) -> None:
    """Refuse to overwrite the study's own pressure trace."""
    from geometry.errors import require

    own = study.engine is not None and csv is not None and Path(study.engine.gas) == csv.resolve()
    rule = "is the study's own pressure trace, which must not be overwritten"
    require(not own, "--csv", str(csv), rule, "Name another file.")
