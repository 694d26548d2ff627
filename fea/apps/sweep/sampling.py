"""The keys of a study that vary in a sweep, what they vary over, and the designs chosen from that."""

import csv
import io
import itertools
import math
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from fea.study.changes import TABLES
from fea.study.files import require_size
from fea.study.tables import Written, checked, full_key, hints_of, keys_of, number_of, unknown_key
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require, require_number

# The files of a run are not written by a sweep, and a sweep searches by itself.
_TABLES = tuple(name for name in TABLES if name not in ("optimise", "output"))
# Keys of a range or a distribution that have the unit of the key that varies.
_QUANTITIES = ("from", "to", "mean", "deviation", "mode")
_KEYS = (*_QUANTITIES, "steps", "distribution")
_FORMS = (
    "Give a list of values, { from = 4.0, to = 6.0 }, or a distribution between bounds: "
    '{ distribution = "normal", mean = 5.0, deviation = 0.1, from = 4.7, to = 5.3 }.'
)
_MOST_STEPS = 10_000
MOST = 1_000_000  # designs

Design = dict[str, Any]


def leaves(where: str, raw: object) -> Iterator[tuple[str, Any]]:
    """Yield each key of a table of tables and its value, in its unit: ``("rod.web_thickness_mm", value)``.

    Keys may be nested (``[vary.rod]``), dotted or quoted (``"rod.web_thickness_mm"``); `where` is the name of
    the table, for messages. Raises `InvalidValue`: it is not a table, or names a table or a key that a study
    does not have.
    """
    if not isinstance(raw, Mapping):
        raise InvalidValue(where, raw, f"must be a table, [{where}]")
    for path, value in _flat(raw, ()):
        *above, given = path
        table = TABLES.get(above[0]) if above else None
        name = given if table is None else full_key(given, keys_of(table))
        key, label, bare = ".".join((*above, name)), ".".join((where, *path)), name != given
        kind_of(key, where)
        if not isinstance(value, Mapping):
            yield key, number_of(label, value, name, bare=bare)
            continue
        numbers = {
            part: number_of(f"{label}.{part}", value[part], name, bare=bare, change=part == "deviation")
            for part in _QUANTITIES
            if part in value
        }
        yield key, {**value, **numbers}


def kind_of(key: str, where: str) -> Any:
    """Return the annotated type of a key of a study; raises `InvalidValue`: there is no such key."""
    table, _, name = key.rpartition(".")
    first, _, part = table.partition(".")
    if not table or first not in _TABLES or (part and first != "material"):
        raise unknown_key(f"[{where}]", table or key, _TABLES)
    hints = hints_of(TABLES[first])
    if name not in hints:
        raise unknown_key(f"[{where}.{table}]", name, hints)
    return hints[name]


def _flat(raw: Mapping[str, Any], above: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    materials = keys_of(TABLES["material"])
    for key, value in raw.items():
        path = (*above, *key.split("."))
        part = len(path) == 2 and path[0] == "material" and full_key(path[1], materials) not in materials
        if isinstance(value, Mapping) and (len(path) == 1 or part):
            yield from _flat(value, path)
        else:
            yield path, value


class Distribution(StrEnum):
    """The shape of a distribution."""

    UNIFORM = "uniform"
    LOG_UNIFORM = "log-uniform"
    NORMAL = "normal"
    TRIANGULAR = "triangular"


# Their keys beside the bounds.
_PARAMETERS = {Distribution.NORMAL: ("mean", "deviation"), Distribution.TRIANGULAR: ("mode",)}


@dataclass(frozen=True)
class Choice:
    """A list of values, all equally likely."""

    options: tuple[Any, ...]

    def at(self, shares: Floats) -> list[Any]:
        """Return the values at shares (n,), 0 to 1, of the list."""
        last = len(self.options) - 1
        return [self.options[min(int(share * (last + 1)), last)] for share in shares]

    def every(self) -> tuple[Any, ...]:
        """Return the values of a grid."""
        return self.options


@dataclass(frozen=True)
class Span:
    """Numbers between two bounds, by a distribution that is cut there.

    `steps` is the number of values in a grid; mean and deviation are those of a normal distribution before it
    is cut, `mode` is that of a triangular one.
    """

    low: float
    high: float
    shape: Distribution = Distribution.UNIFORM
    steps: int | None = None
    mean: float = 0.0
    deviation: float = 1.0
    mode: float = 0.0
    number: type[float] = field(default=float, repr=False)  #: `Written` where units were written

    def at(self, shares: Floats) -> list[float]:
        """Return the quantiles of shares (n,), 0 to 1."""
        return [self.number(value) for value in self._quantiles(np.asarray(shares, float))]

    def every(self) -> tuple[float, ...]:
        """Return the values of a grid: both bounds and equal steps, or equal ratios, between them."""
        spaced = np.geomspace if self.shape is Distribution.LOG_UNIFORM else np.linspace
        return tuple(map(self.number, spaced(self.low, self.high, self.steps or 1).tolist()))

    def _quantiles(self, shares: Floats) -> Floats:
        width = self.high - self.low
        if self.shape is Distribution.UNIFORM:
            return np.asarray(self.low + shares * width)
        if self.shape is Distribution.LOG_UNIFORM:
            return np.asarray(self.low * (self.high / self.low) ** shares)
        from scipy import stats  # noqa: PLC0415 - only these distributions need it

        if self.shape is Distribution.TRIANGULAR:
            return np.asarray(stats.triang.ppf(shares, (self.mode - self.low) / width, self.low, width))
        ends = (np.array([self.low, self.high]) - self.mean) / self.deviation
        return np.asarray(stats.truncnorm.ppf(shares, *ends, self.mean, self.deviation))


Variation = Choice | Span


def variation(name: str, raw: object, kind: Any, *, grid: bool) -> Variation:
    """Read what a key of type `kind` varies over. Raises `InvalidValue`: no such form, or wrong bounds."""
    if isinstance(raw, list):
        require(len(raw) > 0, name, [], "must contain at least one value", _FORMS)
        values = tuple(checked(name, value, kind) for value in raw)
        distinct, rule = len({repr(value) for value in values}), "contains a value twice"
        require(distinct == len(values), name, list(raw), rule, "Leave one out.")
        return Choice(tuple(raw))
    if not isinstance(raw, Mapping):
        raise InvalidValue(name, raw, "gives one value, so nothing varies", f"Move it to [set]. {_FORMS}")
    for key in raw:
        if key not in _KEYS:
            raise unknown_key(f"{name}:", key, _KEYS)
    real, rule = float in getattr(kind, "__args__", (kind,)), "does not take any number of a range"
    require(real, name, dict(raw), rule, "Give a list of values.")
    return _span(name, raw, kind, grid=grid)


def _span(name: str, raw: Mapping[str, Any], kind: Any, *, grid: bool) -> Span:
    shape = checked(f"{name}.distribution", raw.get("distribution", "uniform"), Distribution)
    for bound in ("from", "to"):
        rule = f"has no bound {bound!r}: a range or a distribution must have both"
        require(bound in raw, name, dict(raw), rule, _FORMS)
    low, high = (require_number(f"{name}.{bound}", raw[bound]) for bound in ("from", "to"))
    rule = f"must be above from, {low:g}"
    require(high > low, f"{name}.to", high, rule, "Exchange them, or move the value to [set].")
    for value in (low, high):
        checked(name, value, kind)
    steps = _steps(name, raw.get("steps"), grid=grid)
    numbers = _parameters(name, raw, shape)
    written = all(isinstance(raw[bound], Written) for bound in ("from", "to"))
    if "deviation" in numbers:
        require(numbers["deviation"] > 0, f"{name}.deviation", numbers["deviation"], "must be positive")
    for key in numbers.keys() & {"mean", "mode"}:
        rule = f"must lie between the bounds, {low:g} and {high:g}"
        require(low <= numbers[key] <= high, f"{name}.{key}", numbers[key], rule)
    if shape is Distribution.LOG_UNIFORM:
        require(low > 0, f"{name}.from", low, "must be positive in a log-uniform distribution")
    return Span(low, high, shape, steps, **numbers, number=Written if written else float)


def _parameters(name: str, raw: Mapping[str, Any], shape: Distribution) -> dict[str, float]:
    needed = _PARAMETERS.get(shape, ())
    for key in ("mean", "deviation", "mode"):
        rule = f"is missing: a {shape.value} distribution needs it"
        require(key not in needed or key in raw, f"{name}.{key}", None, rule)
        takes = ", ".join(needed) or "from and to alone"
        rule = f"is not of a {shape.value} distribution, which takes {takes}"
        require(key in needed or key not in raw, f"{name}.{key}", raw.get(key), rule)
    return {key: require_number(f"{name}.{key}", raw[key]) for key in needed}


def _steps(name: str, steps: object, *, grid: bool) -> int | None:
    if not grid:
        rule = 'has an effect with sampling = "grid" only'
        require(steps is None, f"{name}.steps", steps, rule, "Leave it out.")
        return None
    rule = 'is missing: with sampling = "grid", a range has steps'
    require(steps is not None, f"{name}.steps", None, rule, "Give their number, or choose another sampling.")
    return whole(f"{name}.steps", steps, 2, _MOST_STEPS, ": the values of the grid, both ends included")


def whole(name: str, value: object, low: int, high: int, meaning: str = "") -> int:
    """Return a whole number between bounds; raises `InvalidValue` for anything else."""
    if isinstance(value, int) and not isinstance(value, bool) and low <= value <= high:
        return value
    raise InvalidValue(name, value, f"must be a whole number from {low} to {high}{meaning}")


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
    grid = sampling is Sampling.GRID
    lists = [variation.every() if grid else () for variation in varied.values()]
    blocks = len(varied) + 2 if sampling is Sampling.SALTELLI else 1
    count = math.prod(map(len, lists)) if grid else (samples or 0) * blocks
    rule = f"gives {count} designs; at most {MOST} are allowed"
    require(count <= MOST, "SWEEP", None, rule, "Use fewer steps or samples, or vary fewer keys.")
    if grid:
        return [dict(zip(varied, values, strict=True)) for values in itertools.product(*lists)]
    shares = unit_designs(sampling, len(varied), samples or 0, seed)
    columns = [each.at(column) for each, column in zip(varied.values(), shares.T, strict=True)]
    return [dict(zip(varied, values, strict=True)) for values in zip(*columns, strict=True)]


def unit_designs(sampling: Sampling, dimensions: int, count: int, seed: int) -> Floats:
    """Return designs (n, `dimensions`) in the unit cube; for Saltelli's n is `count` (`dimensions` + 2)."""
    from scipy.stats import qmc  # noqa: PLC0415 - a grid needs none

    rng = np.random.default_rng(seed)
    if sampling is Sampling.RANDOM:
        return rng.random((count, dimensions))
    if sampling is Sampling.LATIN:
        return np.asarray(qmc.LatinHypercube(dimensions, rng=rng).random(count))
    twice = sampling is Sampling.SALTELLI
    with warnings.catch_warnings():  # numbers that are not powers of two are the user's choice
        warnings.simplefilter("ignore", UserWarning)
        sobol = np.asarray(qmc.Sobol((1 + twice) * dimensions, rng=rng).random(count))
    return saltelli(sobol[:, :dimensions], sobol[:, dimensions:]) if twice else sobol


def saltelli(first: Floats, second: Floats) -> Floats:
    """Combine two samples (n, d) into Saltelli's, block by block in the order that SALib expects.

    A block is a row of the first sample, the same with each of its values in turn from the second sample, and
    the row of the second.
    """
    dimensions = first.shape[1]
    mixed = [np.where(np.arange(dimensions) == k, second, first) for k in range(dimensions)]
    return np.stack([first, *mixed, second], axis=1).reshape(-1, dimensions)


_LARGEST = 2**28  # bytes
_WORDS = {"true": True, "false": False}


def read_designs(path: Path) -> list[Design]:
    """Read designs. Raises `InvalidValue`: an unreadable file, unknown key or value of another type."""
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
    rule = f"must have {len(kinds)} values, one for each column"
    for line, row in rows:
        require(len(row) == len(kinds), f"{name}, line {line}", row, rule)
    return [
        {
            key: _value(f"{name}, line {line}, {key}", key, cell.strip(), kind)
            for (key, kind), cell in zip(kinds.items(), row, strict=True)
        }
        for line, row in rows
    ]


def _value(name: str, key: str, cell: str, kind: Any) -> Any:
    for read in (int, float):
        try:
            number = read(cell)
        except ValueError:
            continue
        checked(name, number, kind)
        return number
    value = number_of(name, _WORDS.get(cell.lower(), cell), key)
    checked(name, value, kind)
    return value
