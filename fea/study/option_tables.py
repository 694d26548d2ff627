"""[contact] of a study file: the pins, where the bores' pressure comes from contact."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from fea.base.choices import PinModel
from fea.study.engine_table import located_gas
from fea.study.rod_table import dimension_of
from geometry.errors import InvalidValue, require, require_number, require_positive

# Names of the [material.…] tables that belong to pins and not to parts of the rod.
PISTON_PIN, CRANK_PIN = "piston_pin", "crank_pin"
PINS = (PISTON_PIN, CRANK_PIN)


@dataclass(frozen=True)
class ContactTable:
    """[contact]: clearances are diametral, bore less pin; negative ones are press fits.

    What is left out is assumed from the size of the bores (`fea.pins.fits`). `small_end_relief_mm` is how
    far from either end the small end's bore widens towards it, and by how much of its radius.
    """

    small_end_clearance_mm: float | None = None
    big_end_clearance_mm: float | None = None
    piston_pin: PinModel = PinModel.ELASTIC
    piston_pin_bore_mm: float | None = None
    piston_pin_length_mm: float | None = None
    piston_boss_gap_mm: float | None = None
    small_end_relief_mm: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        """Refuse lengths that no pin has."""
        for key in ("small_end_clearance_mm", "big_end_clearance_mm"):
            value = getattr(self, key)
            if value is not None:
                require_number(f"contact.{key}", value)
        for key in ("piston_pin_bore_mm", "piston_pin_length_mm", "piston_boss_gap_mm"):
            value = getattr(self, key)
            if value is not None:
                require_number(f"contact.{key}", value)
                require(value >= 0, f"contact.{key}", value, "must not be negative")
        if self.small_end_relief_mm is not None:
            name, given = "contact.small_end_relief_mm", list(self.small_end_relief_mm)
            require(len(given) == 2, name, given, "must be [length, depth]")
            for value in given:
                require_positive(name, value)


# Each entry takes a cycle over all nodes, in about a second.
MOST_ENTRIES = 100
# Shares may be rounded.
_ROUNDING_PERCENT = 0.1


@dataclass(frozen=True)
class DutyTable:
    """[duty]: speeds with the hours at each, or with their shares of the time.

    `gas` is what `gas` in [engine] is, for each speed; without it, the engine's gas acts at all of them.
    """

    rpm: tuple[float, ...]
    hours: tuple[float, ...] | None = None
    share_percent: tuple[float, ...] | None = None
    gas: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        """Refuse lists that do not belong together, and a duty without time."""
        require(len(self.rpm) > 0, "duty.rpm", [], "must contain at least one speed")
        count, rule = len(self.rpm), f"must contain at most {MOST_ENTRIES} speeds"
        require(count <= MOST_ENTRIES, "duty.rpm", count, rule, "Join speeds that are close to each other.")
        for value in self.rpm:
            require_positive("duty.rpm", value)
        if (self.hours is None) == (self.share_percent is None):
            rule = "is missing" if self.hours is None else "cannot be combined with share_percent"
            remedy = "Give either hours or share_percent, a value for each speed."
            raise InvalidValue("duty.hours", None if self.hours is None else list(self.hours), rule, remedy)
        for key in ("hours", "share_percent"):
            for value in getattr(self, key) or ():
                require_positive(f"duty.{key}", value)
        for key in ("hours", "share_percent", "gas"):
            given = getattr(self, key)
            rule = f"must have as many values as duty.rpm ({len(self.rpm)})"
            require(given is None or len(given) == len(self.rpm), f"duty.{key}", list(given or ()), rule)
        if self.share_percent is not None:
            total, rule = sum(self.share_percent), "must add up to 100"
            whole = abs(total - 100) <= _ROUNDING_PERCENT
            require(whole, "duty.share_percent", list(self.share_percent), f"{rule}, not to {total:g}")

    @property
    def shares(self) -> tuple[float, ...]:
        """Share of the time at each speed; they add up to 1."""
        given = self.hours or self.share_percent or ()
        return tuple(value / sum(given) for value in given)

    @property
    def speeds(self) -> tuple[float, ...]:
        """Speeds, rpm, each once."""
        return tuple(dict.fromkeys(self.rpm))

    def located(self, folder: Path) -> "DutyTable":
        """Return the table with the paths of files made absolute."""
        if self.gas is None:
            return self
        return replace(self, gas=tuple(located_gas("duty.gas", gas, folder) for gas in self.gas))


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
