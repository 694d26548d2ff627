"""The smallest safety factors of a cycle, from instants that are solved directly.

Extremes from a small basis err by a known part of the largest stress. So every place whose factor may be the
smallest is looked at again. At these places stress of each instant is known to an error of its own: the
pressure that the basis leaves out then, times the stress per pressure found there. The instants that make the
factors, and any other that could change the smallest one, join the basis, in which they are exact, until none
is left.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fea.analysis.cycle.basis import SmallBasis
from fea.analysis.cycle.envelope import Envelope
from fea.base.choices import Fatigue
from fea.base.material import Material
from fea.judge.fatigue import crossland_factors, enclosing_balls, fatigue_factor
from fea.judge.history import deviator_norm, signed_equivalent
from fea.machine.threads import one_blas_thread
from fea.pins.model import Weights
from fea.rod.surface_regions import SurfaceRegions
from geometry.arrays import Floats, Ints, Mask
from mesh.mirror import MirroredMesh

# How exactly the smallest factors are found.
WITHIN = 1e-4
# Places whose factor exceeds the smallest by more than so many errors of the basis are not looked at again;
# and at most so many of them are.
_ERRORS, _MOST_PLACES = 4, 1000
# Instants that join the basis at a time, and how often.
_AT_ONCE, _ROUNDS = 12, 12
# A stress that is nothing, MPa.
_TINY = 1e-30


class _Course(NamedTuple):
    """What the largest value of which over the instants makes a factor."""

    value: Floats  #: (n, n_instants), MPa
    error: Floats  #: likewise
    scale: Floats  #: (n,) the stress to which errors are relative, MPa


class _Judged(NamedTuple):
    """Places judged by one criterion."""

    factor: Floats  #: (n,)
    courses: tuple[_Course, ...]


_Judge = Callable[[int, Ints, Floats, Floats], _Judged | None]


@dataclass(frozen=True)
class Judges:
    """How places of a rod are judged."""

    materials: Sequence[Material]  #: one per part
    fatigue: Fatigue
    regions: SurfaceRegions  #: of the surface of the cell

    def yielding(self, number: int, nodes: Ints, history: Floats, errors: Floats) -> _Judged:  # noqa: ARG002
        """Judge histories (n, 6, n_instants) of nodes of a part, with errors (2, n, n_instants)."""
        value = deviator_norm(history)
        largest = value.max(axis=1)
        return _Judged(self.materials[number].yield_strength / largest, (_Course(value, errors[0], largest),))

    def tiring(self, number: int, nodes: Ints, history: Floats, errors: Floats) -> _Judged | None:
        """Judge histories against fatigue: as `yielding`; None if strengths are not known."""
        signed = signed_equivalent(history)
        high, low = signed.max(axis=1), signed.min(axis=1)
        amplitude, material = (high - low) / 2, self.materials[number]
        factor = fatigue_factor(
            self.fatigue, (high + low) / 2, amplitude, material, self._surface(number, nodes)
        )
        courses = tuple(_Course(sign * signed, errors[0], amplitude) for sign in (1, -1))
        return None if factor is None else _Judged(factor, courses)

    def multiaxial(self, number: int, nodes: Ints, history: Floats, errors: Floats) -> _Judged | None:
        """Judge histories by Crossland's criterion: as `tiring`."""
        factor = crossland_factors(history, self.materials[number], self._surface(number, nodes))
        if factor is None:
            return None
        radius, center = enclosing_balls(history[:, :5])
        away = np.linalg.norm(history[:, :5] - center[..., None], axis=1)
        return _Judged(factor, (_Course(away, errors[0], radius), _Course(history[:, 5], errors[1], radius)))

    def _surface(self, number: int, nodes: Ints) -> Floats:
        return self.regions.at(nodes).factors(self.materials[number])


def critical_places(found: Envelope, whole: MirroredMesh, counts: Mask, error: float) -> dict[str, Ints]:
    """Nodes of the cell with the smallest factors; `counts` (n_nodes,) of the whole rod, `error` in MPa."""
    factors = {
        "yielding": 1 / np.maximum(found.usage, _TINY),
        "tiring": found.fatigue_factor,
        "multiaxial": found.crossland_factor,
    }
    places = {}
    for name, factor in factors.items():
        if factor is None or not np.isfinite(judged := np.where(counts, factor, np.inf)).any():
            continue
        judged = np.nan_to_num(judged, nan=np.inf)
        worst = int(judged.argmin())
        stress = found.von_mises[worst] if name == "yielding" else found.amplitude[worst]
        margin = 1 + _ERRORS * error / max(float(stress), _TINY)
        order = np.argsort(judged)[:_MOST_PLACES]
        places[name] = np.unique(whole.source[order[judged[order] <= margin * judged[worst]]])
    return places


def make_exact(basis: SmallBasis, full: Weights, places: Mapping[str, Ints], judges: Judges) -> bool:
    """Let the basis grow until the smallest factor of each criterion is exact; whether it became so.

    `full`: weights of the full unit loads at the instants of the cycle; `places`: as of `critical_places`.
    """
    for attempt in range(_ROUNDS):
        pressure, weights = basis.pressure(basis.left(full)), basis.projected(full)
        wanted = set[int]()
        with one_blas_thread():
            for name, nodes in places.items():
                judged = list(_judged(basis, weights, pressure, nodes, getattr(judges, name)))
                wanted |= set(_open(judged, first=attempt == 0))
        chosen = sorted((t for t in wanted if pressure[t] > 0), key=lambda t: -pressure[t])[:_AT_ONCE]
        if not chosen:
            return True
        basis.include(full.at(np.array(sorted(chosen))))
    return False


def _judged(
    basis: SmallBasis, weights: Weights, pressure: Floats, nodes: Ints, judge: _Judge
) -> Iterator[_Judged]:
    """Judge both sides of the nodes of each part."""
    for number, part in enumerate(basis.units.parts):
        rows = np.flatnonzero(np.isin(part.nodes, nodes))
        if not rows.size:
            continue
        sides = part.histories(weights, basis.units.sides, rows)
        for history, influence in zip(sides, basis.influence(number, rows), strict=True):
            judged = judge(number, part.nodes[rows], history, influence[..., None] * pressure)
            if judged is not None:
                yield judged


def _open(judged: Sequence[_Judged], *, first: bool) -> Iterator[int]:
    """Instants that must be exact for the smallest factor to be; the `first` time also those that make it."""
    least = min((float(own.factor.min()) for own in judged), default=np.inf)
    for own in judged:
        sure = [(course.value - course.error).max(axis=1) for course in own.courses]
        gaps = [
            ((course.value + course.error).max(axis=1) - low) / np.maximum(course.scale, _TINY)
            for course, low in zip(own.courses, sure, strict=True)
        ]
        widest = np.max(gaps, axis=0)
        open_ = (own.factor * (1 - 2 * widest) < least) & (widest > WITHIN)
        rows = {int(np.where(open_, widest, -1.0).argmax())} if open_.any() else set()
        smallest = int(own.factor.argmin())
        making = first and own.factor[smallest] == least
        for row in rows | ({smallest} if making or open_[smallest] else set()):
            for course, low, gap in zip(own.courses, sure, gaps, strict=True):
                if making and row == smallest:
                    yield int(course.value[row].argmax())
                if gap[row] > WITHIN:
                    near = course.value[row] + course.error[row] >= low[row]
                    yield int(np.where(near, course.error[row], -1.0).argmax())
