"""The designs of a sweep with what became of each: what statistics and pictures are made of."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from fea.apps.sweep.journal import Entry, State
from geometry.arrays import Floats, Ints

MASS = "mass_kg"


@dataclass(frozen=True)
class Samples:
    """A sweep, a design each.

    Attributes
    ----------
    keys
        That vary.
    designs
        Their values, by key.
    rows
        The row of the table that is shown for a design: that of its least factor.
    values
        (n,) of each figure by its name, NaN for a design that failed or whose results are not to be trusted.
    """

    keys: tuple[str, ...]
    designs: tuple[Mapping[str, Any], ...]
    rows: tuple[int, ...]
    values: Mapping[str, Floats]

    @property
    def complete(self) -> Any:
        """Whether each design (n,) has trusted results."""
        return np.isfinite(self.values[MASS]) if MASS in self.values else np.zeros(len(self.rows), bool)

    @property
    def numeric(self) -> tuple[str, ...]:
        """The keys whose values are numbers and differ."""
        return tuple(key for key in self.keys if self._is_numeric(key))

    def column(self, key: str) -> Floats:
        """Values (n,) of a numeric key."""
        return np.array([float(design[key]) for design in self.designs])

    def part(self, chosen: Any) -> "Samples":
        """Return some of the designs, by their numbers or a mask."""
        numbers = np.arange(len(self.rows))[chosen]
        return Samples(
            self.keys,
            tuple(self.designs[n] for n in numbers),
            tuple(self.rows[n] for n in numbers),
            {name: values[numbers] for name, values in self.values.items()},
        )

    def _is_numeric(self, key: str) -> bool:
        found = [design.get(key) for design in self.designs]
        numbers = all(isinstance(value, int | float) and not isinstance(value, bool) for value in found)
        return numbers and len(set(found)) > 1


def samples_of(entries: Iterable[Entry]) -> Samples:
    """Gather the rows of a journal by their design."""
    groups = [list(group) for _, group in groupby(entries, lambda entry: entry.sample)]
    figures = dict.fromkeys(name for group in groups for entry in group for name in entry.figures)
    names = [name for name in figures if name == MASS or is_factor(name, figures)]
    values = {name: np.array([_worst(group, name) for group in groups]) for name in names}
    keys = tuple(dict.fromkeys(key for group in groups for key in group[0].design))
    return Samples(
        keys, tuple(group[0].design for group in groups), tuple(_shown(group) for group in groups), values
    )


def is_factor(name: str, figures: Iterable[str]) -> bool:
    """Whether a figure is a factor of the whole rod, not that of one of its load cases."""
    case = name.removesuffix("_factor")
    return name == "factor" or (case != name and f"{case}_von_mises_MPa" not in figures)


def _worst(group: Sequence[Entry], name: str) -> float:
    """Of several speeds the least."""
    if any(entry.state is not State.DONE or not entry.figures.get("trusted", True) for entry in group):
        return np.nan
    return float(np.min([entry.figures.get(name, np.nan) for entry in group]))


def _shown(group: Sequence[Entry]) -> int:
    return min(group, key=lambda entry: entry.figures.get("factor", np.inf)).number


def pareto_front(mass: Floats, factor: Floats) -> Ints:
    """Return the numbers of the rods on the front, the lightest first.

    Parameters
    ----------
    mass, factor
        (n,) NaN where there is no result.
    """
    known = np.flatnonzero(np.isfinite(mass) & np.isfinite(factor))
    order = known[np.lexsort([-factor[known], mass[known]])]
    best = np.maximum.accumulate(factor[order]) if len(order) else factor[order]
    before = np.concatenate([[-np.inf], best[:-1]])[: len(order)]
    return np.asarray(order[factor[order] > before])
