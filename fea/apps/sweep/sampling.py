"""From what varies to the designs of a sweep."""

import csv
import io
import itertools
import math
import warnings
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from fea.apps.sweep.base import kind_of
from fea.apps.sweep.variation import Variation
from fea.study.paths import require_size
from fea.study.tables import checked
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require

Design = dict[str, Any]
MOST = 1_000_000


class Sampling(StrEnum):
    """How the designs are chosen."""

    GRID = "grid"
    SOBOL = "sobol"
    LATIN = "latin-hypercube"
    RANDOM = "random"
    SALTELLI = "saltelli"


def designs(
    varied: Mapping[str, Variation], sampling: Sampling, samples: int | None, seed: int
) -> list[Design]:
    """Return the values of the varied keys, a design each; the same for the same arguments.

    A full grid; Sobol's sequence, scrambled (Owen 1998), of which a longer one continues a shorter one; a
    Latin hypercube (McKay, Beckman & Conover 1979); independent random designs; or the designs of Saltelli
    (2002) for Sobol's indices, of which there are `samples` (n_keys + 2). Raises `InvalidValue`: there would
    be too many.
    """
    if sampling is Sampling.GRID:
        lists = [variation.every() for variation in varied.values()]
        _require_few(math.prod(map(len, lists)))
        return [dict(zip(varied, values, strict=True)) for values in itertools.product(*lists)]
    count = samples or 0
    _require_few(count * (len(varied) + 2 if sampling is Sampling.SALTELLI else 1))
    shares = unit_designs(sampling, len(varied), count, seed)
    columns = [one.at(column) for one, column in zip(varied.values(), shares.T, strict=True)]
    return [dict(zip(varied, values, strict=True)) for values in zip(*columns, strict=True)]


def unit_designs(sampling: Sampling, dimensions: int, count: int, seed: int) -> Floats:
    """Return designs (n, `dimensions`) in the unit cube; for Saltelli's n is `count` (`dimensions` + 2)."""
    from scipy.stats import qmc  # noqa: PLC0415 - a grid needs none

    rng = np.random.default_rng(seed)
    if sampling is Sampling.RANDOM:
        return rng.random((count, dimensions))
    if sampling is Sampling.LATIN:
        return np.asarray(qmc.LatinHypercube(dimensions, rng=rng).random(count))
    if sampling is Sampling.SOBOL:
        return _sobol(dimensions, count, rng)
    both = _sobol(2 * dimensions, count, rng)
    return saltelli(both[:, :dimensions], both[:, dimensions:])


def saltelli(first: Floats, second: Floats) -> Floats:
    """Combine two samples (n, d) into Saltelli's, block by block in the order that SALib expects.

    A block is a row of the first sample, the same with each of its values in turn from the second sample, and
    the row of the second.
    """
    dimensions = first.shape[1]
    mixed = [np.where(np.arange(dimensions) == k, second, first) for k in range(dimensions)]
    return np.stack([first, *mixed, second], axis=1).reshape(-1, dimensions)


def _sobol(dimensions: int, count: int, rng: np.random.Generator) -> Floats:
    from scipy.stats import qmc  # noqa: PLC0415 - as above

    with (
        warnings.catch_warnings()
    ):  # that other numbers than powers of two are less even, is the user's choice
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(qmc.Sobol(dimensions, rng=rng).random(count))


def _require_few(count: int) -> None:
    rule = f"gives {count} designs; at most {MOST} are allowed"
    require(count <= MOST, "SWEEP", None, rule, "Use fewer steps or samples, or vary fewer keys.")


_LARGEST = 2**28  # bytes
_WORDS = {"true": True, "false": False}


def read_designs(path: Path) -> list[Design]:
    """Read designs.

    Raises `InvalidValue`: the file cannot be read, a column names no key of a study, or a value is not of its
    key's type.
    """
    name = path.name
    try:
        require_size("designs", path, _LARGEST)
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidValue("designs", str(path), f"cannot be read ({error})") from error
    table = csv.reader(io.StringIO(text))
    try:
        keys = [key.strip() for key in next(table, [])]
        rows = [(table.line_num, row) for row in table if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise InvalidValue("designs", name, f"is not a CSV file ({error})") from error
    kinds = {key: kind_of(key, name) for key in keys}
    require(len(kinds) == len(keys) > 0, name, keys, "must name each of its columns once, by a study's keys")
    require(0 < len(rows) <= MOST, name, len(rows), f"must have 1 to {MOST} designs")
    return [_design(f"{name}, line {line}", kinds, row) for line, row in rows]


def _design(where: str, kinds: dict[str, Any], row: list[str]) -> Design:
    rule = f"must have {len(kinds)} values, one for each column"
    require(len(row) == len(kinds), where, row, rule)
    return {
        key: _value(f"{where}, {key}", cell.strip(), kind)
        for (key, kind), cell in zip(kinds.items(), row, strict=True)
    }


def _value(name: str, cell: str, kind: Any) -> Any:
    """Return a cell as the type of its key: a number where it reads as one, else true or false, else text."""
    for read in (int, float):
        try:
            number = read(cell)
        except ValueError:
            continue
        checked(name, number, kind)
        return number
    value = _WORDS.get(cell.lower(), cell)
    checked(name, value, kind)
    return value
