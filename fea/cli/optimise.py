"""`fea optimise` and `fea studio`."""

import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from fea.cli.options import FILE_FLAGS, USUAL, Printing, StudyName, Threads, asked_for, takes
from fea.machine.exit_codes import CHECK_FAILED, MACHINE, UNSAFE
from fea.study.flags import NO_FLAGS, Flags
from fea.study.option_tables import OptimiseTable, parse_free
from fea.study.study import DEFAULT_STUDY
from fea.study.tables import number_of
from geometry.errors import require


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
    out
        Directory of the results; default: results/STUDY-optimised. Only an earlier search is ever replaced.
    """
    asked = asked_for(study, flags, threads)
    table = asked.optimise or OptimiseTable()
    if free:
        table = replace(table, free=parse_free(free))
    if evaluations is not None:
        table = replace(table, evaluations=evaluations)
    if min_film_um is not None:
        table = replace(table, min_film_um=number_of("--min-film-um", min_film_um, "min_film_um"))
    asked = replace(asked, optimise=table)
    asked.require_plausible()

    from fea.apps.optimise.figures import print_table
    from fea.apps.optimise.run_optimise import optimise as optimised
    from fea.machine.clock import progress_line
    from fea.output.units import shown_in

    folder = Path("results") / f"{asked.name}-optimised" if out is None else out
    silent, first = printing.silent, "meshing the first rod"
    with shown_in(asked.output.units), progress_line(first, silent=silent) as show:
        figures, complaint = optimised(asked, folder, show)
    printing.show(figures, lambda: print_table(figures, folder), asked)
    if complaint:
        sys.stderr.write(f"fea: {complaint}\n")
    if not figures.trusted:
        return CHECK_FAILED
    if not figures.holds:
        return UNSAFE
    return MACHINE if complaint else 0


_LARGEST_PORT = 65_535


@takes("engine", "material", "rpm", "pressure", "size", "tolerance", *FILE_FLAGS)
def studio(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    port: int = 0,
    no_browser: bool = False,
    threads: Threads = None,
) -> None:
    """Change a rod in the browser and see at once what it does to mass, stress and safety factors.

    Parameters
    ----------
    port
        Port of the page on this machine, which nobody else can open; default: any that is free.
    no_browser
        Print the address of the page, but do not open it.
    """
    require(0 <= port <= _LARGEST_PORT, "--port", port, f"must lie between 0 and {_LARGEST_PORT}")
    asked = asked_for(study, flags, threads)
    asked.require_loading()

    if find_spec("websockets") is None:
        raise ImportError("fea studio needs websockets, not installed here: pip install websockets")
    from fea.apps.studio.run_studio import run_studio

    def opened(address: str) -> None:
        sys.stdout.write(f"{address}\n")
        sys.stdout.flush()
        if not no_browser:
            import webbrowser

            webbrowser.open(address)

    run_studio(asked, Path("results") / f"{asked.name}-studio", port, opened)
