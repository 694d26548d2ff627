"""The comparison as a Markdown report."""

from pathlib import Path

from fea.output.text import make_directory, write_text
from fea.verify.converge.advice import advice
from fea.verify.converge.converge import PROBLEMS, QUANTITY, Comparison
from fea.verify.converge.front import FLOOR, pareto
from fea.verify.converge.plot import draw

_READING = """\
*Seconds* are the whole of a run, from drawing the solid to the recovered stress, in a process of its own, on
two cores that other work shared: only large ratios mean something. *Memory* is that process's peak. *fea*
recovers stress on the boundary from surface strain and known traction; *fea, mean* averages over elements;
*fea, whole* uses no mirror plane; *fea --tolerance* refines where its error bars say. CalculiX solves the
same meshes as *fea* (of the rod: *fea, whole*); drawing, meshing and loads are counted for both. Errors are
signed, against the exact value or, on the rod, against P2 meshes ever finer
at the peak, extrapolated by Richardson.
"""


def write_report(path: Path, comparison: Comparison, command: str) -> None:
    """Write the report and its plot beside it.

    Parameters
    ----------
    path
        The .md file.
    comparison
        What was computed.
    command
        The command that makes the report.
    """
    make_directory(path.parent)
    plot = path.with_suffix(".png")
    draw(comparison, plot)
    rod = [row for row in comparison.rows if row.computation.problem == "rod"]
    parts = [
        "# Error against run time",
        f"Made by `{command}`.",
        "\n".join(f"- {line}" for line in advice(rod)),
    ]
    parts += [_READING, f"![error against total seconds]({plot.name})"]
    parts += [_section(problem, comparison) for problem in PROBLEMS]
    write_text(path, "\n\n".join(part.strip() for part in parts) + "\n")


def _section(problem: str, comparison: Comparison) -> str:
    rows = [row for row in comparison.rows if row.computation.problem == problem]
    reference = comparison.references[problem]
    floor = max(FLOOR, reference.uncertainty_percent)
    front = pareto(rows, floor)
    known = f" ± {reference.uncertainty_percent:.2g} %" if reference.uncertainty_percent else ", exact"
    lines = [
        "| tool | element | size mm | dofs | seconds | MiB | MPa | error % | front |",
        "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | --- |",
    ]
    for row in rows:
        found = row.measured
        error = f"{row.error_percent:.2f}".replace("-", "−")
        cells = (
            *(row.computation.tool, row.computation.element.upper(), f"{found.size:.3g}", str(found.dofs)),
            *(f"{found.seconds:.2f}", f"{found.peak_memory:.0f}", f"{found.value:.2f}", error),
            "**yes**" if row in front else "",
        )
        lines.append("| " + " | ".join(cells) + " |")
    return f"## {QUANTITY[problem]}\n\nReference: {reference.value:.2f} MPa{known}.\n\n" + "\n".join(lines)
