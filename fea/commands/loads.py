"""`fea loads`."""

import sys
from pathlib import Path
from typing import Literal

from fea.study.study import DEFAULT_STUDY, Study


def loads(
    study: str = DEFAULT_STUDY,
    *,
    rpm: str | None = None,
    cylinders: Literal["one", "all"] = "one",
    csv: Path | None = None,
    plot: Path | None = None,
    json: bool = False,
    quiet: bool = False,
) -> None:
    """Forces over the crank cycle, without a mesh.

    Parameters
    ----------
    study
        A shipped study (leon-2001, columba-2022, molina-2024, …) or a TOML file.
    rpm
        Engine speeds, rpm: one (6000), a list (800,3000,6000) or from:to:step (800:9000:200).
    cylinders
        The first cylinder, or all with their phase offsets and the engine's sums.
    csv
        Write the cycle to this .csv file, a row a degree.
    plot
        Draw the cycle into this file (.png, .pdf, .svg).
    json
        Print extremes and means as JSON and nothing else.
    quiet
        Print nothing.
    """
    from fea.analysis.study_forces import study_forces
    from fea.output.target import require_target
    from fea.study.flags import Flags
    from fea.study.study import load_study

    require_target("--csv", csv, (".csv",))
    require_target("--plot", plot, (".png", ".pdf", ".svg"))
    asked = Flags(rpm=rpm).applied(load_study(study))
    _keep_trace(asked, csv)
    reports = study_forces(asked, every_cylinder=cylinders == "all")
    if csv is not None:
        from fea.analysis.force_report import stacked
        from fea.output.forces_csv import write_forces_csv

        write_forces_csv(csv, stacked(reports))
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
    """Refuse to write the cycle over the study's own pressure trace."""
    from geometry.invalid import require

    own = study.engine is not None and csv is not None and Path(study.engine.gas) == csv.resolve()
    require(not own, "--csv", str(csv), "is the study's pressure trace", "Name another file.")
