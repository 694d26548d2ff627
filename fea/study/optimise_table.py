"""[optimise] of a study file: which dimensions of the rod are free, and what the lightest rod must hold."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from fea.study.rod_table import dimension_of
from geometry.invalid import InvalidValue, require, require_number, require_positive

# With fewer no direction can be compared with another; with more than a quadratic model of each figure gains.
FEWEST, MOST = 20, 10_000
# What crankshaft, piston and cylinder block decide.
_FITTED = ("length_mm", "big_end_bore_mm", "small_end_bore_mm")
_NUMBER = r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
_NUMBERS = re.compile(f"{_NUMBER}:{_NUMBER}")
_BOUNDS = "must be two lengths, from and to, in mm: [4.0, 7.0]"


@dataclass(frozen=True)
class OptimiseTable:
    """[optimise]: free dimensions with their bounds, required safety factors and the least wall.

    Factors that are not given are those of `analysis.min_safety`, or 1.
    """

    free: dict[str, tuple[float, ...]] = field(default_factory=dict)
    min_yield_safety: float | None = None
    min_fatigue_safety: float | None = None
    min_buckling_safety: float | None = None
    least_wall_mm: float | None = None
    evaluations: int | None = None

    def __post_init__(self) -> None:
        """Refuse bounds that are none, dimensions that do not exist, and factors that are not positive."""
        for key, bounds in self.free.items():
            name = f"optimise.free.{key}"
            dimension_of(key)
            rule = "cannot be free: crankshaft, piston pin and cylinder block decide it"
            require(key not in _FITTED, name, None, rule, "Leave it out.")
            require(len(bounds) == 2, name, list(bounds), _BOUNDS)
            low, high = (require_positive(name, bound) for bound in bounds)
            rule = "must rise: the first bound is not below the second"
            require(low < high, name, list(bounds), rule, "Exchange them, or leave the dimension out.")
        for key in ("min_yield_safety", "min_fatigue_safety", "min_buckling_safety", "least_wall_mm"):
            value = getattr(self, key)
            if value is not None:
                require_positive(f"optimise.{key}", value)
        if self.evaluations is not None:
            require_number("optimise.evaluations", self.evaluations)
            rule = f"must lie between {FEWEST} and {MOST}"
            within = FEWEST <= self.evaluations <= MOST
            require(within, "optimise.evaluations", self.evaluations, rule)


def parse_free(given: Sequence[str]) -> dict[str, tuple[float, ...]]:
    """Return free dimensions and their bounds, mm, from ``web_thickness_mm=3:7``.

    Raises
    ------
    InvalidValue
        One is not written so.
    """
    found: dict[str, tuple[float, ...]] = {}
    for text in given:
        key, _, bounds = text.partition("=")
        numbers = _NUMBERS.fullmatch(bounds.strip())
        rule = "must name a dimension with its bounds in mm, as web_thickness_mm=3:7"
        if numbers is None:
            raise InvalidValue("--free", text, rule)
        require(key.strip() not in found, "--free", text, "names a dimension twice", "Leave one out.")
        found[key.strip()] = (float(numbers[1]), float(numbers[2]))
    return found
