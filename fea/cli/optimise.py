"""`fea optimise`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from fea.machine.exit_codes import CHECK_FAILED, MACHINE, UNSAFE
from fea.study.study import DEFAULT_STUDY

if TYPE_CHECKING:
    from fea.apps.optimise.figures import OptimiseFigures


def optimise(
    study: str = DEFAULT_STUDY,
    *,
    free: list[str] | None = None,
    min_safety: float | None = None,
    rpm: str | None = None,
    engine: str | None = None,
    material: str | None = None,
    size: float | None = None,
    tolerance: float | None = None,
    evaluations: int | None = None,
    out: Path | None = None,
    threads: int | None = None,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Find the lightest rod that holds: dimensions free between bounds, safety factors less their error bars.

    Parameters
    ----------
    study
        A shipped study (leon-2001, columba-2022, molina-2024, …) or a TOML file, with or without [optimise].
    free
        A dimension and its bounds, mm: web_thickness_mm=3:7; repeat it for more. Default: [optimise] of the
        study, or else shank, web, flanges and rings, each from 0.6 to 1.4 times what it is.
    min_safety
        Required safety factor against yielding, fatigue and buckling; default: that of the study, or 1.
    rpm
        Engine speeds that it must bear: one (6000), a list (800,3000,6000) or from:to:step (800:9000:200).
    engine
        Engine of the library in place of the study's: toyota-2jz, jeep-4.0, …; any other name lists all.
    material
        Material of the rod in place of the study's, by its name (a wrong one lists them all).
    size
        Element size of the search, mm, in place of a refined mesh: faster, with wider error bars. The last
        mesh is refined all the same.
    tolerance
        Error bar to which meshes are refined, percent; default: 2.
    evaluations
        Most meshes to be solved in the search; default: 150.
    out
        Directory of the results; default: results/STUDY-optimised. Only an earlier search is ever replaced.
    threads
        Number of solver threads; default: all processors.
    json
        Print the figures as JSON and nothing else.
    quiet
        Print nothing.
    """
    from dataclasses import replace

    from fea.machine.threads import limit_threads
    from fea.study.flags import Flags
    from fea.study.option_tables import OptimiseTable, parse_free
    from fea.study.study import load_study

    limit_threads(threads)
    flags = Flags(
        rpm=rpm, engine=engine, material=material, size=size, tolerance=tolerance, min_safety=min_safety
    )
    asked = flags.applied(load_study(study))
    table = asked.optimise or OptimiseTable()
    if free:
        table = replace(table, free=parse_free(free))
    if evaluations is not None:
        table = replace(table, evaluations=evaluations)
    asked = replace(asked, optimise=table)

    from fea.apps.optimise.run_optimise import optimise as optimised
    from fea.machine.clock import told

    folder = Path("results") / f"{asked.name}-optimised" if out is None else out
    with told("meshing the first rod", silent=quiet or json) as say:
        figures, complaint = optimised(asked, folder, say)
    if json:
        from fea.output.json_file import json_text

        sys.stdout.write(json_text(figures))
    elif not quiet:
        _print(figures, folder)
    if complaint:
        sys.stderr.write(f"fea: {complaint}\n")
    if not figures.trusted:
        return CHECK_FAILED
    if not figures.holds:
        return UNSAFE
    return MACHINE if complaint else 0


def _print(figures: "OptimiseFigures", folder: Path) -> None:
    from fea.apps.optimise.figures import print_table

    print_table(figures, folder)
