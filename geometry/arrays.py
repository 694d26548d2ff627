"""Array types, named after what they hold; equal rows, and groups of linked things."""

from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Reals = npt.NDArray[np.floating[Any]]  # of either precision
Ints = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]
Vector = tuple[float, float, float]


def vector(values: Floats) -> Vector:
    """Return three numbers as plain ones."""
    x, y, z = values.tolist()
    return x, y, z


def twins(keys: Ints) -> tuple[Ints, Ints]:
    """Places (n,) of keys that occur again, in rising order of the keys, and of their next occurrences."""
    order = np.argsort(keys, kind="stable")
    same = keys[order[1:]] == keys[order[:-1]]
    return order[:-1][same], order[1:][same]


def linked_groups(count: int, first: Ints, second: Ints) -> Ints:
    """Number (count,) of the group of each thing, where `first` and `second` are the linked pairs."""
    from scipy import sparse  # noqa: PLC0415 - few rods need it
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    links = sparse.csr_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)
