"""What a search says at its end."""

from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from fea.optimise.figures import OptimiseFigures
from fea.output.target import near


def print_table(figures: OptimiseFigures, folder: Path) -> None:
    """Print the answer, the dimensions and the limits before and after."""
    console = Console(highlight=False)
    console.print(answer(figures), markup=False, style="bold", soft_wrap=True)
    console.print(_dimensions(figures))
    console.print(_limits(figures))
    for line in figures.stopped_by:
        console.print(line, markup=False, soft_wrap=True)
    meshes = f"{figures.evaluations} meshes solved, for {len(figures.history)} designs; {figures.ended}"
    check = f"the last rod was meshed again, to error bars of {figures.tolerance_percent:g} %"
    console.print(f"{meshes}; {check}.", markup=False, soft_wrap=True)
    for note in () if figures.trusted else ("A check failed: do not trust the result.",):
        console.print(note, markup=False, soft_wrap=True)
    study = near(folder / "study.toml")
    console.print(f"Wrote {study}, with the table and the history beside it: fea run {study}", soft_wrap=True)


def answer(figures: OptimiseFigures) -> str:
    """Say what was found, in a line."""
    before, after = 1000 * figures.mass_before_kg, 1000 * figures.mass_after_kg
    if figures.missed:
        worst = min(figures.missed, key=lambda limit: limit.assured_after / limit.required)
        return (
            f"{figures.study}: no rod between these bounds holds; the nearest one has {worst.after:.3g} "
            f"± {worst.after_error_percent:.2g} % of the required {worst.required:g} ({worst.name})"
        )
    change = f"{abs(figures.saved_percent):.3g} % {'lighter' if after < before else 'heavier'}"
    return f"{figures.study}: {after:.4g} g instead of {before:.4g} g, {change}"


def _dimensions(figures: OptimiseFigures) -> Table:
    table = _table("dimension, mm", "from", "to", "before", "after", "")
    for one in figures.dimensions:
        row = (one.low_mm, one.high_mm, one.before_mm, one.after_mm)
        bound = "" if one.bound is None else f"at its {one.bound} value"
        table.add_row(one.key.removesuffix("_mm"), *(f"{value:.4g}" for value in row), bound)
    return table


def _limits(figures: OptimiseFigures) -> Table:
    table = _table("safety factor", "required", "before", "after", "less its bar", "")
    for limit in figures.limits:
        after = limit.assured_after
        said = "does not hold" if after < limit.required else "governs" if limit.active else ""
        values = (limit.required, limit.before, limit.after, after)
        table.add_row(limit.name, *(f"{value:.3g}" for value in values), said)
    return table


def _table(first: str, *others: str) -> Table:
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column(first)
    for title in others:
        table.add_column(title, justify="right" if title else "left")
    return table
