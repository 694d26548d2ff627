"""`fea rod`, `fea modes` and `fea loads`: the rod without its loads, and these without a mesh."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from fea.cli.options import FILE_FLAGS, USUAL, Printing, StudyName, load_with_flags, one_or_all, takes
from fea.machine.exit_codes import CHECK_FAILED
from fea.machine.system import replaced
from fea.output.folder import require_target, write_columns, write_text
from fea.output.terminal.rod import print_forces, print_modes, print_rod
from fea.output.units import shown_in
from fea.study.flags import NO_FLAGS, Flags
from fea.study.rod_table import RodTable
from fea.study.study import DEFAULT_STUDY
from geometry.errors import require

_PLOTS = (".png", ".pdf", ".svg")
_STEP = (".step", ".stp")
_SIZE = "Element size, mm; default: 1/28 of the rod's length, smaller on fillets, bores and webs."


@takes("units", *FILE_FLAGS, size=_SIZE)
def rod(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    step: Path | None = None,
    screenshot: bool = False,
    fit: str | None = None,
    mass_kg: float | str | None = None,
    center_of_gravity_mm: float | str | None = None,
    inertia_kg_m2: float | str | None = None,
    out: Path | None = None,
    printing: Printing = USUAL,
) -> int:
    """Show mass properties and sections of the rod; export STEP; fit dimensions to a mass.

    Parameters
    ----------
    step
        Write the whole solid to this STEP file.
    screenshot
        Save a picture of the meshed rod as results/STUDY-rod.png, or as --out says.
    fit
        Dimensions to adjust until the rod meets the targets below (or those in [rod]): keys separated by
        commas, such as shank_width_mm,web_thickness_mm. Prints the study with the fitted rod, and exits with
        code 5 if a target is missed.
    mass_kg
        Target mass for --fit, kg, or with its unit.
    center_of_gravity_mm
        Target centre of gravity for --fit, mm from the crank pin.
    inertia_kg_m2
        Target moment of inertia for --fit, kg m², about the pin-parallel axis through the centre of gravity.
    out
        File to write: a picture of the meshed rod (.png), its solid (.step, .stp), or with --fit the study
        with the fitted rod (.toml).
    """
    require_target("--out", out, (".toml",) if fit is not None else (".png", *_STEP))
    loaded = load_with_flags(study, flags)

    from fea.analysis.rod_report import fitted, rod_report

    if fit is not None:
        table, best = fitted(loaded, fit.split(","), mass_kg, center_of_gravity_mm, inertia_kg_m2)
        outcome = {"met": best.met, "residuals": best.residuals, "at_limit": best.at_limit}
        text = f"# {best.text()}\n{replace(loaded, rod=table).text()}"
        if out is not None:
            write_text(out, text)
        said = text if out is None else f"{best.text()}\n"
        printing.show(outcome | {"rod": vars(best.rod)}, lambda: sys.stdout.write(said), written=(out,))
        if not best.met:
            sys.stderr.write(f"fea: {best.text()}. The printed rod comes closest to the targets\n")
        return 0 if best.met else CHECK_FAILED

    targets = {"mass": mass_kg, "center-of-gravity": center_of_gravity_mm, "inertia": inertia_kg_m2}
    remedy = "Name the dimensions to adjust with --fit."
    for name, target in targets.items():
        require(target is None, f"target {name}", target, "has no effect without --fit", remedy)
    require_target("--step", step, _STEP)
    png = None if out is None or out.suffix.lower() in _STEP else out
    figures, mesh = rod_report(loaded)
    written: list[Path] = []
    solids = [path for path in (step, None if png else out) if path is not None]
    if solids:
        _write_solids(loaded.rod, solids)
        written += solids
    if screenshot or png:
        from fea.output.pictures.picture import picture_of_mesh

        usual = Path("results") / f"{loaded.name}-rod.png"
        written.append(picture_of_mesh(mesh, loaded.name, png or usual))
    printing.show(figures, lambda: print_rod(figures), loaded, written)
    return 0


def _write_solids(rod: RodTable, paths: list[Path]) -> None:
    from geometry.cad.formats import step_file
    from geometry.session import session

    with session():
        content = step_file(rod.solid())
    for path in paths:
        with replaced(path) as place:
            place.write_bytes(content)


@takes("rpm", *FILE_FLAGS, size=_SIZE)
def modes(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    count: int = 6,
    vtu: Annotated[Path | None, Parameter(name=["--vtu", "--out"])] = None,
    printing: Printing = USUAL,
) -> int:
    """Compute the free-free vibration modes and the engine orders that excite them.

    Parameters
    ----------
    count
        Number of elastic modes; the six rigid-body modes are not counted.
    vtu
        Write the mode shapes to this .vtu file, which `fea view` can draw.
    """
    from fea.analysis.modes import modes_report

    require_target("--vtu", vtu, (".vtu",))
    report = modes_report(load_with_flags(study, flags), count)
    figures = report.figures()
    if vtu is not None:
        from fea.output.vtu import write_vtu

        write_vtu(vtu, report.mesh, report.shapes)
    printing.show(figures, lambda: print_modes(figures), written=(vtu,))
    return 0 if report.trusted else CHECK_FAILED


@takes("rpm", "engine", "units", *FILE_FLAGS)
def loads(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    cylinders: Literal["one", "all"] = "one",
    csv: Path | None = None,
    plot: Path | None = None,
    out: Path | None = None,
    printing: Printing = USUAL,
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
    out
        The same as --csv or --plot, by the ending of the file.
    """
    from fea.analysis.forces import stacked, study_forces

    require_target("--out", out, (".csv", *_PLOTS))
    if out is not None:
        table = out.suffix.lower() == ".csv"
        rule, remedy = "names the same file again", "Give one of --out, --csv and --plot for each file."
        require((csv if table else plot) is None, "--out", str(out), rule, remedy)
        csv, plot = (out, plot) if table else (csv, out)
    require_target("--csv", csv, (".csv",))
    require_target("--plot", plot, _PLOTS)
    loaded = load_with_flags(study, flags)
    same = loaded.engine is not None and csv is not None and Path(loaded.engine.gas) == csv.resolve()
    rule = "is the study's own pressure trace, which must not be overwritten"
    require(not same, "--csv", str(csv), rule, "Name another file.")
    reports = study_forces(loaded, every_cylinder=cylinders == "all")
    if csv is not None:
        write_columns(csv, stacked(reports))
    if plot is not None:
        from fea.output.plots.forces import plot_forces

        with shown_in(loaded.output.units):
            plot_forces(plot, reports, loaded.name)
    figures = one_or_all([report.figures(loaded.name) for report in reports])
    printing.show(figures, lambda: print_forces(reports, loaded.name), loaded, (csv, plot))
