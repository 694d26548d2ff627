"""The envelope: the worst values of the cycle at every node."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.analysis.cycle.screened import ExtremeBounds, extremes, path
from fea.analysis.cycle.unit_solutions import PartStress, PlaceHistory, UnitSolutions, spots
from fea.base.choices import Fatigue
from fea.base.material import Material
from fea.base.units import DEG
from fea.judge.case_result import CaseResult
from fea.judge.fatigue import crossland_bound, crossland_factors, fatigue_factor
from fea.judge.history import deviatoric
from fea.judge.verdict import safety_factor
from fea.pins.model import Weights
from fea.rod.places import SurfaceRegions
from geometry.arrays import Floats, Ints, Mask
from mesh.tetmesh import MirroredMesh

# Written instead of a fatigue factor if the strengths of a part are not known: NaN would break the ranges and
# filters of viewers.
NOT_JUDGED = -1.0


@dataclass(frozen=True)
class Envelope:
    """Extreme values over the cycle on the whole rod, each (n_nodes,)."""

    #: von_mises, crank_angle: largest von Mises stress, MPa, and its crank angle, rad; at an interface, the
    #: larger of both parts
    von_mises: Floats
    crank_angle: Floats
    #: principal_1, principal_3: largest and least principal stress, MPa; at an interface, of both parts
    principal_1: Floats
    principal_3: Floats
    #: mean, amplitude, ratio: of the signed equivalent stress (see `fea.judge.history`), MPa; R = least over
    #: largest. They belong to the fatigue factor.
    mean: Floats
    amplitude: Floats
    ratio: Floats
    safety_factor: Floats  #: against yielding, at most `fea.judge.verdict.CAP`
    #: usage, usage_angle: largest von Mises stress over yield strength, 0 in linings; its crank angle, rad
    usage: Floats
    usage_angle: Floats
    #: Against fatigue: None if no part's strengths are known, NaN at nodes of parts whose are not
    fatigue_factor: Floats | None
    #: By Crossland's criterion (`fea.analysis.cycle.envelope`): None and NaN likewise
    crossland_factor: Floats | None
    #: part, fatigue_part: at an interface, the part that is closer to yielding, and the part that the mean,
    #: amplitude and ratio belong to: the one with the smaller fatigue factor or, if none is known, the one
    #: closer to yielding
    part: Ints
    fatigue_part: Ints
    #: Endurance limit with the factor of the surface, MPa, of `fatigue_part`, NaN where it is not known; None
    #: if every surface is as good as polished
    endurance: Floats | None = None

    def point_data(self) -> dict[str, npt.NDArray[np.floating[Any]]]:
        """Arrays at the nodes, by their names in the VTU file.

        The angle comes first and in single precision: meshio 5.3.5 may confuse two arrays in files whose
        arrays are all of one size, if the offset of one is four thirds of that of another.
        """
        data: dict[str, npt.NDArray[np.floating[Any]]] = {
            "crank_deg": (self.crank_angle / DEG).astype(np.float32),
            "von_mises": self.von_mises,
            "principal_1": self.principal_1,
            "principal_3": self.principal_3,
            "mean": self.mean,
            "amplitude": self.amplitude,
            "stress_ratio": self.ratio,
            "safety_factor_node": self.safety_factor,
        }
        factors = {
            "fatigue_safety_factor": self.fatigue_factor,
            "crossland_safety_factor": self.crossland_factor,
            "endurance_limit": self.endurance,
        }
        judged = {name: factor for name, factor in factors.items() if factor is not None}
        return data | {name: np.nan_to_num(factor, nan=NOT_JUDGED) for name, factor in judged.items()}


def envelope(
    units: UnitSolutions,
    weights: Weights,
    angles: Floats,
    whole: MirroredMesh,
    *,
    materials: Sequence[Material],
    criterion: Fatigue,
    regions: SurfaceRegions,
) -> Envelope:
    """Extremes for `weights` of even and odd loads (n_units, n_instants) at `angles` (n_instants,), rad."""
    order = np.argsort(angles)
    along, angles = path(weights.at(order), units.joint), angles[order]
    reached = extremes(units.parts, along, units.sides)
    merged: Envelope | None = None
    for number, (part, material, sides) in enumerate(zip(units.parts, materials, reached, strict=True)):
        reach = _on_whole(part, sides, whole)
        of_part = _judged(reach, angles, material, criterion, number, surface=regions.factors(material))
        merged = of_part if merged is None else _worse(merged, of_part)
    if merged is None:
        raise ValueError("a rod has at least one part")
    return merged


def _on_whole(part: PartStress, sides: list[ExtremeBounds], whole: MirroredMesh) -> ExtremeBounds:
    """Map extreme values at a part's nodes to the whole rod; NaN (instant 0) elsewhere."""
    names = [field.name for field in dataclasses.fields(ExtremeBounds)]
    fields = {name: carried(part, [getattr(side, name) for side in sides], whole) for name in names}
    return ExtremeBounds(**fields | {"instant": np.nan_to_num(fields["instant"]).astype(int)})


def carried(part: PartStress, sides: Sequence[Floats], whole: MirroredMesh) -> npt.NDArray[np.float64]:
    """Map values (n,) at a part's nodes, and at their images, to the whole rod; NaN elsewhere."""
    place = np.full(int(whole.source.max()) + 1, -1)
    place[part.nodes] = np.arange(len(part.nodes))
    place = place[whole.source]
    values = sides[0][place]
    if len(sides) > 1:
        values = np.where(whole.sign[:, 1] < 0, sides[1][place], values)
    return np.where(place < 0, np.nan, values)


def _judged(
    reach: ExtremeBounds,
    angles: Floats,
    material: Material,
    criterion: Fatigue,
    number: int,
    *,
    surface: Floats | float = 1.0,
) -> Envelope:
    usage, angle = reach.von_mises / material.yield_strength, angles[reach.instant]
    usage = 0.0 * usage if material.lining else usage
    return Envelope(
        von_mises=reach.von_mises,
        crank_angle=angle,
        principal_1=reach.principal_1,
        principal_3=reach.principal_3,
        mean=reach.mean,
        amplitude=reach.amplitude,
        ratio=reach.ratio,
        safety_factor=safety_factor(reach.von_mises, material.yield_strength),
        usage=usage,
        usage_angle=angle,
        fatigue_factor=fatigue_factor(criterion, reach.mean, reach.amplitude, material, surface),
        crossland_factor=crossland_bound(reach.radius, reach.tension, material, surface),
        part=np.full(len(usage), number),
        fatigue_part=np.full(len(usage), number),
    )


def _worse(one: Envelope, other: Envelope) -> Envelope:
    """Merge two parts with common nodes: extremes of both, and the history of the one closer to failure."""
    worse = np.isnan(one.usage) | (other.usage > one.usage)
    tired = _tires_first(one, other, worse)
    more = np.isnan(one.von_mises) | (other.von_mises > one.von_mises)
    follows = dict.fromkeys(("von_mises", "crank_angle"), more)
    follows |= dict.fromkeys(("mean", "amplitude", "ratio", "fatigue_part"), tired)
    follows |= dict.fromkeys(("safety_factor", "usage", "usage_angle", "part"), worse)
    return dataclasses.replace(
        one,
        principal_1=np.fmax(one.principal_1, other.principal_1),
        principal_3=np.fmin(one.principal_3, other.principal_3),
        fatigue_factor=_lesser(one.fatigue_factor, other.fatigue_factor),
        crossland_factor=_lesser(one.crossland_factor, other.crossland_factor),
        **{name: np.where(own, getattr(other, name), getattr(one, name)) for name, own in follows.items()},
    )


def _tires_first(one: Envelope, other: Envelope, worse: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Where the fatigue factor of the other is the smaller or the only one; `worse` where there is none."""
    unknown = np.full(worse.shape, np.nan)
    first, second = (unknown if of.fatigue_factor is None else of.fatigue_factor for of in (one, other))
    known, more = ~np.isnan(first), ~np.isnan(second)
    return np.where(known & more, second < first, np.where(known | more, more, worse))


def _lesser(one: Floats | None, other: Floats | None) -> Floats | None:
    known = [factor for factor in (one, other) if factor is not None]
    return np.asarray(np.fmin.reduce(known)) if known else None


def with_cases(envelope: Envelope, cases: Sequence[CaseResult]) -> Envelope:
    """Extend the envelope to the directly solved peak cases.

    Their von Mises and principal stresses are included, also those of ``gas``, which is not an instant of the
    cycle; mean and amplitude come from the cycle only.
    """
    for case in cases:
        more = case.von_mises > envelope.von_mises
        worse = case.of_rod < envelope.safety_factor  # so it is below the cap
        angle = case.load.crank_angle
        envelope = dataclasses.replace(
            envelope,
            von_mises=np.where(more, case.von_mises, envelope.von_mises),
            crank_angle=np.where(more & ~np.isnan(angle), angle, envelope.crank_angle),
            principal_1=np.maximum(envelope.principal_1, case.principal[:, 0]),
            principal_3=np.minimum(envelope.principal_3, case.principal[:, 2]),
            safety_factor=np.where(worse, case.of_rod, envelope.safety_factor),
            usage=np.where(worse, 1 / case.of_rod, envelope.usage),
            usage_angle=np.where(worse & ~np.isnan(angle), angle, envelope.usage_angle),
        )
    return envelope


def replaced(one: Envelope, other: Envelope, there: Mask) -> Envelope:
    """Return an envelope with the values of another one at some nodes (n_nodes,)."""
    fields = (field.name for field in dataclasses.fields(one) if getattr(other, field.name) is not None)
    return dataclasses.replace(
        one, **{name: np.where(there, getattr(other, name), getattr(one, name)) for name in fields}
    )


BLOCK = 64  # places evaluated at a time


def worst_multiaxial(
    reached: Envelope,
    units: UnitSolutions,
    weights: Weights,
    whole: MirroredMesh,
    materials: Sequence[Material],
    *,
    counts: Mask,
    regions: SurfaceRegions,
) -> tuple[PlaceHistory | None, Floats | None]:
    """Return the place of the smallest Crossland factor, and the factor of every node, or None if unknown.

    They are unknown if no part's endurance limit is known. Nodes are evaluated in the order of their bounds
    until the next bound exceeds the smallest factor found; nodes that do not count (n_nodes,) are left out.
    At an interface the smaller factor of the parts is used. `regions` are those of the whole rod's surface.
    """
    if reached.crossland_factor is None:
        return None, None
    factor = reached.crossland_factor.copy()
    # An image across z = 0 has the same history.
    image = 2 * whole.source + (whole.sign[:, 1] < 0)
    once = np.flatnonzero(counts & np.isfinite(factor) & (whole.sign[:, 2] > 0))
    order = once[factor[once].argsort()]
    exact = np.full(int(image.max()) + 1, np.nan)
    holds = np.zeros((len(units.parts), int(whole.source.max()) + 1), dtype=bool)
    for part, held in zip(units.parts, holds, strict=True):
        held[part.nodes] = True
    surface = [regions.factors(material) for material in materials]
    worst, best = None, np.inf
    for start in range(0, len(order), BLOCK):
        nodes = order[start : start + BLOCK]
        if factor[nodes[0]] >= best:
            break
        chosen = nodes[factor[nodes] < best]
        numbers, rows = np.nonzero(holds[:, whole.source[chosen]])
        places = list(zip(chosen[rows].tolist(), numbers.tolist(), strict=True))
        for spot in spots(places, units, weights, whole):
            history, skin = deviatoric(spot.stress)[None], float(surface[spot.part][spot.node])
            factors = crossland_factors(history, materials[spot.part], skin)
            if factors is None:
                continue
            exact[image[spot.node]] = np.fmin(exact[image[spot.node]], factors[0])
            if factors[0] < best:
                worst, best = spot, float(factors[0])
    return worst, np.where(np.isnan(exact[image]), factor, exact[image])
