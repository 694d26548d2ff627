"""`fea rod`."""

import sys
from pathlib import Path

from fea.study import DEFAULT_STUDY


def rod(
    study: str = DEFAULT_STUDY,
    *,
    size: float | None = None,
    step: Path | None = None,
    screenshot: bool = False,
    json: bool = False,
    quiet: bool = False,
) -> None:
    """The solid: mass properties and sections, STEP export, a picture.

    Parameters
    ----------
    study
        A shipped study (leon-2001, columba-2022, molina-2024, …) or a TOML file.
    size
        Element size, mm.
    step
        Write the whole solid as a STEP file.
    screenshot
        Draw the meshed rod: results/<study>-rod.png.
    json
        Print the figures as JSON and nothing else.
    quiet
        Print nothing.
    """
    from fea.flags import Flags
    from fea.study import load_study

    asked = Flags(size=size).applied(load_study(study))

    from fea.rod_report import rod_report

    report = rod_report(asked)
    written: list[Path] = []
    if step is not None:
        from geometry.session import session
        from geometry.step_file import export_step

        with session():
            export_step(asked.rod.solid(), step)
        written.append(step)
    if screenshot:
        from fea.output.picture import picture_of_mesh

        written.append(picture_of_mesh(report.mesh.whole.mesh, asked.name, Path("results")))
    figures = report.figures()
    if json:
        from fea.output.summary import json_text

        sys.stdout.write(json_text(figures))
    elif not quiet:
        from fea.output.rod_table import print_rod

        print_rod(figures)
        for path in written:
            sys.stdout.write(f"Wrote {path}\n")
