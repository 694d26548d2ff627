"""Commands for many rods: `fea sweep`, `optimise`, `limits` and `studio`; and `bolts` and `compare`."""

import re
import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from fea.base.choices import UnitSystem
from fea.cli.options import (
    FILE_FLAGS,
    USUAL,
    Printing,
    StudyName,
    Threads,
    load_with_flags,
    print_written,
    takes,
)
from fea.judge.safety_factor import SurvivalAnswer
from fea.machine.clock import progress_line, stages
from fea.machine.exit_codes import CHECK_FAILED, MACHINE, UNSAFE
from fea.machine.threads import limit_threads
from fea.output.folder import near, require_target
from fea.output.terminal.prose import print_lines, terminal
from fea.output.units import in_heading, in_rows, shown_in
from fea.study.flags import NO_FLAGS, Flags
from fea.study.option_tables import OptimiseTable, parse_free
from fea.study.study import DEFAULT_STUDY
from fea.study.tables import number_of
from geometry.errors import require, require_number, require_positive

if TYPE_CHECKING:
    from fea.apps.limits.figures import LimitsFigures
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

    loaded = load_sweep(file)
    if study is not None:
        sys.stdout.write(study_text(loaded, study))
        return 0
    require_extra()
    from fea.apps.sweep.run_sweep import run_sweep

    with shown_in(units):
        report = run_sweep(
            loaded,
            Path("results") / loaded.name if out is None else out,
            workers=workers,
            address=cluster,
            retry_failed=retry_failed,
            minutes=limit_minutes,
            silent=printing.silent,
        )
    printing.show(report, lambda: _print_sweep(report))
    return CHECK_FAILED if report.failed or report.untrusted else 0


def _print_sweep(report: "SweepReport") -> None:
    done = f"{report.done} rows done, {report.computed} rods computed now"
    lines = [f"{done}; {report.failed} failed, {report.untrusted} not to be trusted"]
    often = sorted(report.reasons.items(), key=lambda item: -item[1])[:_MOST_REASONS]
    lines += [f"  {count} ×: {reason}" for reason, count in often]
    if report.reasons:
        lines.append("Failed rods are tried again with --retry-failed.")
    for chance in report.statistics.probabilities:
        bounds = f"{chance.low:.3g} and {chance.high:.3g}"
        lines.append(f"P({chance.name} < 1) = {chance.estimate:.3g}, 95 % between {bounds}")
    print_lines(terminal(), lines)
    print_written(near(file) for file in sorted(report.folder.glob("[rs]*")))


@takes(
    "engine",
    "material",
    "units",
    min_safety="Required safety factor against yielding, fatigue and buckling; default: that of the study, "
    "or 1.",
    rpm="Engine speeds to survive: one (6000), a list (800,3000,6000) or from:to:step (800:9000:200).",
    size="Element size of the search, mm, in place of a refined mesh: faster, with wider error bars. The "
    "last mesh is refined all the same.",
    tolerance="Error bar to which meshes are refined, percent; default: 2.",
)
def optimise(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    free: list[str] | None = None,
    evaluations: int | None = None,
    min_film_um: float | str | None = None,
    min_hours: float | None = None,
    out: Path | None = None,
    threads: Threads = None,
    printing: Printing = USUAL,
) -> int:
    """Find the lightest rod that meets the required safety factors, its dimensions free between bounds.

    Parameters
    ----------
    free
        A dimension and its bounds, mm: web_thickness_mm=3:7; repeat it for more. Default: [optimise] of the
        study, or else shank, web, flanges and rings, each from 0.6 to 1.4 times what it is.
    evaluations
        Most meshes to be solved in the search; default: 150.
    min_film_um
        Smallest oil film of the big end, in µm or with its unit, less its error bar, that the rod must keep
        over the crank cycle at each speed, as [film] says; most designs are judged by a coarse grid, the last
        rod by the full one.
    min_hours
        Hours that the rod must last at each speed, on the S–N line of its material or one assumed from its
        strengths, in place of a safety factor against fatigue.
    out
        Directory of the results; default: results/STUDY-optimised. Only an earlier search is ever replaced.
    """
    loaded = load_with_flags(study, flags, threads)
    table = loaded.optimise or OptimiseTable()
    if free:
        table = replace(table, free=parse_free(free))
    if evaluations is not None:
        table = replace(table, evaluations=evaluations)
    if min_film_um is not None:
        table = replace(table, min_film_um=number_of("--min-film-um", min_film_um, "min_film_um"))
    if min_hours is not None:
        table = replace(table, min_hours=min_hours)
    loaded = replace(loaded, optimise=table)
    loaded.require_plausible()

    from fea.apps.optimise.figures import print_table
    from fea.apps.optimise.run_optimise import optimise as optimised

    folder = Path("results") / f"{loaded.name}-optimised" if out is None else out
    silent, first = printing.silent, "meshing the first rod"
    with shown_in(loaded.output.units), progress_line(first, silent=silent) as show:
        figures, complaint = optimised(loaded, folder, show)
    printing.show(figures, lambda: print_table(figures, folder), loaded)
    if complaint:
        sys.stderr.write(f"fea: {complaint}\n")
    if not figures.trusted:
        return CHECK_FAILED
    if not figures.holds:
        return UNSAFE
    return MACHINE if complaint else 0


@takes(
    "engine",
    "film",
    "material",
    "pressure",
    "size",
    "tolerance",
    "units",
    *FILE_FLAGS,
    min_safety="Required safety factor; default: that of the study, or 1.",
    rpm="Operating speeds, rpm; the largest peak pressure is found at the highest.",
)
def limits(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    min_rpm: float | str | None = None,
    min_boost: float | str | None = None,
    duty: bool = False,
    permanent_set: bool = False,
    out: Path | None = None,
    threads: Threads = None,
    printing: Printing = USUAL,
) -> int:
    """Find the highest speed and peak pressure that a rod survives, and how it fails beyond.

    Parameters
    ----------
    min_rpm
        Speed, in rpm or with its unit, that the rod must reach at the study's load, less the error bar;
        otherwise exit code 6.
    min_boost
        Boost, in bar or with its unit, that it must survive at this speed, less the error bar; otherwise
        exit code 6.
    duty
        Compute the hours of life of a rod of separate parts, too, as with [duty] in the study.
    permanent_set
        Follow plastic flow to the loads that leave the rod deformed beyond its limits, as with [overload] in
        the study; takes minutes.
    out
        Directory of the results; default: results/STUDY-limits. Only an earlier run is ever replaced.
    """
    loaded = load_with_flags(study, flags, threads)
    least_rpm = number_of("--min-rpm", min_rpm, "rpm")
    least_boost = number_of("--min-boost", min_boost, "boost_bar")
    if min_rpm is not None:
        require_positive("--min-rpm", least_rpm)
    if min_boost is not None:
        require_number("--min-boost", least_boost)

    from fea.apps.limits.run_limits import limits as find_limits

    folder = Path("results") / f"{loaded.name}-limits" if out is None else out
    with shown_in(loaded.output.units), stages(silent=printing.silent) as listener:
        figures = find_limits(
            loaded, folder, listener, at_rpm=least_rpm, duty=duty, permanent_set=permanent_set
        )
    reached = figures.reaches(least_rpm, least_boost)
    printing.show(figures, lambda: _print_limits(figures, folder, reached=reached), loaded)
    if not figures.trusted:
        return CHECK_FAILED
    return 0 if reached else UNSAFE


def _print_limits(figures: "LimitsFigures", folder: Path, *, reached: bool) -> None:
    short = "It does not reach what --min-rpm and --min-boost ask for, less the error bar: exit code 6."
    lines = [figures.text, *([] if reached else [short]), ""]
    if figures.table:
        head = figures.table_head
        rows = (map(in_heading, head), *in_rows(head, figures.table))
        lines += [
            f"{rpm:>6}  {safe:<24} {mode:<15} {'  '.join(f'{each:<16}' for each in plastic)}".rstrip()
            for rpm, safe, mode, *plastic in rows
        ]
        lines += [""]
    lines += [str(note) for note in figures.notes[:6]]
    lines += [f"Written to {near(folder)} ({len(figures.files)} files): {', '.join(figures.files)}."]
    print_lines(terminal(), lines)


_LARGEST_PORT = 65_535


@takes("engine", "material", "rpm", "pressure", "size", "tolerance", *FILE_FLAGS)
def studio(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    port: int = 0,
    no_browser: bool = False,
    out: Path | None = None,
    threads: Threads = None,
) -> None:
    """Change a rod in the browser and see at once what it does to mass, stress and safety factors.

    Parameters
    ----------
    port
        Port of the page on this machine, which nobody else can open; default: any that is free.
    no_browser
        Print the address of the page, but do not open it.
    out
        Directory of the designs and variants; default: results/STUDY-studio.
    """
    require(0 <= port <= _LARGEST_PORT, "--port", port, f"must lie between 0 and {_LARGEST_PORT}")
    loaded = load_with_flags(study, flags, threads)
    loaded.require_loading()

    if find_spec("websockets") is None:
        raise ImportError("fea studio needs websockets, not installed here: pip install websockets")
    from fea.apps.studio.run_studio import run_studio

    def opened(address: str) -> None:
        sys.stdout.write(f"{address}\n")
        sys.stdout.flush()
        if not no_browser:
            import webbrowser

            webbrowser.open(address)

    folder = Path("results") / f"{loaded.name}-studio" if out is None else out
    run_studio(loaded, folder, port, opened)


@takes(
    *("engine", "material", "size", "tolerance", "units", *FILE_FLAGS),
    rpm="Engine speed at which the bolts are judged; of several the highest.",
)
def bolts(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    out: Path | None = None,
    threads: Threads = None,
    printing: Printing = USUAL,
) -> int:
    """Compare the bolts that fit a rod: preload, torque, stretch, and how the joint holds.

    Parameters
    ----------
    out
        A file for the table (.csv) or for all figures (.json).
    """
    require_target("--out", out, (".csv", ".json"))
    loaded = load_with_flags(study, flags, threads)

    from fea.apps.bolts.printed import print_bolts, write_bolts
    from fea.apps.bolts.run_bolts import bolts as compared

    with stages(silent=printing.silent) as listener:
        found = compared(loaded, listener)
    if out is not None:
        write_bolts(out, found)
    printing.show(found.rows, lambda: print_bolts(found), loaded, () if out is None else (near(out),))
    return 0 if found.trusted else CHECK_FAILED


Materials = Annotated[list[str] | None, Parameter(consume_multiple=True)]
_LONGEST = 80  # characters of the names of studies in the name of a page


@takes("cycle", "engine", "film", "min_safety", "pressure", "rpm", "size", "tolerance", "units")
def compare(
    *studies: str,
    flags: Flags = NO_FLAGS,
    material: Materials = None,
    same: bool = False,
    limits: bool = False,
    out: Path | None = None,
    threads: Threads = None,
    printing: Printing = USUAL,
) -> int:
    """Compare two to six studies or runs, or one study in several materials: what differs and what it does.

    Parameters
    ----------
    studies
        Shipped studies or TOML files, each of which is run at its highest speed, or folders that fea run
        wrote, which are taken as they are.
    material
        Two to six materials in which one study is compared.
    same
        Judge all by the engine, speed, pins, film and mesh settings of the first study.
    limits
        Find the highest speed and peak pressure of each, too; it takes some minutes.
    out
        The page to write (.html); default: results/compare-NAMES.html.
    """
    require_target("--out", out, (".html",), parents=True)
    limit_threads(threads)

    from fea.apps.compare.run_compare import compare as compared
    from fea.apps.compare.run_compare import named_designs
    from fea.apps.compare.tables import print_comparison, write_page

    designs = [each.changed(flags.applied) for each in named_designs(studies, material or ())]
    loaded = [each.study for each in designs]
    if all(each.run for each in designs):
        given = ", ".join(f"--{name.replace('_', '-')}" for name in flags.given() if name != "units")
        rule, remedy = f"are solved already, without {given}", "Name the study in a folder: study.toml."
        require(not given, "STUDY", " ".join(studies), rule, remedy)
    if out is None:
        names = "-".join(study.name for study in loaded)
        out = Path("results") / f"compare-{re.sub(r'[^A-Za-z0-9.]+', '-', names)[:_LONGEST]}.html"
    with stages(silent=printing.silent) as listener:
        found = compared(designs, listener, alike=same, limits=limits)
    shown = Flags(units=flags.given().get("units")).applied(loaded[0])
    with shown_in(shown.output.units):
        write_page(out, found)
    printing.show(found, lambda: print_comparison(found), shown, (near(out),))
    answers = {SurvivalAnswer(one.summary.survival.answer) for one in found.designs}
    if not found.trusted:
        return CHECK_FAILED
    asked = any(study.analysis.min_safety is not None for study in loaded)
    return UNSAFE if asked and answers & {SurvivalAnswer.FAILS, SurvivalAnswer.UNDECIDED} else 0
