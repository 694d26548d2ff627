"""What the page of `fea studio` shows of a design: figures with error bars, places and stresses."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from itertools import chain

import numpy as np
import numpy.typing as npt

from fea.analysis.assembly_report import assembly_figures
from fea.analysis.buckling import column_figures
from fea.analysis.cycle.figures import fatigue_error, life_figures
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.analysis.summary import sharp_edge_figures
from fea.analysis.survival import factors_of_assembly
from fea.apps.studio.operating_point import OperatingPoint
from fea.base.checks import Check
from fea.base.units import KG
from fea.judge.case_result import CaseResult, Governing
from fea.judge.safety_factor import SafetyFactor, interval
from fea.output.life_statements import lasting
from fea.output.report.surface import NumberedSurface
from fea.rod.places import place_name
from geometry.arrays import Floats, Vector, vector
from mesh.tetmesh import FACET_CHILDREN

Singles = npt.NDArray[np.float32]
LARGEST_OF_CASES = "von_mises"  # the field of the largest stress over all load cases
MODES = YIELDING, FATIGUE, BUCKLING, BOLTS = "yielding", "fatigue", "buckling", "bolts"


class Label(StrEnum):
    """How exact the figures of a frame are."""

    INTERPOLATED = "interpolated"
    EXACT = "exact on a moved mesh"
    CONVERGED = "converged"


@dataclass(frozen=True)
class ShownFactor:
    """A safety factor, its interval, and the interval as it is printed."""

    factor: SafetyFactor
    where: str = ""  #: in words; of bolts, their mode of failure
    at_mm: Vector | None = None  #: None where it has no place
    interpolation_percent: float = 0.0  #: estimated error of interpolation; 0 where there is none
    name: str = ""  #: of the load case; empty for all
    peak_MPa: float = 0.0  #: largest von Mises stress of the load case
    #: low, high: by the errors of mesh and interpolation; infinite where these are 100 % or more
    low: float = field(init=False)
    high: float = field(init=False)
    interval: str = field(init=False)
    bar_percent: float = field(init=False)  #: of the stress behind it

    def __post_init__(self) -> None:
        vars(self).update(low=self.factor.low, high=self.factor.high, interval=interval(self.factor))
        vars(self).update(bar_percent=self.factor.percent or 0.0)

    def times(
        self, ratio: float, error_percent: float = 0.0, wider_percent: float = 0.0, peak_ratio: float = 1.0
    ) -> "ShownFactor":
        """Return it corrected by a ratio with an error of its own."""
        bar = self.bar_percent + wider_percent + error_percent
        return replace(
            self,
            factor=SafetyFactor.of_stress(float(self.factor) * ratio, bar),
            interpolation_percent=self.interpolation_percent + error_percent,
            peak_MPa=self.peak_MPa * peak_ratio,
        )


@dataclass(frozen=True, kw_only=True)
class StudioFigures:
    """The figures of a design at an operating point."""

    mass_kg: float
    cases: tuple[ShownFactor, ...]  #: against yielding in each load case
    governing: str  #: the load case of the smallest of these
    yielding: ShownFactor
    fatigue: ShownFactor | None = None  #: None where it is not computed yet, or no strength is known
    life: str = ""  #: how long it lasts, in words; empty where that is not computed
    buckling: ShownFactor | None = None  #: None where no load case compresses the rod
    bolts: ShownFactor | None = None  #: the worst of bolts and joint; None for a rod in one piece
    checks: Mapping[str, Check] | None = None  #: None where nothing was solved

    @property
    def governs(self) -> str:
        """The mode of failure with the smallest factor, less its error bar, as in `fea run`."""
        modes = {mode: factor for mode in MODES if (factor := getattr(self, mode)) is not None}
        return min(modes, key=lambda mode: modes[mode].low)


@dataclass(frozen=True, kw_only=True)
class StudioFrame:
    """Figures of a design and the picture of its stress."""

    operation: OperatingPoint
    label: Label
    figures: StudioFigures | None = None  #: None beyond the sampled designs
    base: int = 0  #: number of the mesh that was moved
    shown: str = LARGEST_OF_CASES  #: the field of `values`
    pins: str = ""  #: pin model
    corrected: bool = False  #: whether it is interpolated under a prescribed pressure, and factors corrected
    one_piece: bool = False  #: whether a rod of separate parts is solved as if it were one piece
    new_mesh: bool = False  #: whether its mesh was made for it
    #: points, values: (n, 3) places of the nodes of the surface, mm, and (n,) stress there, MPa
    points: Singles | None = field(default=None, repr=False)
    values: Singles | None = field(default=None, repr=False)
    triangles: npt.NDArray[np.int32] | None = field(default=None, repr=False)  #: of a new surface only

    def solved(self, rod: PreparedRod, result: SpeedResult, surface: NumberedSurface) -> "StudioFrame":
        """Return the frame with what was solved."""
        cases = result.cases
        shown = [cases[self.shown]] if self.shown in cases else list(cases.values())
        values = np.max([case.von_mises[surface.nodes] for case in shown], axis=0)
        return replace(
            self,
            figures=figures(rod, result),
            points=rod.mesh.whole.points[surface.nodes].astype(np.float32),
            values=values.astype(np.float32),
        )


def triangles(surface: NumberedSurface) -> npt.NDArray[np.int32]:
    """Triangles (t, 3) of a surface by the numbers of its nodes: a facet of second order is four."""
    facets = surface.facets
    if surface.middles is not None:
        facets = np.hstack([facets, surface.middles])[:, FACET_CHILDREN].reshape(-1, 3)
    return facets.astype(np.int32)


def figures(rod: PreparedRod, result: SpeedResult) -> StudioFigures:
    """Return the figures of a solved design: those of `fea run` of the same study on the same mesh."""
    cases = tuple(result.cases.values())
    worst = max(cases, key=lambda case: case.worst.value)
    assembly = assembly_figures(rod, result.cases, result.cycle)
    bolts = None if assembly is None else min(factors_of_assembly(assembly))

    def case_factor(case: CaseResult) -> ShownFactor:
        found = _at_node(rod, case.min_safety_factor, case.error_percent, case.worst.node)
        return replace(found, name=case.load.name, peak_MPa=case.max_von_mises)

    return StudioFigures(
        mass_kg=rod.mass.mass / KG,
        cases=tuple(map(case_factor, cases)),
        governing=worst.load.name,
        yielding=_yielding(rod, result, Governing.of(cases).percent),
        fatigue=_fatigue(rod, result),
        life=_life(rod, result),
        buckling=_buckling(rod, result),
        bolts=None if bolts is None else ShownFactor(bolts, bolts.mode),
        checks=result.checks,
    )


def _at_node(rod: PreparedRod, factor: float, percent: float, node: int) -> ShownFactor:
    place = place_name(rod.mesh, node), vector(rod.mesh.whole.points[node])
    return ShownFactor(SafetyFactor.of_stress(factor, percent), *place)


def _yielding(rod: PreparedRod, result: SpeedResult, percent: float) -> ShownFactor:
    worst = max((case.worst for case in result.cases.values()), key=lambda peak: peak.value)
    node, used = worst.node, worst.value
    if result.cycle is not None:
        usage = np.where(result.cycle.counts, result.cycle.envelope.usage, -np.inf)
        node, used = int(usage.argmax()), float(usage.max())
    edges = sharp_edge_figures(result.cases, rod.options.min_safety).values()
    at_edges = [ShownFactor(edge.safety_factor, f"edge {edge.name}") for edge in chain(*edges)]
    return min([_at_node(rod, 1 / used, percent, node), *at_edges], key=lambda shown: shown.factor)


def _fatigue(rod: PreparedRod, result: SpeedResult) -> ShownFactor | None:
    cycle = result.cycle
    if cycle is None or cycle.weakest is None or cycle.envelope.fatigue_factor is None:
        return None
    node = cycle.weakest.node
    percent = fatigue_error(cycle, rod, tuple(result.cases.values()))
    return _at_node(rod, float(cycle.envelope.fatigue_factor[node]), percent or 0.0, node)


def _life(rod: PreparedRod, result: SpeedResult) -> str:
    found = None if result.cycle is None else life_figures(result.cycle, rod, result.rpm)
    return "" if found is None else f"{lasting(found)}{' (assumed line)' if found.assumed else ''}"


def _buckling(rod: PreparedRod, result: SpeedResult) -> ShownFactor | None:
    """Return the smaller factor of the column formulas; None where nothing compresses the rod."""
    columns = column_figures(rod, result.loads.cases)
    factors = {plane: known for plane, item in columns.planes.items() if (known := item.safety_factor)}
    if not factors:
        return None
    plane = min(factors, key=lambda name: factors[name])
    return ShownFactor(factors[plane], f"the shank, {plane.replace('_', ' ')}")


# Error, percent, of a corrected factor in a design whose dimensions differ by this share, where contact
# changes factors much; less nearby, or where it changes all of them by less than the last share.
_ERROR_PERCENT, _AWAY, _MUCH = 8.0, 0.10, 0.05
_FURTHEST = 2.0  # times that error at most


@dataclass(frozen=True)
class ContactCorrection:
    """Ratios of the factors with pins in contact to those under a prescribed pressure, in one design.

    Contact depends on the load and on how the bores bend, so that its stresses cannot be superposed from unit
    solutions as those of a prescribed pressure can. The ratio of the factors with contact to those without
    hardly changes from one design to the next: it is that of the design that was solved last. On 50 designs
    of five rods, changed by up to ±10 % in four dimensions, corrected factors erred by less than 1 % in the
    median (`tests/benchmarks/studio_gap.py contact`).
    """

    x: Floats  #: its scaled dimensions (n,)
    load: object  #: key of what its load cases follow from
    ratios: Mapping[str, float]  #: of the factors, by load case and for ``fatigue``, where that is known
    wider: Mapping[str, float]  #: by how much, percent of the stress, bars are wider with contact
    peaks: Mapping[str, float]  #: of the largest stress, by load case
    cycle: float  #: the factor of the cycle with contact over the least of its load cases

    @classmethod
    def between(
        cls, prescribed: StudioFigures, contact: StudioFigures, x: Floats, load: object
    ) -> "ContactCorrection":
        """Compare the figures of a design with its pins in contact to those under a prescribed pressure."""
        before, after = _by_name(prescribed), _by_name(contact)
        pairs = {name: (before[name], after[name]) for name in before if name in after}
        least = min(float(case.factor) for case in contact.cases)
        return cls(
            x=x,
            load=load,
            ratios={name: float(new.factor / old.factor) for name, (old, new) in pairs.items()},
            wider={name: max(new.bar_percent - old.bar_percent, 0.0) for name, (old, new) in pairs.items()},
            peaks={name: new.peak_MPa / old.peak_MPa for name, (old, new) in pairs.items() if old.peak_MPa},
            cycle=float(contact.yielding.factor) / least,
        )

    def corrected(self, figures: StudioFigures, x: Floats, load: object) -> StudioFigures:
        """Return interpolated figures, corrected; their bars hold the error of the correction.

        `x`: relative changes (n,) of its dimensions, as those of the correction.
        """
        away = float(np.abs(x - self.x).max(initial=0.0)) / _AWAY
        away = min(away + (load != self.load), _FURTHEST)
        much = min(1.0, max((abs(ratio - 1) for ratio in self.ratios.values()), default=0.0) / _MUCH)
        error = _ERROR_PERCENT * away * much

        def times_ratio(shown: ShownFactor, name: str) -> ShownFactor:
            ratio, wider = self.ratios.get(name, 1.0), self.wider.get(name, 0.0)
            return shown.times(ratio, error, wider, self.peaks.get(name, 1.0))

        cases = tuple(times_ratio(case, case.name) for case in figures.cases)
        worst, fatigue = min(cases, key=lambda case: case.factor), figures.fatigue
        known = fatigue is not None and FATIGUE in self.ratios
        return replace(
            figures,
            cases=cases,
            governing=worst.name,
            yielding=worst.times(self.cycle),
            fatigue=times_ratio(fatigue, FATIGUE) if known and fatigue is not None else None,
        )


def _by_name(figures: StudioFigures) -> dict[str, ShownFactor]:
    """Factors of the load cases by name, and that against fatigue."""
    fatigue = {} if figures.fatigue is None else {FATIGUE: figures.fatigue}
    return {case.name: case for case in figures.cases} | fatigue
