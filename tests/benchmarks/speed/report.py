"""The measured runs as results/speed.md with its plot."""

import math
import sys
from collections.abc import Iterator
from pathlib import Path

from figures import Figures, Row
from programs import PROCESSES, PROGRAMS

from fea.output.plots.figure import log_ticks, new_figure

sys.path.insert(0, str(Path(__file__).parents[1]))

from scripts import table

GOALS = (
    ("whole", "ngsolve", 0.6),
    ("whole", "calculix", 0.15),
    ("quarter", "ngsolve", 0.25),
    ("quarter", "calculix", 0.06),
)
COMPARED = [key for key, program in PROGRAMS.items() if program.compared]
INTRODUCTION = """\
# Speed beside other programs

Made by `python tests/benchmarks/speed --peer-python PYTHON --report`, where PYTHON has the dependency group
`bench`; CalculiX comes from the system. Its `--help` says how to measure in slices.

One problem for all: the León rod at 6000 rpm, at the crank angle with the largest side force: half-cosine
pressures on both bores and the rod's inertia, as the same nodal forces on the same curved ten-node
tetrahedra. Every run is a process of its own with two threads. The programs take turns within each round,
and ratios are formed within a round, for the machine is shared.
Figures are medians over the runs that the table counts: five, fewer of what takes long. The load average was
{load} in the median: the seconds say how busy the machine was, the ratios compare the programs.

![Time and memory against degrees of freedom]({plot})

## Ratios

Time of `fea` over time of the other program, of the whole rod solved as it is and of a quarter of it that
gives the whole (both parities, put back together); bold where the goal is met.
"""
AGREEMENT = """
`fea`, NGSolve and SfePy: from the mesh in memory to the stress, imports excluded. `fea` ends with the
recovered stress at the nodes of the whole rod, which costs more than the Gauss-point stress that ends NGSolve
and SfePy. NGSolve has its blocks of three components a node, which is a third faster than its vector-valued
space. CalculiX is the whole process: it reads its deck and writes its results. The bytes are those beyond
what the process held with the mesh in memory (CalculiX: all).

Differences are the largest over the largest value, from `fea` on the whole rod: of displacements after
removing the rigid motion (six restraints, whose reactions vanish, stand at nodes of each one's choice); of
von Mises stress at the Gauss points, of the nodal mean of extrapolated Gauss values, or of `fea`'s own
recovered stress. The largest from CalculiX at any size: {displacement} of displacement, {mean} of stress; it
prints six digits of each component. SfePy has no curved tetrahedra: it is compared on the mesh with straight
edges, of which `fea`'s reference is made anew. `fea` solves by Pardiso where a row does not say otherwise.

## Growth

Exponents of the degrees of freedom, of the shortest run of each size above 30 000.
"""
FACTORISATION = """
## Factorisation

Pardiso's phases on the whole rod's matrix. The matrix product is a dense one by NumPy, double precision, in
the same process with the same threads.
"""
ASSEMBLY = """
## Assembly

From the mesh in memory to the whole rod's matrix: `fea` in batches of dense products, of which it keeps one
triangle, beside scikit-fem's general assembly (both triangles) with scikit-fem's own mesh and basis.
"""
PROCESS = """
## Whole process

`fea run --rpm 6000` with {nodes} nodes (the published study had 21 495 and took 2.5 hours): every peak of
the cycle, from the rod's dimensions to the files, beside an interpreter that imports the same modules and
does nothing.
"""
STAGES = ("assembly", "factor", "solve", "stress")
KINDS = {"gauss": "Gauss points", "mean": "nodal mean", "recovered": "recovered"}
COLORS = {
    "whole": "#c44e52",
    "quarter": "#8c1d40",
    "multigrid": "#dd8452",
    "ngsolve": "#4c72b0",
    "calculix": "#55a868",
    "sfepy": "#8172b3",
}


# Shifts of names that would overlap.
LABELS = {
    ("whole", "seconds"): -6,
    ("multigrid", "seconds"): 7,
    ("whole", "peak_mb"): -11,
    ("quarter", "peak_mb"): 9,
    ("calculix", "peak_mb"): 6,
}


def write_report(rows: list[Row], path: Path) -> None:
    """Write the report and, beside it, its plot."""
    figures = Figures(rows)
    plot = path.with_suffix(".png")
    draw(figures, plot)
    path.write_text("\n".join([*text(figures, plot.name)]) + "\n", encoding="utf-8")


def text(figures: Figures, plot: str) -> Iterator[str]:
    sizes = figures.sizes("whole")
    yield INTRODUCTION.format(plot=plot, load=number(figures.load))
    yield from table(
        ["degrees of freedom", *(f"{ours(a)} / {PROGRAMS[b].name}, goal {goal:g}" for a, b, goal in GOALS)],
        (ratios(figures, size) for size in sizes if figures.sizes("ngsolve")),
    )
    yield from floors(figures)
    yield "\n## Times, memory and agreement\n"
    yield from table(
        [
            *("degrees of freedom", "program", "runs", "seconds", "shortest…longest", *STAGES),
            *("peak MB", "bytes a dof", "displacement differs by", "von Mises differs by"),
        ],
        (times(figures, key, size) for size in sizes for key in COMPARED if size in figures.sizes(key)),
    )
    yield AGREEMENT.format(**largest_differences(figures, "calculix"))
    yield from table(
        ["program", "time", "peak memory"],
        (
            [PROGRAMS[key].name, number(figures.exponent(key)), number(figures.exponent(key, "peak_mb"))]
            for key in COMPARED
            if not math.isnan(figures.exponent(key))
        ),
    )
    yield from assembly(figures)
    yield from factorisation(figures)
    yield from whole_process(figures)


def ratios(figures: Figures, size: int) -> list[str]:
    """One row of the table of goals; bold where met."""
    found = [(figures.ratio(a, b, size), goal) for a, b, goal in GOALS]
    return [
        count(figures.dofs(size)),
        *(f"**{number(ratio)}**" if ratio <= goal else number(ratio) for ratio, goal in found),
    ]


def floors(figures: Figures) -> Iterator[str]:
    """Lower bound of the time of any assembly."""
    for size in figures.sizes("pardiso"):
        if figures.done("pardiso", size) and figures.done("calculix", size):
            phases = sum(figures.stage("pardiso", size, stage) for stage in ("analysis", "factor"))
            share = phases / figures.median("calculix", size)
            yield (
                f"\nAt {count(figures.dofs(size))} degrees of freedom Pardiso's analysis and factorisation "
                f"of the whole rod alone take {number(share)} of CalculiX's time."
            )


def largest_differences(figures: Figures, key: str) -> dict[str, str]:
    """Of displacement and nodal mean stress, over all sizes."""
    found = [figures.agreement(key, size) for size in figures.sizes(key)]
    return {
        kind: f"{max((one[kind] for one in found if kind in one), default=math.nan):.1e}"
        for kind in ("displacement", "mean")
    }


def ours(key: str) -> str:
    return {"whole": "whole rod", "quarter": "mirror planes"}[key]


def times(figures: Figures, key: str, size: int) -> list[str]:
    program = PROGRAMS[key]
    head = [count(figures.dofs(size)), program.name]
    if not figures.done(key, size):
        return [*head, "0", figures.failure(key, size), *["–"] * 9]
    if key != "multigrid" and figures.solver(key, size) not in ("", "pardiso"):
        head[1] += f" ({figures.solver(key, size)})"
    low, high = figures.spread(key, size)
    stages = [number(figures.stage(key, size, stage)) for stage in STAGES]
    differences = figures.agreement(key, size)
    stress = [f"{differences[kind]:.1e} ({name})" for kind, name in KINDS.items() if kind in differences]
    displacement = f"{differences['displacement']:.1e}" if "displacement" in differences else "–"
    if key == "whole":
        displacement, stress = "reference", ["reference"]
    return [
        *head,
        str(len(figures.done(key, size))),
        number(figures.median(key, size)),
        f"{number(low)}…{number(high)}",
        *stages,
        f"{figures.median(key, size, 'peak_mb'):.0f}",
        count(round(figures.bytes_per_dof(key, size), -1)),
        displacement,
        ", ".join(stress) or "–",
    ]


def assembly(figures: Figures) -> Iterator[str]:
    yield ASSEMBLY
    rows = (
        (size, figures.stage("whole", size, "assembly"), figures.stage("skfem", size, "assembly"))
        for size in figures.sizes("skfem")
        if figures.done("skfem", size) and figures.done("whole", size)
    )
    yield from table(
        ["degrees of freedom", "fea s", "scikit-fem s", "ratio"],
        ([count(figures.dofs(size)), number(a), number(b), number(a / b)] for size, a, b in rows),
    )


def factorisation(figures: Figures) -> Iterator[str]:
    yield FACTORISATION
    yield from table(
        [
            *("degrees of freedom", "analysis s", "factor s", "solve s", "entries of the factor"),
            *("10⁹ operations", "GFLOP/s", "matrix product GFLOP/s", "share"),
        ],
        (phases(figures, size) for size in figures.sizes("pardiso") if figures.done("pardiso", size)),
    )


def phases(figures: Figures, size: int) -> list[str]:
    def median(key: str) -> float:
        return figures.median("pardiso", size, key)

    factor, product = figures.stage("pardiso", size, "factor"), median("product_gflops")
    rate = median("factor_gflop") / factor
    return [
        count(figures.dofs(size)),
        *(number(figures.stage("pardiso", size, stage)) for stage in ("analysis", "factor", "solve")),
        count(median("factor_entries")),
        number(median("factor_gflop")),
        number(rate),
        number(product),
        f"{100 * rate / product:.0f} %",
    ]


def whole_process(figures: Figures) -> Iterator[str]:
    for size in figures.sizes("run"):
        yield PROCESS.format(nodes=count(figures.dofs(size) // 3))
        yield from table(
            ["process", "seconds", "shortest…longest", "peak MB"],
            (
                [
                    PROCESSES[key].name,
                    number(figures.median(key, size)),
                    "…".join(number(value) for value in figures.spread(key, size)),
                    f"{figures.median(key, size, 'peak_mb'):.0f}",
                ]
                for key in PROCESSES
                if figures.done(key, size)
            ),
        )


def number(value: float) -> str:
    """Three digits at the most; a dash for what is not a number."""
    if math.isnan(value):
        return "–"
    if value == 0:
        return "0"
    digits = max(0, min(3, 2 - math.floor(math.log10(abs(value)))))
    return f"{value:.{digits}f}"


def count(value: float) -> str:
    return f"{value:,.0f}".replace(",", " ")


def draw(figures: Figures, path: Path) -> None:
    figure = new_figure(10, 4.2)
    for axes, key, label in zip(
        figure.subplots(1, 2), ("seconds", "peak_mb"), ("wall time, s", "peak memory, MB"), strict=True
    ):
        for program in COMPARED:
            sizes = [size for size in figures.sizes(program) if figures.done(program, size)]
            if not sizes:
                continue
            x = [figures.dofs(size) for size in sizes]
            y = [figures.median(program, size, key) for size in sizes]
            name = PROGRAMS[program].name
            axes.loglog(x, y, "o-", color=COLORS[program], label=name, markersize=4, linewidth=1.5)
            place = (6, LABELS.get((program, key), 0))
            axes.annotate(
                name,
                (x[-1], y[-1]),
                xytext=place,
                textcoords="offset points",
                color=COLORS[program],
                fontsize=8,
                va="center",
            )
        axes.set_xlabel("degrees of freedom of the whole rod")
        axes.set_ylabel(label)
        axes.grid(visible=True, which="major", alpha=0.3)
        axes.margins(x=0.35)
        axes.spines[["top", "right"]].set_visible(False)
        log_ticks(axes)
    figure.savefig(path, dpi=120, metadata={"Software": None})
