"""A cycle as a sum of few fields, each times a course over the crank angle.

The stress of every instant is U w with the unit stresses U and the weights w. Its proper orthogonal
decomposition (method of snapshots, Sirovich 1987, Q. Appl. Math. 45, 561) needs no history of any node: with
UᵀU = LᵀL the singular vectors of L w are the courses, and each field is U times a fixed combination of
weights. Such a combination is itself a load, so that every field has a displacement too.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fea.analysis.cycle.screened import product
from fea.judge.history import deviator_norm, deviatoric
from geometry.arrays import Floats, Reals

# Numbers of fields that are tried; the last is beyond what any cycle needs.
_COUNTS = (4, 6, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96, 128, 160, 192, 256, 384, 512)
# The error is looked at every so many instants, first at every so many nodes; so many nodes at a time.
_EVERY, _SOME, _NODES = 3, 5, 4000


@dataclass(frozen=True)
class Modes:
    """Fields whose sum, each times its course, is the stress at every instant."""

    stress: Floats  #: (n_nodes, 6, n_modes), MPa, components XX YY ZZ XY YZ XZ
    courses: Floats  #: (n_modes, n_instants), at most 1 in size
    loads: Floats  #: (n_units, n_modes) weights of the unit loads that cause each field
    error: float  #: largest von Mises stress of what is missing at any node and instant looked at, MPa


def modes(units: Reals, weights: Floats, tolerance: float) -> Modes:
    """Find as few fields as give the stress of a cycle to a tolerance.

    `units` (n_nodes, 6, n_units) unit stresses; `weights` (n_units, n_instants).
    """
    flat = np.asarray(units, np.float32).reshape(-1, units.shape[2])
    values, vectors = np.linalg.eigh((flat.T @ flat).astype(float))
    root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    _, sizes, courses = np.linalg.svd(root @ weights, full_matrices=False)
    kept = sizes > np.finfo(np.float32).eps * max(float(sizes[0]), np.finfo(float).tiny)
    sizes, courses = sizes[kept], courses[kept]
    loads, courses = weights @ (courses.T / sizes), sizes[:, None] * courses
    count, error = _enough(units, weights, loads, courses, tolerance)
    size = np.abs(courses[:count]).max(axis=1)
    own = loads[:, :count] * size
    stress = np.asarray(product(flat.reshape(units.shape), own), np.float64)
    return Modes(stress, courses[:count] / size[:, None], own, error)


def _enough(
    units: Reals, weights: Floats, loads: Floats, courses: Floats, tolerance: float
) -> tuple[int, float]:
    """The smallest number of fields with an error within the tolerance, and that error.

    It is found by bisection over some of the nodes, and confirmed at all of them.
    """
    counts = [*(count for count in _COUNTS if count < len(courses)), len(courses)]

    def error(number: int, nodes: Reals) -> float:
        count = counts[number]
        return _largest(nodes, (weights - loads[:, :count] @ courses[:count])[:, ::_EVERY])

    some, low, high = units[::_SOME], 0, len(counts) - 1
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if error(middle, some) <= tolerance else (middle + 1, high)
    for number in range(low, len(counts) - 1):
        left = error(number, units)
        if left <= tolerance:
            return counts[number], left
    return counts[-1], 0.0


def _largest(units: Reals, weights: Floats) -> float:
    """Largest von Mises stress of any node and instant."""
    blocks = (
        float(deviator_norm(product(block, weights)).max()) for block in _blocks(np.asarray(units), _NODES)
    )
    return max(blocks, default=0.0)


def _blocks(units: Reals, rows: int) -> Iterator[Reals]:
    for start in range(0, len(units), rows):
        yield deviatoric(np.asarray(units[start : start + rows], np.float32))
