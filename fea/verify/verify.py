"""Compute benchmark problems; show them on the terminal and in a Markdown report with its plot."""

from collections.abc import Iterable, Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fea.machine.clock import Listener
from fea.output.plots.figure import log_ticks, new_figure
from fea.verify.benchmark import CASES, Benchmark, BenchmarkRow, compute_rows
from fea.verify.cases import assemblies, contact, dynamics, elasticity, film, friction, nafems, plasticity
from fea.verify.layout import Line, explanation, markdown, print_table, write_document

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# The modules whose import fills `CASES`.
MODULES = (assemblies, contact, dynamics, elasticity, film, friction, nafems, plasticity)


def verify(names: Sequence[str] = (), listener: Listener | None = None) -> list[BenchmarkRow]:
    """Compute some of `CASES`, or all, as `compute_rows`; return one row per quantity."""
    cases = {name: CASES[name].rows for name in sorted(CASES)}
    return compute_rows(cases, "a benchmark", names, listener)


def _by_case(rows: Iterable[BenchmarkRow]) -> list[tuple[Benchmark, list[BenchmarkRow]]]:
    return [(case, list(same)) for case, same in groupby(rows, key=lambda row: row.case)]


def print_verification(rows: Sequence[BenchmarkRow]) -> None:
    """Print one line per quantity under each case, and the number of failures."""
    lines: list[Line] = []
    for case, of_case in _by_case(rows):
        cost = f"{of_case[0].dofs} dofs, {of_case[0].seconds:.1f} s"
        lines.append(([f"[bold]{case.name}[/bold] [dim]{cost}[/dim]"], ""))
        for row in of_case:
            it = row.quantity
            name = f"  {it.name}{'' if it.unit == '1' else f', {it.unit}'}"
            values = (f"{it.target:.4g}", f"{it.computed:.4g}", f"{it.error_percent:.2g}")
            cells = (name, *values, f"{it.tolerance_percent:.2g}", "pass" if row.passed else "FAIL")
            lines.append((cells, "" if row.passed else "bold red"))
    header = ("case and quantity", "target", "computed", "error %", "limit %", "")
    print_table(header, lines, words=("case and quantity",), end=[_verdict(rows)])


def _verdict(rows: Sequence[BenchmarkRow]) -> str:
    failed = [row for row in rows if not row.passed]
    cases = len({row.case.name for row in rows})
    if not failed:
        return f"All {len(rows)} quantities of {cases} benchmark problems are within their tolerances."
    names = ", ".join(dict.fromkeys(row.case.name for row in failed))
    return f"{len(failed)} of {len(rows)} quantities of {cases} benchmark problems FAILED: {names}."


# Element sizes relative to the one at which a case must meet its tolerances.
_COARSER = (2.8, 2.0, 1.4)


def write_report(
    path: Path, rows: Sequence[BenchmarkRow], command: str, listener: Listener | None = None
) -> None:
    """Write the report, with its plot next to it; for the plot, the cases are solved on coarser meshes too.

    The `command` makes it; `listener` is called with the name of each case before it is computed again.
    """
    header = ("case", "quantity", "unit", "target", "computed", "error %", "limit %", "dofs", "seconds", "")
    table = markdown(header, map(_cells, rows), "lllrrrrrr")
    parts = [f"**{_verdict(rows)}**", explanation("verify"), table]
    converging: list[BenchmarkRow] = []
    for case, of_case in _by_case(rows):
        if case.converges:
            if listener:
                listener(f"{case.name}, coarser")
            converging += [row for factor in _COARSER for row in case.rows(factor)] + of_case
    if converging:
        plot = path.with_name(f"{path.stem}-convergence.png")
        image = f"![error against degrees of freedom]({plot.name})"
        parts += ["## Convergence", explanation("verify-convergence"), image]
    parts.append("## Sources, and reasons for the tolerances")
    for case, of_case in _by_case(rows):
        parts += [f"### {case.name}", f"{case.title}. Target: {case.source}.", _reasons(of_case)]
    write_document(path, "Benchmark problems", command, parts)
    if converging:
        _draw_convergence(converging, plot)


def _cells(row: BenchmarkRow) -> tuple[str, ...]:
    it = row.quantity
    numbers = (f"{it.target:.6g}", f"{it.computed:.6g}", f"{it.error_percent:.2g}")
    cost = (f"{it.tolerance_percent:.2g}", str(row.dofs), f"{row.seconds:.1f}")
    shown = (text.replace("-", "−") for text in numbers)
    return (row.case.name, it.name, it.unit, *shown, *cost, "pass" if row.passed else "**FAIL**")


def _reasons(rows: Sequence[BenchmarkRow]) -> str:
    limits: dict[str, list[str]] = {}
    for row in rows:
        it = row.quantity
        limits.setdefault(it.why, []).append(f"{it.name}: {it.tolerance_percent:.2g} %")
    return "\n".join(f"- {'; '.join(of_reason)} – {why}." for why, of_reason in limits.items())


def _draw_convergence(rows: Sequence[BenchmarkRow], path: Path) -> None:
    """Plot error against degrees of freedom, separately for stresses and displacements."""
    figure = new_figure(11, 6)
    moved = [row for row in rows if row.quantity.unit in ("mm", "rad")]
    strained = [row for row in rows if row not in moved]
    panels = [panel for panel in (("stress", strained, 2), ("displacement", moved, 3)) if panel[1]]
    for axes, panel in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        _panel(axes, *panel)
    figure.savefig(path, dpi=100)


def _panel(axes: "Axes", title: str, rows: Sequence[BenchmarkRow], order: int) -> None:
    curves: dict[str, list[BenchmarkRow]] = {}
    for row in sorted(rows, key=lambda row: (row.case.name, row.quantity.name, row.dofs)):
        curves.setdefault(f"{row.case.name}: {row.quantity.name}", []).append(row)
    for number, (label, curve) in enumerate(curves.items()):
        errors = [max(abs(row.quantity.error_percent), 1e-7) for row in curve]
        marker = "osv^D"[number % 5]
        axes.loglog([row.dofs for row in curve], errors, marker=marker, markersize=4, label=label)
    dofs = np.array([min(row.dofs for row in rows), max(row.dofs for row in rows)], dtype=float)
    slope = 3 * (dofs / dofs[0]) ** (-order / 3)
    axes.loglog(dofs, slope, color="0.5", linestyle=":", label=f"order {order} in element length")
    axes.set(title=f"{title}, error against the target", xlabel="degrees of freedom", ylabel="error, %")
    axes.grid(alpha=0.3, which="both")
    log_ticks(axes)
    axes.legend(fontsize=7, frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.12))
