"""Values of a study that no engine has: refused or noted, with the unit that they are likely to be in.

The ranges are those of `plausible.toml`, most of them as ratios to other keys: model engines and engines of
ships are alike in their proportions.

A study that a run has written has every dimension. A dimension counts as assumed where it has the value that
this program would give it beside the others: that of a published rod, or one in usual proportions.
"""

import math
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import isclose
from typing import Any

from fea.base.note import UNITS, Note, doubt
from fea.base.shipped import shipped_toml
from fea.base.units import OTHER_UNITS
from fea.study.rod_table import KINDS, LEAST, rod_of_kind
from fea.study.tables import Written, own_unit, unit_of
from geometry.dimensions import dimensions
from geometry.errors import InvalidValue
from geometry.presets import PRESETS
from geometry.rod import Rod, proportioned

_BORES = tuple(name.removesuffix("_mm") for name in LEAST)  # and their distance
# Relative; a study has its dimensions with six digits.
_SAME = 1e-4
# Dimensions that carry the stress, by a word in the name of a place (`fea.rod.places.place_name`).
_OF_PLACES: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = (
    (
        ("shank",),
        ("shank_width", "shank_depth_big_end", "shank_depth_small_end", "flange_thickness", "web_thickness"),
    ),
    (("small end", "small-end", "bushing"), ("small_end_ring", "small_end_width", "small_end_fillet")),
    (("joint", "bolt", "cap", "nut"), ("big_end_ring", "cap_boss_length", "cap_bolt_spacing")),
    (("big end", "big-end", "shell"), ("big_end_ring", "big_end_width", "big_end_fillet")),
)


def assumed_dimensions(rod: Rod) -> frozenset[str]:
    """Return the names of the dimensions, in `geometry.dimensions`, that are this program's own."""
    given = {name: value for name in dimensions() if (value := getattr(rod, name))}
    free = [name for name in given if name not in _BORES]
    found = set()
    for own in _alike(rod):
        found |= {name for name in free if isclose(getattr(own, name), given[name], rel_tol=_SAME)}
    for name in free:
        rest = {other: value for other, value in given.items() if other != name}
        with suppress(InvalidValue):
            usual = proportioned(**rest, shank_section=rod.shank_section)
            if isclose(getattr(usual, name), given[name], rel_tol=_SAME):
                found.add(name)
    return frozenset(found)


def _alike(rod: Rod) -> Iterator[Rod]:
    """Yield the published rods, and those of a kind, with the bores of a rod and their distance."""
    bores = tuple(getattr(rod, name) for name in _BORES)
    yield from (own for own in PRESETS.values() if bores == tuple(getattr(own, n) for n in _BORES))
    for kind in KINDS:
        with suppress(InvalidValue):
            yield rod_of_kind(kind, *bores).rod


def dimensions_at(rod: Rod | None, place: str) -> tuple[str, ...]:
    """Return the names of the dimensions that carry the stress at a place, in words."""
    named = next((names for words, names in _OF_PLACES if any(word in place for word in words)), ())
    return () if rod is None else tuple(name for name in named if getattr(rod, name))


def assumed_at(rod: Rod | None, place: str) -> tuple[str, ...]:
    """Return the dimensions that carry the stress at a place, in words, if most of them are assumed."""
    named = dimensions_at(rod, place)
    if rod is None:
        return ()
    assumed = assumed_dimensions(rod) if named else frozenset()
    own = tuple(name for name in named if name in assumed)
    return own if 2 * len(own) > len(named) else ()


# What a value beyond its range costs, in parts of the range's own width on a logarithmic scale.
_OUTSIDE = 10.0
# A unit is named if it brings the values of the study this much closer to those of engines.
_BETTER = 0.5
# An integer may be larger than any float.
_LARGEST = sys.float_info.max
# Ratios of the units of length that a file may be in.
_FILE_UNITS = (25.4, 1000.0, 10.0)


@dataclass(frozen=True)
class PlausibleRange:
    """The range of a key in engines, in its own unit: a table of `plausible.toml`, which explains it."""

    key: str  #: "table.key"
    least: float
    most: float
    why: str
    of: Mapping[str, float] = field(default_factory=dict)  #: exponents of other keys by their full names
    far: float = 2.5
    refuses_less: bool = True
    below: Mapping[str, float] = field(default_factory=dict)

    def in_table(self, table: str) -> "PlausibleRange":
        """Return the range for a table, such as that of a part's material."""
        of = {other if "." in other else f"{table}.{other}": power for other, power in self.of.items()}
        return replace(self, key=f"{table}.{self.key}", of=of)

    def scale(self, values: Mapping[str, float]) -> float | None:
        """Factor of the bounds; None where the range does not apply."""
        table = self.key.rpartition(".")[0]
        below = self.below.items()
        if not all(values.get(f"{table}.{gate}", math.inf) < most for gate, most in below):
            return None
        if any(not values.get(name) for name in (self.key, *self.of)):
            return None
        return float(math.prod(values[name] ** power for name, power in self.of.items()))

    def excess(self, values: Mapping[str, float]) -> float:
        """Ln of how far the value is outside of its bounds: negative below, 0 within them."""
        scale = self.scale(values)
        if scale is None:
            return 0.0
        ratio = values[self.key] / scale
        return max(math.log(ratio / self.most), 0.0) + min(math.log(ratio / self.least), 0.0)

    def cost(self, values: Mapping[str, float]) -> float:
        """How little the value is to be expected: 0 amid its range, 1 at the bounds, then rising steeply."""
        scale = self.scale(values)
        if scale is None:
            return 0.0
        low, high = math.log(self.least), math.log(self.most)
        off = abs(2 * math.log(values[self.key] / scale) - low - high) / (high - low)
        return off**2 if off <= 1 else 1 + _OUTSIDE * (off - 1)

    def refuses(self, values: Mapping[str, float]) -> bool:
        """Whether the value is so far outside that it is refused."""
        excess = self.excess(values)
        return abs(excess) > math.log(self.far) and (excess > 0 or self.refuses_less)

    def text(self, values: Mapping[str, float], blamed: str) -> str:
        """Say what the range is, in the unit of its key; `blamed` is the key that the text is about."""
        scale = self.scale(values) or 1.0
        low, high = self.least * scale, self.most * scale
        beside = " and ".join(f"{name} = {_plain(values[name])}" for name in self.of)
        what = "it" if self.key == blamed else f"{self.key} = {_plain(values[self.key])}"
        least, most, at = _plain(low), _plain(high), f" with {beside}" if beside else ""
        return f"{what} is outside {least} to {most}, the range of engines{at} ({self.why})"


# By table and key, both keys as the file has them.
RANGES = {
    table: {key: [PlausibleRange(key, **row) for row in rows] for key, rows in keys.items()}
    for table, keys in shipped_toml("study/plausible.toml").items()
}


@dataclass(frozen=True)
class ImplausibleValue:
    """A value that engines do not have."""

    key: str  #: of the value that is likely to be wrong
    value: float
    unit: str  #: the unit that would explain it, in words; empty if none does
    range: str  #: which range is left
    refused: bool  #: whether it is far outside

    @property
    def text(self) -> str:
        """Why the value is taken to be wrong."""
        return f"{self.unit}; {self.range}" if self.unit else self.range

    @property
    def note(self) -> Note:
        """The finding as a note."""
        return doubt(f"{self.key} = {_plain(self.value)}: {self.text}", UNITS)


def implausible_values(
    values: Mapping[str, float], measured: frozenset[str] = frozenset()
) -> list[ImplausibleValue]:
    """Return the values that lie outside of the ranges of engines, the gravest first.

    `values` are magnitudes by "table.key", `measured` the lengths among them of a rod from a file: its unit
    scales all of them. A unit that was written (`Written`) is not doubted: such a value far outside is only
    noted, where no other one explains it.
    """
    ranges = [
        given.in_table(table)
        for table, _, key in (name.rpartition(".") for name in values)
        for given in RANGES.get(table.partition(".")[0], {}).get(key, ())
    ]
    ranges = [each for each in ranges if each.scale(values) is not None]
    implausible: dict[str, ImplausibleValue] = {}
    for left in sorted(ranges, key=lambda each: (not each.refuses(values), -abs(each.excess(values)))):
        if left.excess(values):
            key, unit = _likely(left, ranges, values, measured)
            doubted, refused = not isinstance(values[key], Written), left.refuses(values)
            if doubted or refused:
                value = ImplausibleValue(key, values[key], unit, left.text(values, key), refused and doubted)
                implausible.setdefault(key, value)
    return list(implausible.values())


def spared(values: Mapping[str, float]) -> bool:
    """Whether a value is not doubted, or only noted, because its unit was written."""
    return implausible_values(values) != implausible_values(
        {name: float(value) for name, value in values.items()}
    )


def _likely(
    left: PlausibleRange,
    ranges: list[PlausibleRange],
    values: Mapping[str, float],
    measured: frozenset[str],
) -> tuple[str, str]:
    """Return the key whose value is likely to be in another unit, and the unit in words, "" if it is none.

    It is the conversion of a single key after which all ranges fit best.
    """

    def cost(changed: Mapping[str, float]) -> float:
        return sum(each.cost(changed) for each in ranges)

    best, chosen = cost(values) - _BETTER, (left.key, "")
    for key in (each for each in (left.key, *left.of) if not isinstance(values[each], Written)):
        scaled = measured if key in measured else (key,)
        for factor, unit in _conversions(key, values[key], of_file=key in measured):
            changed = {**values, **{name: values[name] * factor for name in scaled}}
            least = cost(changed)
            if least < best and abs(left.excess(changed)) < abs(left.excess(values)):
                best, chosen = least, (key, unit)
    return chosen


def _conversions(key: str, value: float, *, of_file: bool) -> Iterator[tuple[float, str]]:
    if of_file:
        for factor in (unit**sign for unit in _FILE_UNITS for sign in (-1, 1)):
            fits = f"{_plain(factor)} times as long, {_plain(value * factor)} mm, it would fit"
            yield factor, f"the file seems to be in another unit ([rod] unit, or --unit): {fits}"
        return
    own = own_unit(key)
    for unit, factor in OTHER_UNITS.get(own, {}).items():
        shown = f"{_plain(value)} {unit} = {_plain(value * factor)} {unit_of(key)[1] or own}"
        yield factor, f"seems to be in {unit} ({shown})"


def _plain(value: float) -> str:
    """Return a number with four digits, without an exponent where it has a usual size."""
    return f"{float(f'{value:.4g}'):.8g}"


def magnitudes(tables: Mapping[str, Any]) -> dict[str, float]:
    """Return the magnitudes of the numbers of tables by "table.key"; of a list the largest."""
    values: dict[str, float] = {}
    for table, entries in tables.items():
        for key, value in entries.items() if isinstance(entries, Mapping) else ():
            numbers = [
                (Written if isinstance(number, Written) else float)(abs(number))
                for number in (value if isinstance(value, list | tuple) else (value,))
                if isinstance(number, int | float)
                and not isinstance(number, bool)
                and abs(number) <= _LARGEST
            ]
            if numbers:
                values[f"{table}.{key}"] = max(numbers)
    return values
