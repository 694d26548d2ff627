"""The job behind `fea optimise`: search the lightest rod, mesh it again, and leave what was found."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from fea.analysis.adapt import adapt_mesh
from fea.analysis.outcome import Outcome, outcome
from fea.machine.clock import Clock
from fea.optimise.designs import Design, Designs
from fea.optimise.figures import OptimiseFigures, dimension_figures, history, limit_figures
from fea.optimise.files import FILES, write_files
from fea.optimise.limits import Limit, limits, required
from fea.optimise.search import USUAL, Found, search
from fea.optimise.told import telling
from fea.optimise.variables import Variables, variables
from fea.output.folder import require_replaceable, run_folder
from fea.study.study import Study
from geometry.arrays import Floats
from geometry.invalid import require

# Of the last mesh, and of the meshes that the search moves, percent.
TOLERANCE = 2.0
# Rods that are meshed for the last check, where the first does not hold.
_CANDIDATES = 3


@dataclass(frozen=True)
class Checked:
    """A rod on a mesh of its own that is refined to the tolerance."""

    study: Study
    outcomes: tuple[Outcome, ...]
    limits: tuple[Limit, ...]

    @property
    def holds(self) -> bool:
        """Whether every factor less its bar is reached."""
        return all(limit.margin >= 0 for limit in self.limits)

    @property
    def trusted(self) -> bool:
        """Whether every check passed at every speed."""
        return all(each.trusted for each in self.outcomes)


def optimise(
    study: Study, folder: Path, say: Callable[[str], None] = lambda _text: None
) -> tuple[OptimiseFigures, str]:
    """Search the lightest rod that holds, and leave its study, the table, the history and pictures.

    Parameters
    ----------
    study
        What is asked, with `Study.optimise` or without.
    folder
        New, or that of an earlier search.
    say
        Told, after each design, how many meshes were solved and what was found.

    Returns
    -------
    OptimiseFigures, str
        What was found, and why the picture of the rods is missing; empty where it is not.

    Raises
    ------
    InvalidValue
        The rod has no dimensions, or a value breaks a rule.
    OccupiedError, StorageError
        The folder cannot take the files.
    GeometryError, MeshError, UnderconstrainedError, SingularMatrixError
        The rod cannot be drawn, meshed or solved.
    """
    require_replaceable(folder)
    clock = Clock()
    asked = searched(study)
    free = variables(asked)
    table = study.optimise
    most = (None if table is None else table.evaluations) or USUAL
    with clock("search"):
        designs = Designs(free, telling(say, most))
        found = search(designs, free.start, most)
    with clock("check"):
        before = checked(free, found.first.x)
        best, after = _last(free, found)
    figures = _figures(free, found, best, before, after, seconds=clock.total)
    with run_folder(folder) as part:
        complaint = write_files(part, figures, before, after)
    return figures, complaint


def searched(study: Study) -> Study:
    """Return the study as the search asks for it: with the crank cycle, refined to the tolerance.

    Mass properties that the study gives are left out: they are those of its own rod.

    Raises
    ------
    InvalidValue
        The rod is in separate parts, or comes from a mesh.
    """
    rule = "cannot be combined with fea optimise: every design would take minutes"
    remedy = "Remove [assembly], then check the lighter rod with it: fea run."
    require(study.assembly is None, "[assembly]", None, rule, remedy)
    study.rod.solid()
    study.require_loading()
    given, size = study.analysis.tolerance_percent, study.mesh.size_mm
    tolerance = given if given is not None or size is not None else TOLERANCE
    cycle = study.engine is not None
    options = replace(study.analysis, tolerance_percent=tolerance, cycle=cycle)
    return replace(study, rod=replace(study.rod, mass=None), analysis=options)


def checked(free: Variables, x: Floats) -> Checked:
    """Analyse a rod on a mesh of its own, refined to the tolerance, as `fea run` does."""
    asked = free.study_at(x)
    options = asked.analysis
    tolerance = min(options.tolerance_percent or TOLERANCE, TOLERANCE)
    study = replace(
        asked,
        mesh=replace(asked.mesh, size_mm=None),
        analysis=replace(options, tolerance_percent=tolerance),
    )
    adapted = adapt_mesh(study, study.speeds(), Clock())
    results = [adapted.at(rpm) for rpm in study.speeds()]
    outcomes = tuple(outcome(study, adapted, result) for result in results)
    return Checked(study, outcomes, limits(adapted.rod, results, required(study)))


def _last(free: Variables, found: Found) -> tuple[Design, Checked]:
    """The lightest rod that holds on its last mesh, too; if none of the lightest does, the first of them."""
    first: tuple[Design, Checked] | None = None
    for design in found.holding[:_CANDIDATES] or [found.best]:
        after = checked(free, design.x)
        first = first or (design, after)
        if after.holds:
            return design, after
    if first is None:
        raise ValueError("a search tries at least one rod")
    return first


def _figures(
    free: Variables, found: Found, best: Design, before: Checked, after: Checked, *, seconds: float
) -> OptimiseFigures:
    old, new = (each.outcomes[0].summary.rod.mass_kg for each in (before, after))
    notes = tuple(dict.fromkeys(note for each in after.outcomes for note in each.summary.notes))
    stopped = tuple(f"{what}: {why}" for what, why in free.obstacles(best.x).items())
    return OptimiseFigures(
        study=free.study.name,
        mass_before_kg=old,
        mass_after_kg=new,
        saved_percent=100 * (1 - new / old),
        holds=after.holds,
        trusted=after.trusted,
        ended=found.ended,
        evaluations=found.count,
        new_meshes=sum(design.fresh for design in found.tried),
        tolerance_percent=after.study.analysis.tolerance_percent or TOLERANCE,
        least_wall_mm=free.least_wall,
        dimensions=dimension_figures(free, best),
        limits=limit_figures(before.limits, after.limits),
        stopped_by=stopped,
        history=history(free, found),
        notes=notes,
        files=FILES,
        total_s=seconds,
    )
