"""Read the results of CalculiX from its .frd file, a format that meshio does not read."""

from pathlib import Path

import numpy as np

from geometry.arrays import Floats

_NODE = slice(3, 13)
_WIDTH = 12


def read_frd(path: Path, name: str, n_nodes: int, step: int = 1) -> Floats:
    """Nodal values of a field, NaN at nodes that are not in the file.

    Parameters
    ----------
    path
        The .frd file, in its text form.
    name
        ``"DISP"`` (3 components) or ``"STRESS"`` (6, in the order XX YY ZZ XY YZ XZ).
    n_nodes
        Of the mesh.
    step
        Which of the steps of the deck, from 1.

    Raises
    ------
    ValueError
        The file has no such field of that step.
    """
    rows: list[str] = []
    reading, steps = False, 0
    with path.open(encoding="ascii") as file:
        for line in file:
            if line.startswith(" -4"):
                named = line[5:13].strip() == name
                steps += named
                reading = named and steps == step
            elif line.startswith(" -3"):
                reading = False
            elif reading and line.startswith(" -1"):
                rows.append(line)
    if not rows:
        raise ValueError(f"{path} has no field {name} of step {step}")
    numbers = np.array([int(row[_NODE]) for row in rows]) - 1
    values = [[float(row[k : k + _WIDTH]) for k in range(13, len(row.rstrip()), _WIDTH)] for row in rows]
    field = np.full((n_nodes, len(values[0])), np.nan)
    field[numbers] = values
    return field
