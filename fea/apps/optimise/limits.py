"""What limits how light a rod can be: how much of each required safety factor it uses up, and where."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fea.analysis.buckling import buckling_report
from fea.analysis.prepare import PreparedRod
from fea.analysis.speed import SpeedResult
from fea.study.study import Study
from geometry.arrays import Mask

YIELDING, FATIGUE, BUCKLING = "yielding", "fatigue", "buckling"
_PLACES = ("big end", "shank", "small end")


@dataclass(frozen=True)
class Required:
    """Safety factors that a rod must have, less their error bars."""

    yielding: float
    fatigue: float
    buckling: float


def required(study: Study) -> Required:
    """Return the factors that a study asks for."""
    usual, table = study.analysis.min_safety or 1.0, study.optimise
    if table is None:
        return Required(usual, usual, usual)
    return Required(
        table.min_yield_safety or usual, table.min_fatigue_safety or usual, table.min_buckling_safety or usual
    )


@dataclass(frozen=True)
class Limit:
    """A limit on a rod, by mode of failure and place: ``"fatigue, shank"``.

    `factor` is the smallest safety factor there over all speeds, `error_percent` the error bar of the stress
    behind it, `required` what the factor less its bar must reach.
    """

    name: str
    factor: float
    error_percent: float
    required: float

    @property
    def low(self) -> float:
        """The factor if the stress is higher by its error bar."""
        return self.factor / (1 + self.error_percent / 100)

    @property
    def margin(self) -> float:
        """Share of what the rod may bear that is left, at most 1; negative where it does not hold.

        It is linear in the stress, and so the smoothest figure for a search.
        """
        return 1 - self.required / self.low


def limits(rod: PreparedRod, results: Sequence[SpeedResult], asked: Required) -> tuple[Limit, ...]:
    """Return the limits of a rod that is solved at all speeds; each is the worst of them.

    Stress limits the rod in both ends and in the shank, each by itself: the largest stress of one place
    changes smoothly with the dimensions, that of the whole rod has a kink wherever the place changes.

    Raises
    ------
    SingularMatrixError
        See `fea.analysis.buckling.buckling_report`.
    """
    worst: dict[str, Limit] = {}
    for result in results:
        for limit in (*_of_stress(rod, result, asked), *_of_buckling(rod, result, asked)):
            if limit.name not in worst or limit.margin < worst[limit.name].margin:
                worst[limit.name] = limit
    return tuple(worst.values())


def _of_stress(rod: PreparedRod, result: SpeedResult, asked: Required) -> list[Limit]:
    bar = max(case.error_percent for case in result.cases.values())
    if result.cycle is None:
        counts = np.all([case.counts for case in result.cases.values()], axis=0)
        factors = {YIELDING: np.min([case.safety_factor for case in result.cases.values()], axis=0)}
    else:
        counts, envelope = result.cycle.counts, result.cycle.envelope
        factors = {YIELDING: 1 / np.maximum(envelope.usage, 1e-300)}
        if envelope.fatigue_factor is not None:
            factors[FATIGUE] = np.where(np.isnan(envelope.fatigue_factor), np.inf, envelope.fatigue_factor)
    limits_here = []
    for place, own in zip(_PLACES, _places(rod), strict=True):
        here = own & counts
        for mode, factor in factors.items():
            least = float(factor[here].min(initial=np.inf))
            if np.isfinite(least):
                limits_here.append(Limit(f"{mode}, {place}", least, bar, getattr(asked, mode)))
    return [*limits_here, *_of_edges(result, asked)]


def _of_edges(result: SpeedResult, asked: Required) -> list[Limit]:
    """The structural stress at sharp edges, where it matters."""
    edges = [edge for case in result.cases.values() for edge in case.sharp_mattering]
    if not edges:
        return []
    worst = min(edges, key=lambda edge: edge.safety_factor / (1 + edge.error_percent / 100))
    return [Limit(f"{YIELDING}, sharp edge", worst.safety_factor, worst.error_percent, asked.yielding)]


def _places(rod: PreparedRod) -> tuple[Mask, Mask, Mask]:
    """Nodes (n_nodes,) of big end, shank and small end."""
    x, bores = rod.mesh.whole.points[:, 0], rod.mesh.bores
    shape = rod.study.rod.dimensions
    if shape is None:
        raise ValueError("only a rod with dimensions has places")
    big, small = x <= shape.big_end_radius, x >= bores.rod_length - shape.small_end_radius
    return big, ~(big | small), small


def _of_buckling(rod: PreparedRod, result: SpeedResult, asked: Required) -> list[Limit]:
    figures = buckling_report(rod, result).figures
    column = [
        Limit(f"{BUCKLING}, {plane.replace('_', ' ')}", one.safety_factor, 0.0, asked.buckling)
        for plane, one in figures.column.planes.items()
        if one.safety_factor is not None
    ]
    modes = [mode.factor for own in (figures.modes or {}).values() for mode in own]
    return [*column, Limit(f"{BUCKLING}, of the solid", min(modes), 0.0, asked.buckling)] if modes else column
