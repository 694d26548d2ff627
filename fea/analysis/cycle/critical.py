"""The smallest safety factors of a cycle, from instants that are solved directly.

Extremes from a small basis err by a known part of the largest stress. So every place whose factor may be the
smallest is looked at again. At these places stress of each instant is known to an error of its own: the
pressure that the basis leaves out then, times the stress per pressure found there. The instants that make the
factors, and any other that could change the smallest one (`fea.analysis.cycle.criteria`), join the basis, in
which they are exact, until none is left.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from fea.analysis.cycle.basis import SmallBasis
from fea.analysis.cycle.criteria import Judge, Known, crossland, tiring, yielding
from fea.analysis.cycle.envelope import Envelope
from fea.analysis.cycle.rows import PartRows
from fea.analysis.cycle.spanned_rod import SpannedRod
from fea.machine.threads import one_blas_thread
from fea.pins.model import Weights
from geometry.arrays import Ints, Mask
from mesh.mirror import MirroredMesh

# Places whose factor exceeds the smallest by more than so many errors of the basis are not looked at again;
# and at most so many of them are.
_ERRORS, _MOST_PLACES = 4, 1000
# Instants that join the basis at a time, and how often.
_AT_ONCE, _ROUNDS = 12, 12
# A stress that is nothing, MPa.
_TINY = 1e-30


def critical_places(found: Envelope, whole: MirroredMesh, counts: Mask, error: float) -> dict[Judge, Ints]:
    """Nodes of the cell with the smallest factors by each criterion that can be judged.

    `counts` (n_nodes,) of the whole rod; `error` of the basis, MPa.
    """
    factors = {
        yielding: 1 / np.maximum(found.usage, _TINY),
        tiring: found.fatigue_factor,
        crossland: found.crossland_factor,
    }
    places: dict[Judge, Ints] = {}
    for judge, factor in factors.items():
        if factor is None or not np.isfinite(judged := np.where(counts, factor, np.inf)).any():
            continue
        judged = np.nan_to_num(judged, nan=np.inf)
        worst = int(judged.argmin())
        stress = found.von_mises[worst] if judge is yielding else found.amplitude[worst]
        margin = 1 + _ERRORS * error / max(float(stress), _TINY)
        order = np.argsort(judged)[:_MOST_PLACES]
        places[judge] = np.unique(whole.source[order[judged[order] <= margin * judged[worst]]])
    return places


def make_exact(rod: SpannedRod, basis: SmallBasis, full: Weights, places: Mapping[Judge, Ints]) -> bool:
    """Let the basis grow until the smallest factor of each criterion is exact; whether it became so.

    `basis`: that of the rod; `full`: weights of the full unit loads at the instants of the cycle;
    `places`: as of `critical_places`.
    """
    for attempt in range(_ROUNDS):
        pressure = basis.pressure(basis.left(full))
        wanted = np.zeros(len(pressure), dtype=bool)
        with one_blas_thread():
            for judge, nodes in places.items():
                every, best = list(_known(rod, basis, full, nodes, judge)), np.inf
                for known in every:
                    best, _ = known.doubtful(best)
                for known in every:
                    wanted[known.needed[known.doubtful(best)[1]].any(axis=0)] = True
                if attempt == 0:
                    least = min(every, key=lambda known: float(known.least.min()))
                    wanted[least.making[least.least.argmin()]] = True
        chosen = np.flatnonzero(wanted & (pressure > 0))
        if not chosen.size:
            return True
        basis.include(full.at(np.sort(chosen[np.argsort(-pressure[chosen])[:_AT_ONCE]])))
    return False


def _known(rod: SpannedRod, basis: SmallBasis, full: Weights, nodes: Ints, judge: Judge) -> Iterator[Known]:
    """Judge both sides of the nodes of each part."""
    pressure, weights = basis.pressure(basis.left(full)), basis.projected(full)
    for number, own in enumerate(basis.units.parts):
        there = np.isin(own.nodes, nodes)
        if there.any():
            part = PartRows(rod, number, there)
            influence = np.concatenate(basis.influence(number, np.flatnonzero(there)), axis=1)
            rows, errors = np.arange(len(part.points)), influence[..., None] * pressure
            yield judge(part, rows, part.every(weights), errors)
