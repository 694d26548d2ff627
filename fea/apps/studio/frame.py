"""What the page of `fea studio` shows of a design: figures with their bars, places and stresses."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from itertools import chain

import numpy as np
import numpy.typing as npt

from fea.analysis.assembly_report import assembly_figures
from fea.analysis.buckling import column_figures
from fea.analysis.cycle.figures import fatigue_error
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.analysis.summary import sharp_edge_figures
from fea.analysis.survival import factors_of_assembly
from fea.apps.studio.operation import Operation
from fea.base.checks import Check
from fea.base.note import NoteKind
from fea.base.units import KG
from fea.judge.case_result import CaseResult, Governing
from fea.judge.safety_factor import SafetyFactor, interval
from fea.output.report.surface import NumberedSurface
from fea.rod.places import place_name
from geometry.arrays import Vector, vector
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
class Factor:
    """A safety factor, its interval, and the interval as it is printed."""

    factor: SafetyFactor
    #: low, high: by the error of the mesh and the gap; without an upper end where these are 100 % or more
    low: float
    high: float
    interval: str
    bar_percent: float  #: of the stress behind it
    gap_percent: float  #: estimated error of interpolation; 0 where there is none
    where: str = ""
    at_mm: Vector | None = None  #: None where it has no place

    @classmethod
    def of(
        cls, known: SafetyFactor, where: str = "", at_mm: Vector | None = None, gap_percent: float = 0.0
    ) -> "Factor":
        """Return what the page shows of a safety factor."""
        bar = known.percent or 0.0
        return Factor(known, known.low, known.high, interval(known), bar, gap_percent, where, at_mm)


@dataclass(frozen=True, kw_only=True)
class CaseFigures(Factor):
    """The factor against yielding in a load case, and its largest von Mises stress."""

    name: str
    peak_MPa: float


@dataclass(frozen=True, kw_only=True)
class Figures:
    """The figures of a design at an operation."""

    mass_kg: float
    cases: tuple[CaseFigures, ...]
    governing: str  #: the load case of the smallest factor against yielding
    yielding: Factor
    fatigue: Factor | None = None  #: None where it is not worked out yet, or no strength is known
    buckling: Factor | None = None  #: None where no load case compresses the rod
    bolts: Factor | None = None  #: of bolts or joint, `where` says which; None for a rod in one piece
    checks: Mapping[str, Check] | None = None  #: None where nothing was solved
    notes: tuple[str, ...] = ()

    @property
    def governs(self) -> str:
        """The mode of failure with the smallest factor, less its error bar, as in `fea run`."""
        modes = {mode: known for mode in MODES if (known := getattr(self, mode)) is not None}
        return min(modes, key=lambda mode: modes[mode].low)


@dataclass(frozen=True, kw_only=True)
class Frame:
    """A design, and what is known of it."""

    design: Mapping[str, float]
    operation: Operation
    label: Label
    figures: Figures | None = None  #: None beyond the anchors
    base: int = 0  #: number of the mesh that was moved
    shown: str = LARGEST_OF_CASES  #: the field of `values`
    pins: str = ""  #: what loads the bores
    corrected: bool = False  #: whether it is interpolated under a prescribed pressure, and factors corrected
    one_piece: bool = False  #: whether a rod of separate parts is solved as if it were one piece
    new_mesh: bool = False  #: whether its mesh was made for it
    #: points, values: (n, 3) places of the nodes of the surface, mm, and (n,) stress there, MPa
    points: Singles | None = field(default=None, repr=False)
    values: Singles | None = field(default=None, repr=False)
    triangles: npt.NDArray[np.int32] | None = field(default=None, repr=False)  #: of a new surface alone


def triangles(surface: NumberedSurface) -> npt.NDArray[np.int32]:
    """Triangles (t, 3) of a surface by the numbers of its nodes: a facet of second order is four."""
    facets = surface.facets
    if surface.middles is not None:
        facets = np.hstack([facets, surface.middles])[:, FACET_CHILDREN].reshape(-1, 3)
    return facets.astype(np.int32)


def figures(rod: PreparedRod, result: SpeedResult) -> Figures:
    """Return the figures of what was solved; those of `fea run` of the same study on the same mesh."""
    cases = tuple(result.cases.values())
    governing = Governing.of(cases)
    worst = max(cases, key=lambda case: case.worst.value)
    return Figures(
        mass_kg=rod.mass.mass / KG,
        cases=tuple(_case(rod, case) for case in cases),
        governing=worst.load.name,
        yielding=_yielding(rod, result, governing.percent),
        fatigue=_fatigue(rod, result),
        buckling=buckling(rod, result),
        bolts=_bolts(rod, result),
        checks=result.checks,
        notes=tuple(str(note) for note in result.notes if note.kind in (NoteKind.DOUBT, NoteKind.WARNING)),
    )


def _yielding(rod: PreparedRod, result: SpeedResult, percent: float) -> Factor:
    worst = max((case.worst for case in result.cases.values()), key=lambda one: one.value)
    node, used = worst.node, worst.value
    if result.cycle is not None:
        usage = np.where(result.cycle.counts, result.cycle.envelope.usage, -np.inf)
        node, used = int(usage.argmax()), float(usage.max())
    found = _factor(rod, 1 / used, percent, node)
    every = sharp_edge_figures(result.cases, rod.options.min_safety).values()
    edges = [Factor.of(edge.safety_factor, f"edge {edge.name}") for edge in chain.from_iterable(every)]
    return min(found, *edges, key=lambda one: one.factor) if edges else found


def _fatigue(rod: PreparedRod, result: SpeedResult) -> Factor | None:
    cycle = result.cycle
    if cycle is None or cycle.weakest is None or cycle.envelope.fatigue_factor is None:
        return None
    node = cycle.weakest.node
    percent = fatigue_error(cycle, rod, tuple(result.cases.values()))
    return _factor(rod, float(cycle.envelope.fatigue_factor[node]), percent or 0.0, node)


def _bolts(rod: PreparedRod, result: SpeedResult) -> Factor | None:
    assembly = assembly_figures(rod, result.cases, result.cycle)
    if assembly is None:
        return None
    worst = min(factors_of_assembly(assembly))
    return Factor.of(worst, worst.mode)


def _factor(rod: PreparedRod, factor: float, percent: float, node: int) -> Factor:
    known = SafetyFactor.of_stress(factor, percent)
    return Factor.of(known, place_name(rod.mesh, node), vector(rod.mesh.whole.points[node]))


def _case(rod: PreparedRod, case: CaseResult) -> CaseFigures:
    found = _factor(rod, case.min_safety_factor, case.error_percent, case.worst.node)
    return CaseFigures(**vars(found), name=case.load.name, peak_MPa=case.max_von_mises)


def buckling(rod: PreparedRod, result: SpeedResult) -> Factor | None:
    """Return the smaller factor of the column formulas; None where nothing compresses the rod."""
    columns = column_figures(rod, result.loads.cases)
    factors = {plane: one.safety_factor for plane, one in columns.planes.items() if one.safety_factor}
    if not factors:
        return None
    plane = min(factors, key=lambda name: factors[name])
    return Factor.of(factors[plane], f"the shank, {plane.replace('_', ' ')}")


def solved(frame: Frame, rod: PreparedRod, result: SpeedResult, surface: NumberedSurface) -> Frame:
    """Return a frame with what was solved."""
    cases = result.cases
    some = [cases[frame.shown]] if frame.shown in cases else list(cases.values())
    values = np.max([case.von_mises[surface.nodes] for case in some], axis=0)
    return replace(
        frame,
        figures=figures(rod, result),
        points=rod.mesh.whole.points[surface.nodes].astype(np.float32),
        values=values.astype(np.float32),
    )
