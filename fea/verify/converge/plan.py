"""The computations of the comparison, the cheapest first."""

import shutil
from collections.abc import Iterator

from fea.verify.converge.row import Computation

# Ratio of successive sizes: each mesh has about 2.4 times the nodes of the previous one.
STEP = 0.75
LEVELS = 9
# Coarsest sizes: for the rod relative to its default size, for the others in mm.
COARSEST = {"rod": 2.4, "lame": 8.0, "goodier": 0.6}
TOLERANCES = (10.0, 5.0, 3.0, 2.0, 1.0)
TOOLS = ("fea", "fea, mean", "CalculiX")


def series(problem: str, default_size: float) -> Iterator[list[Computation]]:
    """The computations of a problem, in series that differ only in the size, coarse to fine.

    Parameters
    ----------
    problem
        ``rod``, ``lame`` or ``goodier``.
    default_size
        Default element size of the rod, mm.
    """
    unit = default_size if problem == "rod" else 1.0
    sizes = [COARSEST[problem] * unit * STEP**level for level in range(LEVELS)]
    tools = [tool for tool in TOOLS if tool != "CalculiX" or shutil.which("ccx")]
    for tool in (*tools, *(["fea, whole"] if problem == "rod" else [])):
        for element in ("p1", "p2") if tool != "fea, whole" else ("p2",):
            yield [Computation(tool, element, problem, size) for size in sizes]
    if problem == "rod":
        yield [Computation("fea --tolerance", "p2", problem, percent) for percent in TOLERANCES]
        first = round(COARSEST[problem] * unit, 1)
        tool = f"fea --size {first:g} --tolerance"
        yield [Computation(tool, "p2", problem, percent, first) for percent in TOLERANCES]
