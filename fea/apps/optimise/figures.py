"""The result of a search as figures, for the table, for JSON and for the history."""

import time
from collections.abc import Callable, Mapping
from math import inf
from pathlib import Path

from rich.table import Table

from fea.analysis.figures import Figures, figures
from fea.apps.optimise.designs import Design
from fea.apps.optimise.limits import Limit
from fea.apps.optimise.search import SearchResult
from fea.apps.optimise.variables import Variables
from fea.base.note import Note
from fea.machine.clock import duration
from fea.output.target import near
from fea.output.terminal.prose import plain_table, print_lines, terminal, unusual
from fea.output.units import in_unit

# Of the range of a dimension, and of a required factor: nearer ones count as at the bound, or as governing.
_AT_BOUND, _ACTIVE = 0.01, 0.02


class DimensionFigures(Figures):
    """A free dimension, mm, before and after; `bound` says at which bound it ended."""

    key: str
    low_mm: float
    high_mm: float
    before_mm: float
    after_mm: float
    bound: str | None


class LimitFigures(Figures):
    """A limit, before and after: the safety factor, or the film in µm, and the error bar behind it.

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
    """A design that was tried: its mass, the limit with the least margin and the dimensions."""

    number: int
    mass_kg: float
    margin: float
    governing: str
    new_mesh: bool
    dimensions_mm: Mapping[str, float]


class OptimiseFigures(Figures):
    """``optimise.json``.

    `holds` says whether every required factor less its error bar is reached on the last mesh, `trusted`
    whether every check of that analysis passed; `evaluations` counts the meshes that were solved,
    `new_meshes` the designs with a mesh of their own, from which others were moved;
    `stopped_by` names the rules of the shape that keep a dimension from changing further.
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
    limits: tuple[LimitFigures, ...]
    stopped_by: tuple[str, ...]
    history: tuple[DesignFigures, ...]
    notes: tuple[Note, ...]
    files: tuple[str, ...]
    total_s: float

    @property
    def missed(self) -> tuple[LimitFigures, ...]:
        """The limits that the rod does not hold."""
        return tuple(limit for limit in self.limits if limit.assured_after < limit.required)


def dimension_figures(variables: Variables, best: Design) -> tuple[DimensionFigures, ...]:
    """Return the free dimensions."""
    before, after = variables.dimensions(variables.start), variables.dimensions(best.x)
    return tuple(
        DimensionFigures(
            key=key,
            low_mm=float(low),
            high_mm=float(high),
            before_mm=before[key],
            after_mm=after[key],
            bound="least" if x < _AT_BOUND else "largest" if x > 1 - _AT_BOUND else None,
        )
        for key, low, high, x in zip(variables.keys, variables.low, variables.high, best.x, strict=True)
    )


def limit_figures(before: tuple[Limit, ...], after: tuple[Limit, ...]) -> tuple[LimitFigures, ...]:
    """Return the limits before and after."""
    earlier = {limit.name: limit for limit in before}
    return tuple(
        figures(
            LimitFigures,
            limit,
            before=was.factor,
            before_error_percent=was.error_percent,
            after=limit.factor,
            after_error_percent=limit.error_percent,
            assured_after=limit.low,
            active=limit.margin < _ACTIVE,
        )
        for limit in after
        for was in [earlier.get(limit.name, limit)]
    )


def history(variables: Variables, result: SearchResult) -> tuple[DesignFigures, ...]:
    """Return all designs that were tried."""
    return tuple(
        figures(
            DesignFigures,
            design,
            number=number,
            governing=design.governing.name,
            new_mesh=design.remeshed,
            dimensions_mm=variables.dimensions(design.x),
        )
        for number, design in enumerate(result.tried, start=1)
    )


def print_table(figures: OptimiseFigures, folder: Path) -> None:
    """Print the answer, the dimensions and the limits before and after."""
    console = terminal()
    print_lines(console, [answer(figures)], "bold")
    print_lines(console, unusual(figures.notes))
    console.print(_dimensions(figures))
    console.print(_limits(figures))
    meshes = f"{figures.evaluations} meshes solved, for {len(figures.history)} designs; {figures.ended}"
    check = f"the last rod was meshed again, to error bars of {figures.tolerance_percent:g} %"
    failed = () if figures.trusted else ("A check failed: do not trust the result.",)
    print_lines(console, [*failed, *figures.stopped_by, f"{meshes}; {check}."])
    study = near(folder / "study.toml")
    print_lines(console, [f"Wrote {study}, with the table and the history beside it: fea run {study}"])


def answer(figures: OptimiseFigures) -> str:
    """Say what was found, in a line."""
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


def _dimensions(figures: OptimiseFigures) -> Table:
    titles = ("dimension, mm", "from", "to", "before", "after", "")
    table = plain_table(titles, (), left=(titles[0], ""))
    for one in figures.dimensions:
        row = (one.low_mm, one.high_mm, one.before_mm, one.after_mm)
        bound = "" if one.bound is None else f"at its {one.bound} value"
        sizes = (f"{in_unit(value, 'mm'):.4g}" for value in row)
        table.add_row(one.key.removesuffix("_mm"), *sizes, bound)
    return table


def _limits(figures: OptimiseFigures) -> Table:
    titles = ("safety factor", "required", "before", "after", "less its bar", "")
    table = plain_table(titles, (), left=(titles[0], ""))
    for limit in figures.limits:
        after = limit.assured_after
        said = "not met" if after < limit.required else "governs" if limit.active else ""
        values = (limit.required, limit.before, limit.after, after)
        table.add_row(limit.name, *(f"{value:.3g}" for value in values), said)
    return table


# Of the number of dimensions: meshes after which a search has usually settled.
_USUALLY = 7


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
