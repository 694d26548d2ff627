"""The result of a search as figures, for JSON, for the history and for the terminal."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from fea.analysis.figures import Figures, figures
from fea.analysis.result import RunResult
from fea.apps.optimise.designs import Design
from fea.apps.optimise.problem import DesignConstraint, Variables
from fea.apps.optimise.search import SearchResult
from fea.base.note import Note, by_consequence
from fea.output.defect_answer import defect_sizes, given_flaw
from fea.output.folder import near
from fea.output.terminal.prose import plain_table, print_lines, terminal, unusual
from fea.output.units import in_unit
from fea.study.study import Study

# Of the range of a dimension, and of a required factor: nearer ones count as at the bound, or as governing.
_AT_BOUND, _ACTIVE = 0.01, 0.02


@dataclass(frozen=True)
class CheckedRod:
    """A rod on a mesh of its own that is refined to a tolerance, percent."""

    study: Study
    outcomes: tuple[RunResult, ...]
    constraints: tuple[DesignConstraint, ...]
    tolerance: float

    @property
    def holds(self) -> bool:
        """Whether every factor less its bar is reached."""
        return all(constraint.margin >= 0 for constraint in self.constraints)

    @property
    def trusted(self) -> bool:
        """Whether every check passed at every speed."""
        return all(outcome.trusted for outcome in self.outcomes)

    @property
    def mass_kg(self) -> float:
        """Its mass."""
        return self.outcomes[0].summary.rod.mass_kg


class DimensionFigures(Figures):
    """A free dimension, mm, before and after; `bound` is that at which it ended."""

    key: str
    low_mm: float
    high_mm: float
    before_mm: float
    after_mm: float
    bound: str | None


class ConstraintFigures(Figures):
    """A constraint, before and after: the safety factor, or the film in µm, and the error bar behind it.

    `assured_after` is the factor less its bar, `active` whether it keeps the rod from being lighter.
    """

    name: str
    required: float
    before: float
    before_error_percent: float
    after: float
    after_error_percent: float
    assured_after: float
    active: bool


class DesignFigures(Figures):
    """A design that was tried: its mass, the constraint with the least margin and the dimensions."""

    number: int
    mass_kg: float
    margin: float
    governing: str
    new_mesh: bool
    dimensions_mm: Mapping[str, float]


class OptimiseFigures(Figures):
    """``optimise.json``.

    `holds` is whether every required factor less its error bar is reached on the last mesh, `trusted` whether
    every check of that analysis passed; `evaluations` counts the meshes that were solved, `new_meshes` the
    designs with a mesh of their own, from which others were moved; `stopped_by` names the rules of the shape
    that keep a dimension from changing further.
    """

    schema: str = "fea/optimise/1"
    study: str
    mass_before_kg: float
    mass_after_kg: float
    saved_percent: float
    holds: bool
    trusted: bool
    ended: str
    evaluations: int
    new_meshes: int
    tolerance_percent: float
    least_wall_mm: float
    dimensions: tuple[DimensionFigures, ...]
    limits: tuple[ConstraintFigures, ...]
    stopped_by: tuple[str, ...]
    history: tuple[DesignFigures, ...]
    defects: tuple[str, ...]  #: what the last rod bears, in words
    notes: tuple[Note, ...]
    files: tuple[str, ...]
    total_s: float

    @property
    def missed(self) -> tuple[ConstraintFigures, ...]:
        """The constraints that the rod violates."""
        return tuple(limit for limit in self.limits if limit.assured_after < limit.required)


def optimise_figures(
    free: Variables,
    result: SearchResult,
    best: Design,
    before: CheckedRod,
    after: CheckedRod,
    *,
    files: tuple[str, ...],
    seconds: float,
) -> OptimiseFigures:
    """Return the figures of a search, whose first rod and best one were checked."""
    notes, _ = by_consequence(note for outcome in after.outcomes for note in outcome.summary.notes)
    return OptimiseFigures(
        study=free.study.name,
        mass_before_kg=before.mass_kg,
        mass_after_kg=after.mass_kg,
        saved_percent=100 * (1 - after.mass_kg / before.mass_kg),
        holds=after.holds,
        trusted=after.trusted,
        ended=result.ended,
        evaluations=result.count,
        new_meshes=sum(design.remeshed for design in result.tried),
        tolerance_percent=after.tolerance,
        least_wall_mm=free.least_wall,
        dimensions=_dimensions(free, best),
        limits=_constraints(before.constraints, after.constraints),
        stopped_by=tuple(f"{change}: {why}" for change, why in free.obstacles(best.x).items()),
        history=tuple(
            figures(
                DesignFigures,
                design,
                number=number,
                governing=design.governing.name,
                new_mesh=design.remeshed,
                dimensions_mm=free.dimensions(design.x),
            )
            for number, design in enumerate(result.tried, start=1)
        ),
        defects=tuple(
            f"At {each.rpm:g} rpm: {line}"
            for each in (outcome.summary for outcome in after.outcomes)
            for line in (*given_flaw(each), *defect_sizes(each))
        ),
        notes=notes,
        files=files,
        total_s=seconds,
    )


def _dimensions(free: Variables, best: Design) -> tuple[DimensionFigures, ...]:
    before, after = free.dimensions(free.start), free.dimensions(best.x)
    return tuple(
        DimensionFigures(
            key=key,
            low_mm=float(low),
            high_mm=float(high),
            before_mm=before[key],
            after_mm=after[key],
            bound="least" if x < _AT_BOUND else "largest" if x > 1 - _AT_BOUND else None,
        )
        for key, low, high, x in zip(free.keys, free.low, free.high, best.x, strict=True)
    )


def _constraints(
    before: tuple[DesignConstraint, ...], after: tuple[DesignConstraint, ...]
) -> tuple[ConstraintFigures, ...]:
    earlier = {constraint.name: constraint for constraint in before}
    return tuple(
        figures(
            ConstraintFigures,
            constraint,
            before=first.factor,
            before_error_percent=first.error_percent,
            after=constraint.factor,
            after_error_percent=constraint.error_percent,
            assured_after=constraint.low,
            active=constraint.margin < _ACTIVE,
        )
        for constraint in after
        for first in [earlier.get(constraint.name, constraint)]
    )


def print_table(figures: OptimiseFigures, folder: Path) -> None:
    """Print the answer, the dimensions and the constraints before and after."""
    console = terminal()
    print_lines(console, [_answer(figures)], "bold")
    print_lines(console, unusual(figures.notes))
    dimensions = plain_table(
        ("dimension, mm", "from", "to", "before", "after", ""), (), left=("dimension, mm", "")
    )
    for one in figures.dimensions:
        sizes = (in_unit(value, "mm") for value in (one.low_mm, one.high_mm, one.before_mm, one.after_mm))
        bound = "" if one.bound is None else f"at its {one.bound} value"
        dimensions.add_row(one.key.removesuffix("_mm"), *(f"{size:.4g}" for size in sizes), bound)
    console.print(dimensions)
    factors = plain_table(
        ("safety factor", "required", "before", "after", "less its bar", ""), (), left=("safety factor", "")
    )
    for limit in figures.limits:
        verdict = "not met" if limit in figures.missed else "governs" if limit.active else ""
        values = (limit.required, limit.before, limit.after, limit.assured_after)
        factors.add_row(limit.name, *(f"{value:.3g}" for value in values), verdict)
    console.print(factors)
    meshes = f"{figures.evaluations} meshes solved, for {len(figures.history)} designs; {figures.ended}"
    check = f"the last rod was meshed again, to error bars of {figures.tolerance_percent:g} %"
    failed = () if figures.trusted else ("A check failed: do not trust the result.",)
    print_lines(console, [*failed, *figures.defects, *figures.stopped_by, f"{meshes}; {check}."])
    study = near(folder / "study.toml")
    print_lines(console, [f"Wrote {study}, with the table and the history beside it: fea run {study}"])


def _answer(figures: OptimiseFigures) -> str:
    before, after = 1000 * figures.mass_before_kg, 1000 * figures.mass_after_kg
    if figures.missed:
        worst = min(figures.missed, key=lambda limit: limit.assured_after / limit.required)
        return (
            f"{figures.study}: no rod met the required factors within {figures.evaluations} evaluations; "
            f"the best one has {worst.after:.3g} ± {worst.after_error_percent:.2g} % of the required "
            f"{worst.required:g} ({worst.name}). Wider bounds (--free) or more --evaluations may help"
        )
    change = f"{abs(figures.saved_percent):.3g} % {'lighter' if after < before else 'heavier'}"
    return f"{figures.study}: {after:.4g} g instead of {before:.4g} g, {change}"
