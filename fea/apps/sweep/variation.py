"""What a key of a study varies over: a list of values, a range, or a distribution between bounds."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from fea.study.tables import checked, unknown_key
from geometry.arrays import Floats
from geometry.errors import InvalidValue, require, require_number

_KEYS = ("from", "to", "steps", "distribution", "mean", "deviation", "mode")
_FORMS = (
    "Give a list of values, { from = 4.0, to = 6.0 }, or a distribution between bounds: "
    '{ distribution = "normal", mean = 5.0, deviation = 0.1, from = 4.7, to = 5.3 }.'
)
_MOST_STEPS = 10_000


class Shape(StrEnum):
    """The shape of a distribution."""

    UNIFORM = "uniform"
    LOG_UNIFORM = "log-uniform"
    NORMAL = "normal"
    TRIANGULAR = "triangular"


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
    shape: Shape = Shape.UNIFORM
    steps: int | None = None
    mean: float = 0.0
    deviation: float = 1.0
    mode: float = 0.0

    def at(self, shares: Floats) -> list[float]:
        """Return the quantiles of shares (n,), 0 to 1."""
        return [float(value) for value in self._quantiles(np.asarray(shares, float))]

    def every(self) -> tuple[float, ...]:
        """Return the values of a grid: both bounds and equal steps, or equal ratios, between them."""
        spaced = np.geomspace if self.shape is Shape.LOG_UNIFORM else np.linspace
        return tuple(spaced(self.low, self.high, self.steps or 1).tolist())

    def _quantiles(self, shares: Floats) -> Floats:
        width = self.high - self.low
        if self.shape is Shape.UNIFORM:
            return np.asarray(self.low + shares * width)
        if self.shape is Shape.LOG_UNIFORM:
            return np.asarray(self.low * (self.high / self.low) ** shares)
        from scipy import stats  # noqa: PLC0415 - only these distributions need it

        if self.shape is Shape.TRIANGULAR:
            return np.asarray(stats.triang.ppf(shares, (self.mode - self.low) / width, self.low, width))
        ends = (np.array([self.low, self.high]) - self.mean) / self.deviation
        return np.asarray(stats.truncnorm.ppf(shares, *ends, self.mean, self.deviation))


Variation = Choice | Span


def variation(name: str, raw: object, kind: Any, *, grid: bool) -> Variation:
    """Read what a key varies over, from the TOML parser; `kind` is the annotated type of the key.

    Raises `InvalidValue`: it is none of the forms, a bound is missing, or the bounds are upside down.
    """
    if isinstance(raw, list):
        require(len(raw) > 0, name, [], "must contain at least one value", _FORMS)
        values = tuple(checked(name, value, kind) for value in raw)
        distinct, rule = len({repr(value) for value in values}), "contains a value twice"
        require(distinct == len(values), name, list(raw), rule, "Leave one out.")
        return Choice(tuple(raw))
    if not isinstance(raw, Mapping):
        raise InvalidValue(name, raw, "says one value, so nothing varies", f"Move it to [set]. {_FORMS}")
    for key in raw:
        if key not in _KEYS:
            raise unknown_key(f"{name}:", key, _KEYS)
    real, rule = float in getattr(kind, "__args__", (kind,)), "does not take any number of a range"
    require(real, name, dict(raw), rule, "Give a list of values.")
    return _span(name, raw, kind, grid=grid)


def _span(name: str, raw: Mapping[str, Any], kind: Any, *, grid: bool) -> Span:
    shape = checked(f"{name}.distribution", raw.get("distribution", "uniform"), Shape)
    for bound in ("from", "to"):
        rule = f"has no bound {bound!r}: a range or a distribution must have both"
        require(bound in raw, name, dict(raw), rule, _FORMS)
    low, high = (require_number(f"{name}.{bound}", raw[bound]) for bound in ("from", "to"))
    rule = f"must be above from, {low:g}"
    require(high > low, f"{name}.to", high, rule, "Exchange them, or move the value to [set].")
    for value in (low, high):
        checked(name, value, kind)
    steps = _steps(name, raw.get("steps"), grid=grid)
    span = Span(low, high, shape, steps, **_shape_numbers(name, raw, shape))
    between = f"must lie between the bounds, {span.low:g} and {span.high:g}"
    if span.shape is Shape.NORMAL:
        require(span.deviation > 0, f"{name}.deviation", span.deviation, "must be positive")
        require(span.low <= span.mean <= span.high, f"{name}.mean", span.mean, between)
    elif span.shape is Shape.TRIANGULAR:
        require(span.low <= span.mode <= span.high, f"{name}.mode", span.mode, between)
    elif span.shape is Shape.LOG_UNIFORM:
        require(span.low > 0, f"{name}.from", span.low, "must be positive in a log-uniform distribution")
    return span


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


_NEEDED: Mapping[Shape, tuple[str, ...]] = {
    Shape.NORMAL: ("mean", "deviation"),
    Shape.TRIANGULAR: ("mode",),
}


def _shape_numbers(name: str, raw: Mapping[str, Any], shape: Shape) -> dict[str, float]:
    needed = _NEEDED.get(shape, ())
    for key in ("mean", "deviation", "mode"):
        rule = f"is missing: a {shape.value} distribution needs it"
        require(key not in needed or key in raw, f"{name}.{key}", None, rule)
        takes = ", ".join(needed) or "from and to alone"
        rule = f"is not of a {shape.value} distribution, which takes {takes}"
        require(key in needed or key not in raw, f"{name}.{key}", raw.get(key), rule)
    return {key: require_number(f"{name}.{key}", raw[key]) for key in needed}
