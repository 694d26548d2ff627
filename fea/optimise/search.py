"""The search: COBYQA on the moved mesh of one rod, in rounds that begin with a new mesh."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.optimize import Bounds, NonlinearConstraint, minimize

from fea.optimise.designs import Design
from geometry.arrays import Floats

# How far the dimensions may change within the first round and within later ones, and the first and the last
# radius of the trust region: scaled by the bounds.
_REACH = (1.0, 0.2)
_FIRST = (0.12, 0.05)
_LAST = (0.01, 0.003)
# Of all evaluations, for the first round.
_SHARE = 0.7
# A round that saves less mass than this share is the last one: new meshes differ by about as much.
_SETTLED = 1e-3
# Up to which scaled values are the same.
_DECIMALS = 9
# Of the number of dimensions and one: a round with fewer evaluations compares only neighbours of its start.
_FEWEST = 2
# Meshes are kept for the beginning of the next round, and for a last one that is made in this round. Each may
# take as many passes as the very first one, and so many more as it is refined further.
_FURTHER = 1
# Evaluations of a study that says nothing.
USUAL = 150


class _UsedUpError(Exception):
    """The evaluations of a round are used up, some of which took several meshes."""


class Evaluator(Protocol):
    """What computes designs: `fea.optimise.designs.Designs`, or a stand-in with a known optimum.

    Attributes
    ----------
    tried
        All designs, in the order in which they were computed.
    count
        Number of meshes that were solved.
    """

    tried: list[Design]
    count: int

    def begin(self, x: Floats) -> Design:
        """Compute a design (n,) on a mesh of its own, from which others follow."""

    def at(self, x: Floats) -> Design:
        """Compute a design (n,)."""


@dataclass(frozen=True)
class Found:
    """What a search has found.

    Attributes
    ----------
    rounds
        Designs that began a round, each on a mesh of its own.
    tried
        All designs.
    count
        Meshes solved.
    ended
        Why the search ended.
    """

    rounds: tuple[Design, ...]
    tried: tuple[Design, ...]
    count: int
    ended: str

    @property
    def first(self) -> Design:
        """The rod that it began with."""
        return self.rounds[0]

    @property
    def best(self) -> Design:
        """The lightest rod that holds on a mesh of its own; where none holds, the one that lacks least."""
        return _best([design for design in self.tried if design.fresh])

    @property
    def holding(self) -> list[Design]:
        """The rods that hold on a mesh of their own, the lightest first."""
        found = [design for design in self.tried if design.fresh and design.margin >= 0]
        return sorted(found, key=lambda design: design.mass_kg)

    @property
    def holds(self) -> bool:
        """Whether the best rod holds."""
        return self.best.margin >= 0


def search(designs: Evaluator, start: Floats, most: int) -> Found:
    """Search the lightest design that holds.

    A round minimises the mass on moved copies of one mesh, on which figures change smoothly with the
    dimensions. Its result is meshed anew and begins the next round. Where the new mesh takes away some of the
    margin, the next round keeps that much in reserve.

    Parameters
    ----------
    designs
        Computes them.
    start
        (n,) where to begin, scaled.
    most
        Number of meshes that may be solved.

    Raises
    ------
    GeometryError, MeshError
        A design cannot be drawn or meshed.
    """
    rounds = [designs.begin(start)]
    spare = 2 * (designs.count + _FURTHER)
    reserve, ended = 0.0, ""
    while not ended:
        base, number = rounds[-1], min(len(rounds), len(_REACH)) - 1
        left = most - designs.count - spare
        if left < _FEWEST * (len(start) + 1):
            ended = f"the {most} evaluations are used up"
            break
        of_round = min(left, round(_SHARE * most)) if number == 0 else left
        result = _round(designs, base, of_round, number, reserve)
        if np.array_equal(result.x, base.x):
            ended = "a further round found nothing lighter"
            break
        rounds.append(designs.begin(result.x))
        if number > 0:  # the first result may be far from its mesh, later ones are not
            reserve = max(0.0, result.margin - rounds[-1].margin)
        ended = _settled(rounds)
    return Found(tuple(rounds), tuple(designs.tried), designs.count, ended)


def _round(designs: Evaluator, base: Design, most: int, number: int, reserve: float) -> Design:
    """The best design of one round."""
    names = [limit.name for limit in base.limits]
    low, high = (np.clip(base.x + side * _REACH[number], 0.0, 1.0) for side in (-1, 1))

    known = {_key(base.x): base}

    def at(x: Floats) -> Design:
        x = np.clip(x, low, high)  # constraints are asked for a little outside the bounds, too
        if _key(x) not in known:
            if designs.count >= last:
                raise _UsedUpError
            known[_key(x)] = designs.at(x)
        return known[_key(x)]

    def mass(x: Floats) -> float:
        return at(x).mass_kg / base.mass_kg

    def margins(x: Floats) -> Floats:
        design = at(x)
        found = {limit.name: limit.margin for limit in design.limits}
        return np.array([*(found.get(name, 1.0) - reserve for name in names), -design.short])

    begin, last = len(designs.tried), designs.count + most
    with suppress(_UsedUpError):
        minimize(
            mass,
            base.x,
            method="COBYQA",
            bounds=Bounds(low, high),
            constraints=NonlinearConstraint(margins, 0.0, np.inf),
            options={"initial_tr_radius": _FIRST[number], "final_tr_radius": _LAST[number], "maxfev": most},
        )
    return _best([base, *designs.tried[begin:]], reserve)


def _best(some: Sequence[Design], reserve: float = 0.0) -> Design:
    """The lightest design that holds with a reserve, or the one that lacks least."""
    holding = [design for design in some if design.margin >= reserve]
    if holding:
        return min(holding, key=lambda design: design.mass_kg)
    return max(some, key=lambda design: design.margin)


def _settled(rounds: Sequence[Design]) -> str:
    """Why no further round is needed; empty where one is."""
    last = rounds[-1]
    before = [design for design in rounds[:-1] if design.margin >= 0]
    if last.margin < 0 or len(rounds) < 3:
        return ""
    lightest = min((design.mass_kg for design in before), default=np.inf)
    if last.mass_kg >= lightest * (1 - _SETTLED):
        return f"a further round saved less than {100 * _SETTLED:g} % of the mass"
    return ""


def _key(x: Floats) -> bytes:
    """What values that differ by rounding have in common."""
    return (np.round(x, _DECIMALS) + 0.0).tobytes()
