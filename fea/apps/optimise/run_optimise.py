"""The job behind `fea optimise`: search the lightest rod, mesh it again, and write result and history."""

import time
from collections.abc import Callable
from dataclasses import replace
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fea.analysis.pipeline import refined_rod
from fea.analysis.result import run_result
from fea.apps.optimise.designs import Design, Designs, record
from fea.apps.optimise.figures import CheckedRod, OptimiseFigures, optimise_figures
from fea.apps.optimise.problem import FILM, MinimumFilm, Variables, constraints, required, variables
from fea.apps.optimise.search import USUAL, SearchResult, fewest, search
from fea.judge.cycle_life import life_line
from fea.judge.verdict import CAP
from fea.machine.clock import Clock, duration
from fea.output.folder import (
    OPTIMISED,
    PictureError,
    require_replaceable,
    run_folder,
    write_columns,
    write_text,
)
from fea.output.json_file import json_text
from fea.output.pictures.picture import draw_pictures
from fea.output.pictures.shown import Picture
from fea.output.plots.figure import new_figure, save
from fea.output.vtu import write_vtu
from fea.study.option_tables import OptimiseTable
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.errors import require
from mesh.tetmesh import TetMesh

STUDY, HISTORY, COURSE, RODS = "study.toml", "history.csv", "history.png", "rods.png"
FILES = (STUDY, OPTIMISED, HISTORY, COURSE, RODS)
YIELDING, FATIGUE = "safety_factor_node", "fatigue_safety_factor"
# Between the two rods in the picture, relative to their widths.
_APART = 1.15
# Of the last mesh, and of the meshes that the search moves, percent.
TOLERANCE = 2.0
# Rods that are meshed for the last check, where the first does not hold.
_CANDIDATES = 3
# Of the number of dimensions: meshes after which a search has usually settled.
_USUALLY = 7


def optimise(
    study: Study, folder: Path, show: Callable[..., None] = lambda _text, **_options: None
) -> tuple[OptimiseFigures, str]:
    """Search the lightest rod that meets the required factors, and write its study and the history.

    The folder is new, or that of an earlier search; `show` shows a progress line after each design. An
    interrupted search has left its designs beside the folder, and the next one resumes from them. Returned
    are the result, and why the picture of the rods is missing; empty where it is not. Raises `InvalidValue`:
    the rod has no dimensions, a value breaks a rule, or the evaluations are too few to decide anything;
    `OccupiedError`, `StorageError`: the folder cannot take the files; `GeometryError`, `MeshError`,
    `UnderconstrainedError`, `SingularMatrixError`: the rod cannot be drawn, meshed or solved.
    """
    require_replaceable(folder)
    clock = Clock()
    solved = search_study(study)
    free = variables(solved)
    table = study.optimise
    most = (None if table is None else table.evaluations) or USUAL
    rule = f"cannot decide {len(free.keys)} free dimensions, which take {fewest(len(free.keys))} at least"
    remedy = "Allow more with --evaluations, or free fewer dimensions."
    require(most >= fewest(len(free.keys)), "optimise.evaluations", most, rule, remedy)
    with record(folder, solved) as kept:
        if kept.count:
            show(f"resuming after {kept.count} designs of an interrupted search", lasting=True)
        designs = Designs(free, progress(show, most, len(free.keys)), record=kept)
        result = search(designs, free.start, most)
        show("meshing the first rod and the best one again")
        before = checked(free, result.first.x)
        best, after = _last(free, result)
        figures = optimise_figures(free, result, best, before, after, files=FILES, seconds=clock.total)
        with run_folder(folder) as part:
            complaint = write_files(part, figures, before, after)
    return figures, complaint


def search_study(study: Study) -> Study:
    """Return the study that the search solves: with the crank cycle, every case refined to the tolerance.

    Every case counts, since the peaks of both ends and of the shank are constraints of their own. Mass
    properties that the study gives are left out: they are those of its own rod. Raises `InvalidValue`: the
    rod is in separate parts, or comes from a mesh, a flaw has a place, or there can be no oil film where one
    is required.
    """
    rule = "cannot be combined with fea optimise: every design would take minutes"
    remedy = "Remove [assembly], then check the lighter rod with it: fea run."
    require(study.assembly is None, "[assembly]", None, rule, remedy)
    place = () if study.defect.flaw is None else study.defect.flaw.at
    rule = "has a place, which cannot stay where it is while the dimensions change"
    require(not place, "defect.size", study.defect.size, rule, "Leave out @x,y,z.")
    study.rod.solid()
    study.require_loading()
    given, size = study.analysis.tolerance_percent, study.mesh.size_mm
    tolerance = given if given is not None or size is not None else TOLERANCE
    table = study.optimise or OptimiseTable()
    if table.min_hours is not None:
        known = study.engine is not None and life_line(study.material.material(), 1.0) is not None
        rule = "needs an [engine], and a material with an S–N line or with strengths for one"
        require(known, "optimise.min_hours", table.min_hours, rule, "Give them, or leave it out.")
    if table.min_film_um is not None:
        study.require_film("optimise.min_film_um", table.min_film_um)
        study = replace(study, analysis=replace(study.analysis, film=True))
    cycle, least = study.engine is not None, table.min_rpm
    if least is not None:
        speeds = study.engine_speeds(study.require_engine())
        study = replace(study, speed=replace(study.speed, rpm=tuple(dict.fromkeys((*speeds, least)))))
    options = replace(study.analysis, tolerance_percent=tolerance, all_cases=True, draft=False, cycle=cycle)
    return replace(study, rod=replace(study.rod, mass=None), analysis=options)


def checked(free: Variables, x: Floats) -> CheckedRod:
    """Analyse a rod on a mesh of its own, refined to the tolerance, as `fea run` does."""
    design = free.study_at(x)
    tolerance = min(design.analysis.tolerance_percent or TOLERANCE, TOLERANCE)
    analysis = replace(design.analysis, tolerance_percent=tolerance)
    study = replace(design, mesh=replace(design.mesh, size_mm=None), analysis=analysis)
    adapted = refined_rod(study, study.speeds(), Clock())
    results = [adapted.at(rpm) for rpm in study.speeds()]
    outcomes = tuple(run_result(study, adapted, result) for result in results)
    factors = required(study)
    films = [MinimumFilm.of(result.film) for result in results if result.film and FILM in factors]
    return CheckedRod(study, outcomes, constraints(adapted.rod, results, factors, films), tolerance)


def _last(free: Variables, result: SearchResult) -> tuple[Design, CheckedRod]:
    """The lightest rod that meets the required factors on its last mesh, or the first of the lightest."""
    tried = []
    for design in result.holding[:_CANDIDATES] or [result.best]:
        tried.append((design, checked(free, design.x)))
        if tried[-1][1].holds:
            return tried[-1]
    return tried[0]


def progress(
    show: Callable[..., None], most: int, dimensions: int, clock: Callable[[], float] = time.monotonic
) -> Callable[[Design, int, int], None]:
    """Return a listener of `Designs` for a progress line, with the cost predicted after the first design."""
    lightest, begin, last = inf, clock(), 0.0

    def listener(design: Design, count: int, now: int) -> None:
        nonlocal lightest, last
        if design.margin >= 0:
            lightest = min(lightest, design.mass_kg)
        if not now:  # of the search that was interrupted
            return
        taken, first = clock() - begin, not last
        each, last = taken / now, last or 2 * taken  # two rods are meshed again at the end
        usual = max(count, min(most, _USUALLY * dimensions))
        least, longest = (duration((meshes - count) * each + last) for meshes in (usual, most))
        if first:
            about = f"about {least}" if least == longest else f"about {least}, at most {longest}"
            show(f"{about}, as one mesh took {duration(each)}; {most} may be solved", lasting=True)
        best = f"lightest so far: {1000 * lightest:.4g} g" if lightest < inf else "none meets the factors yet"
        show(f"{count} of at most {most} meshes solved, at most {longest} left, {best}")

    return listener


def write_files(folder: Path, figures: OptimiseFigures, before: CheckedRod, after: CheckedRod) -> str:
    """Write the files; return why there is no picture, or "". Raises `StorageError`, `PictureError`."""
    write_text(folder / STUDY, after.study.text())
    write_text(folder / OPTIMISED, json_text(figures))
    tried = figures.history
    names = ("number", "mass_kg", "margin", "new_mesh")
    columns = {name: [float(getattr(design, name)) for design in tried] for name in names}
    columns |= {key: [design.dimensions_mm[key] for design in tried] for key in tried[0].dimensions_mm}
    write_columns(folder / HISTORY, columns)
    _plot_course(folder / COURSE, figures)
    try:
        _draw_rods(folder / RODS, figures, before, after)
    except PictureError as error:  # a search is not lost for it
        return str(error)
    return ""


def _plot_course(path: Path, figures: OptimiseFigures) -> None:
    """Plot mass and margin of all designs; raises `PictureError`: the file could not be written."""
    figure = new_figure(9, 6)
    above, below = figure.subplots(2, 1, sharex=True)
    tried = [(design.number, 1000 * design.mass_kg, 100 * design.margin) for design in figures.history]
    number, mass, margin = np.array(tried).T
    holds = margin >= 0
    above.plot(number[holds], mass[holds], "o", color="C0", ms=4, label="meets the required factors")
    above.plot(number[~holds], mass[~holds], "x", color="C3", ms=5, label="does not")
    lightest = np.minimum.accumulate(np.where(holds, mass, np.inf))
    finite = np.isfinite(lightest)
    above.step(number[finite], lightest[finite], where="post", color="0.4", lw=1, label="lightest of these")
    above.set_ylabel("mass, g")
    above.set_title(f"{figures.study}: designs that were tried", fontsize=11)
    above.legend(frameon=False)
    below.axhline(0, color="0.3", lw=1)
    below.plot(number, margin, ".-", color="C0", lw=0.7)
    below.set_ylabel("least margin, %")
    below.set_xlabel("design")
    for panel in (above, below):
        panel.grid(alpha=0.3)
    save(figure, path)


def _draw_rods(path: Path, figures: OptimiseFigures, before: CheckedRod, after: CheckedRod) -> None:
    """Draw both rods at one scale, the earlier one above, in the least safety factors of all speeds."""
    fields = [_factors(rod) for rod in (before, after)]
    field = FATIGUE if all(FATIGUE in each for each in fields) else YIELDING
    values = np.concatenate([each[field] for each in fields])
    first, second = (rod.outcomes[0].mesh for rod in (before, after))
    shift = _APART * (np.ptp(first.points[:, 1]) + np.ptp(second.points[:, 1])) / 2
    both = TetMesh(
        np.concatenate([first.points + np.array([0.0, shift, 0.0]), second.points]),
        np.concatenate([first.tets, second.tets + len(first.points)]),
    )
    of_first = int(values.argmin()) < len(first.points)
    old, new = 1000 * figures.mass_before_kg, 1000 * figures.mass_after_kg
    with TemporaryDirectory() as scratch:
        vtu = Path(scratch, "rods.vtu")
        write_vtu(vtu, both, {"displacement": np.zeros_like(both.points), field: values})
        picture = Picture(
            vtu=vtu,
            png=path,
            title=f"{figures.study}: before, {old:.0f} g (above), and after, {new:.0f} g",
            field=field,
            origin=(0.0, shift if of_first else 0.0, 0.0),
            notes=(f"of the rod {'before' if of_first else 'after'}",),
        )
        draw_pictures([picture])


def _factors(rod: CheckedRod) -> dict[str, Floats]:
    """Least safety factors (n_nodes,) of all speeds, by the names of their arrays."""
    cases = [case.safety_factor for outcome in rod.outcomes for case in outcome.cases.values()]
    cycles = [outcome.cycle.envelope for outcome in rod.outcomes if outcome.cycle is not None]
    least = {YIELDING: np.min([*cases, *(cycle.safety_factor for cycle in cycles)], axis=0)}
    fatigue = [cycle.fatigue_factor for cycle in cycles if cycle.fatigue_factor is not None]
    if cycles and len(fatigue) == len(cycles):
        least[FATIGUE] = np.nan_to_num(np.min(fatigue, axis=0), nan=CAP)
    return least
