"""Stresses of designs between solved ones, the sampled designs, interpolated from their stress tensors.

All sampled designs are on one mesh, moved; `fea.apps.studio.surrogate` gives their weights and the error of
that.
"""

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from fea.analysis.buckling import compression
from fea.analysis.cycle.rows import PartRows
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.refinement import usage
from fea.analysis.speed_result import SpeedResult
from fea.apps.studio.figures import LARGEST_OF_CASES, ShownFactor, Singles, StudioFigures
from fea.apps.studio.surrogate import SAME, CutStencil, SurrogateWeights, stencils
from fea.base.material import Material
from fea.base.units import DEG, KG
from fea.judge.column import Plane, column
from fea.judge.history import FROM_TENSOR, signed_equivalent
from fea.judge.safety_factor import SafetyFactor
from fea.output.report.surface import NumberedSurface
from fea.pins.model import UnitLoads
from fea.rod.loading import EngineLoading, Loading
from fea.rod.places import SurfaceRegions, place_name
from fea.study.study import Study
from geometry.arrays import Floats, Ints, Mask, vector
from geometry.mass import MassProperties, tensor
from geometry.section import CrossSection
from loads.instants import Instants, joined

UNIT = 0.15  # a change of a dimension by this share is a unit of distance
_LEAST = 2e-4  # of the stress: the effect of elements that are curved in some rods and straight in others
LARGEST_ERROR = 0.05  # estimated share of the stress beyond which nothing is shown
# Of the largest utilisation in any load case of the first design: nodes inside the rod that are tracked, and
# rows that are judged against fatigue.
_INSIDE, _FATIGUED = 0.6, 0.75
# Relative error of superposed stresses: the series of the pins' pressure (`fea.pins.pressure`).
SUPERPOSED = 5e-4
_EVERY = 2 * DEG  # crank angles at which fatigue is judged
_RECENT = 2  # loads whose fields are kept
_MOST = 64  # sampled designs that are kept, of some 10 MB each
# Crank angle, rad, between load cases of one name that are different peaks of the cycle.
_APART = 10 * DEG
Angles = Mapping[str, float]  # crank angle, rad, by load case


@dataclass(frozen=True)
class DesignLoad:
    """The loads of every design at an operating point, and the materials."""

    study: Study
    rpm: float | None
    materials: tuple[Material, ...]

    @property
    def key(self) -> tuple[object, ...]:
        """What the load cases follow from."""
        engine = self.study.engine
        return (self.rpm, engine and (engine.gas_scale or 1.0), engine and engine.piston_mass_kg)

    @property
    def elasticity(self) -> tuple[object, ...]:
        """What the stresses under given loads follow from: in one material, not from Young's modulus."""
        first = self.materials[0].youngs_modulus
        return tuple(
            (each.youngs_modulus / first, each.poissons_ratio, each.density) for each in self.materials
        )


class _SolvedCase(NamedTuple):
    """A load case of a sampled design."""

    angle: float  #: crank angle, rad
    deviator: Singles  #: (5, n_rows) of the stress
    error: Singles  #: (n_rows,) relative to the stress


@dataclass(frozen=True, eq=False)
class SampledDesign:
    """A solved design."""

    x: Floats  #: (n,) its scaled dimensions
    loading: Callable[[Study], Loading]  #: of its length
    mass: MassProperties
    points: Singles  #: (n_nodes, 3) of the tracked nodes of the cell, mm
    column: tuple[tuple[CrossSection, ...], CrossSection]
    cases: Mapping[str, _SolvedCase]
    solved: object  #: the `DesignLoad.key` of these; None where rows are those of several parts
    parts: list[PartRows]  #: unit stresses of the rows; empty where forces are given, which do not change
    unit_loads: UnitLoads | None

    @property
    def angles(self) -> Angles:
        """Crank angles of the solved load cases, rad."""
        return {name: case.angle for name, case in self.cases.items()}

    def load_cases(self, load: DesignLoad, angles: Angles | None = None) -> Instants:
        """The load cases; where their crank angles differ from `angles` (rad, by name), those at `angles`."""
        loading = self.loading(load.study)
        cases = loading.at(self.mass, load.rpm).cases
        if not isinstance(loading, EngineLoading) or load.rpm is None or angles is None:
            return cases
        cycle = loading.crank_cycle(self.mass, load.rpm)
        return joined(
            [
                cycle.at(np.array([angles[case.name]]))[0].named(case.name) if _apart(case, angles) else case
                for case in cases
            ]
        )

    def stress(self, load: DesignLoad, cases: Instants) -> Singles:
        """Deviators (5, n_cases, n_rows) of load cases, as they were solved or superposed."""
        solved = self.cases if load.key == self.solved else {}
        known = [case.name in solved and not _apart(case, self.angles) for case in cases]
        stress = np.empty((5, len(cases), self.error("").size), np.float32)
        if not all(known):
            weights = self._spanning.weights(cases)
            every = np.concatenate([part.every(weights)[:, :5] for part in self.parts])
            stress[:] = every.transpose(1, 2, 0)
        for number in np.flatnonzero(known):
            stress[:, number] = solved[cases.names[number]].deviator
        return stress

    def error(self, name: str) -> Singles:
        """Relative error (n_rows,) of a load case; of one that was not solved, that of another."""
        return self.cases.get(name, next(iter(self.cases.values()))).error

    @property
    def _spanning(self) -> UnitLoads:
        if self.unit_loads is None:
            raise ValueError("given forces have no unit loads")
        return self.unit_loads

    def buckling(self, load: DesignLoad, cases: Instants) -> Floats:
        """Factors (2,) against buckling in either plane."""
        pushed, steel = float(compression(cases).max()), load.materials[0]
        elastic = (steel.youngs_modulus, steel.yield_strength)
        critical = [column(plane, *self.column, *elastic).least for plane in Plane]
        return np.array(critical) / pushed if pushed else np.full(2, np.inf)

    def fatigue(self, load: DesignLoad, rows: Ints) -> Floats | None:
        """Utilisation (n,) of some rows against fatigue; None without a crank cycle or strengths."""
        loading = self.loading(load.study)
        if not isinstance(loading, EngineLoading) or load.rpm is None:
            return None
        cycle = loading.crank_cycle(self.mass, load.rpm)
        weights = self._spanning.weights(cycle.at(np.arange(0, cycle.engine.cycle, _EVERY)), cycle)
        used, first = [], 0
        for part, material in zip(self.parts, load.materials, strict=True):
            of_part = rows[(rows >= first) & (rows < first + len(part.points))] - first
            first += len(part.points)
            if of_part.size:
                signed = signed_equivalent(part.stress(weights, of_part))
                extremes = signed.max(axis=1), signed.min(axis=1)
                used.append(1 / part.made_of(material).fatigue_factor(*extremes, of_part))
        found = np.concatenate(used)
        return found if found.any() else None


class TrackedNodes:
    """The nodes of a mesh that are tracked, as rows of stresses on both sides of y = 0 of each part."""

    def __init__(self, rod: PreparedRod, result: SpeedResult, surface: NumberedSurface) -> None:
        whole, cases, count = rod.mesh.mirrored, tuple(result.cases.values()), len(rod.mesh.cell.points)
        used = np.max([1 / case.of_rod for case in cases], axis=0)
        inside = np.flatnonzero(used >= _INSIDE * used.max())
        self.nodes = np.unique(whole.source[np.concatenate([surface.nodes, inside])])
        sides = (1, -1) if rod.mesh.cut_y else (1,)
        parts = [np.intersect1d(of_part, self.nodes) for of_part in rod.fields.recovery.nodes]
        node = np.concatenate([np.tile(of_part, len(sides)) for of_part in parts])
        mirrored = np.concatenate([np.repeat(sides, len(of_part)) for of_part in parts]) < 0
        self._one_part = len(parts) == 1
        self._regions: SurfaceRegions | None = None
        self.part = np.repeat(np.arange(len(parts)), [len(sides) * len(of_part) for of_part in parts])
        # The node of the whole rod of each row: the one on its side of y = 0, at z > 0.
        upper = np.flatnonzero(whole.sign[:, 2] > 0)
        images = _by_side(whole.sign[upper, 1] < 0, whole.source[upper], upper, count)
        self.whole = images[mirrored.astype(int), node]
        self._flip = np.array([1, 1, 1, -1, -1, 1])[None] ** mirrored[:, None]
        self.counts = np.asarray(cases[0].counts[self.whole])
        rows = _by_side(mirrored, node, np.arange(len(node)), count)
        source, sign = whole.source[surface.nodes], whole.sign[surface.nodes]
        self.surface = rows[(sign[:, 1] < 0).astype(int), source]  # rows of the nodes of the surface
        # Numbers of `nodes` with the signs of their coordinates, of the nodes of the surface and of each row.
        self.surface_places = np.searchsorted(self.nodes, source), sign.astype(np.float32)
        self.row_places = np.searchsorted(self.nodes, node), whole.sign[self.whole]
        self.name = cache(partial(place_name, rod.mesh))
        # Rows that may be worst against fatigue, by the load cases; else by the stress.
        used, *_ = usage(rod, cases) or (np.max([case.von_mises for case in cases], axis=0),)
        fatigued = used[self.whole]
        self.fatigued = np.flatnonzero(fatigued >= _FATIGUED * fatigued[self.counts].max())

    def sampled(self, x: Floats, load: DesignLoad, rod: PreparedRod, result: SpeedResult) -> SampledDesign:
        """Keep the rows of a solved rod."""
        given, length, parts = rod.loading, rod.mesh.bores.rod_length, list[PartRows]()
        cases = {
            name: _SolvedCase(
                float(case.load.crank_angle),
                (FROM_TENSOR[:5] @ (case.stress[self.whole] * self._flip).T).astype(np.float32),
                (case.von_mises_error / np.maximum(case.von_mises, 1e-9))[self.whole].astype(np.float32),
            )
            for name, case in result.cases.items()
        }
        if isinstance(given, EngineLoading):
            parts = self._unit_stresses(rod, load)
        return SampledDesign(
            x=x,
            loading=lambda study: EngineLoading.of(study.engine, length) if study.engine else given,
            mass=rod.mass,
            points=rod.mesh.cell.points[self.nodes].astype(np.float32),
            column=rod.shank,
            cases=cases,
            solved=load.key if self._one_part else None,
            parts=parts,
            unit_loads=rod.full_cycle.loads if parts else None,
        )

    def _unit_stresses(self, rod: PreparedRod, load: DesignLoad) -> list[PartRows]:
        """Unit stresses of the rows of each part, in single precision; all rods have the first's support."""
        analysis = rod.full_cycle
        if self._regions is None and load.rpm:
            self._regions = analysis.supported(rod.crank_cycle(load.rpm)).regions
        analysis = replace(analysis, regions=self._regions or analysis.regions)
        units = analysis.units.of(self.nodes)
        single: Any = partial(np.asarray, dtype=np.float32)
        parts = [replace(part, even=single(part.even), odd=single(part.odd)) for part in units.parts]
        basis = copy(analysis.basis)
        basis.units = replace(units, parts=tuple(parts))
        slim = replace(analysis, basis=basis, masked=np.zeros_like(analysis.masked), direct=lambda *_: [])
        return [PartRows(slim, number) for number in range(len(parts))]


def _by_side(mirrored: Mask, nodes: Ints, numbers: Ints, count: int) -> Ints:
    """Table (2, n_nodes) of the numbers of nodes and of their images, the same on the mirror plane."""
    table = np.full((2, count), -1)
    table[mirrored.astype(int), nodes] = numbers
    table[1] = np.where(table[1] < 0, table[0], table[1])
    return table


def _angles(cases: Instants) -> Angles:
    return {case.name: float(case.crank_angle) for case in cases}


def _apart(case: Instants, angles: Angles) -> bool:
    """Whether a load case is at another crank angle; that of the gas alone is at rest."""
    angle = float(case.crank_angle)
    return bool(case.in_cycle) and bool(abs(angle - angles.get(case.name, angle)) > _APART)


class SampledDesigns:
    """The sampled designs on one mesh, and what is interpolated from them."""

    def __init__(self, tracked: TrackedNodes, elasticity: tuple[object, ...]) -> None:
        self.tracked, self.elasticity = tracked, elasticity
        self.designs: list[SampledDesign] = []
        self._stencils: list[CutStencil] = []
        self._recent: dict[object, list[_LoadedDesigns]] = {}

    def add(self, design: SampledDesign) -> None:
        """Add a design, or replace the same one; of many, those near it are kept."""
        others = [each for each in self.designs if np.abs(each.x - design.x).max(initial=0.0) > SAME]
        others.sort(key=lambda each: float(np.abs(each.x - design.x).max()))
        self.designs = [design, *others][:_MOST]
        self._stencils = list(stencils(np.array([each.x for each in self.designs])))
        self._recent.clear()

    def stencil(self, x: Floats) -> CutStencil | None:
        """Return the nearest stencil that covers scaled dimensions; None beyond the sampled designs."""
        covering = (each for each in self._stencils if each.covers(x))
        return min(covering, key=lambda each: (each.distance(x), len(each.changed(x))), default=None)

    def at(self, x: Floats, load: DesignLoad) -> "InterpolatedDesign | None":
        """Interpolate at scaled dimensions; None beyond the sampled designs or with another elasticity."""
        stencil = self.stencil(x)
        if stencil is None or load.elasticity != self.elasticity:
            return None
        weights, designs = stencil.at(x), self.designs
        if not weights.lines:  # a sampled design
            weights, designs = weights._replace(weights=np.ones(1)), [self.designs[stencil.center]]
        return InterpolatedDesign(self._loaded(designs, load, weights.weights), self.tracked, weights)

    def _loaded(self, designs: list[SampledDesign], load: DesignLoad, weights: Floats) -> "_LoadedDesigns":
        """Designs under one load, with cases at about the crank angles of those of the weighted design."""
        key = (load.key, load.materials, len(designs), id(designs[0]))
        if key not in self._recent:
            kept = list(self._recent.items())[-_RECENT:]
            self._recent = dict(kept) | {key: [_LoadedDesigns(designs, load, self.tracked)]}
        loaded = self._recent[key]
        if not loaded[0].ambiguous:
            return loaded[0]
        cases = loaded[0].load_cases(weights)
        for each in loaded:
            if not any(_apart(case, each.angles) for case in cases):
                return each
        loaded.append(_LoadedDesigns(designs, load, self.tracked, _angles(cases)))
        return loaded[-1]


class _LoadedDesigns:
    """The fields of some sampled designs under one load, (n_designs, …, n_rows) each."""

    def __init__(
        self,
        designs: list[SampledDesign],
        load: DesignLoad,
        tracked: TrackedNodes,
        angles: Angles | None = None,
    ) -> None:
        self._designs, self._load, self._rows = designs, load, tracked.fatigued
        peaks = [design.load_cases(load) for design in designs]
        self.angles = _angles(peaks[0]) if angles is None else angles
        #: Whether the peak of a load case is at another crank angle in some designs than in others
        self.ambiguous = any(_apart(case, self.angles) for cases in peaks for case in cases)
        cases = [design.load_cases(load, self.angles) for design in designs] if self.ambiguous else peaks
        self.names = [case.name for case in cases[0] if all(case.name in other.names for other in cases)]
        common = [each[np.isin(each.names, self.names)] for each in cases]
        self.stress = np.stack([each.stress(load, own) for each, own in zip(designs, common, strict=True)])
        relative = [[design.error(name) for name in self.names] for design in designs]
        self.error = np.array(relative) * np.linalg.norm(self.stress, axis=1)
        strength = np.array([each.yield_strength for each in load.materials], np.float32)[tracked.part]
        self.inverse_strength = np.where(tracked.counts, 1 / strength, 0)  # of rows that count
        self.points = np.stack([design.points for design in designs])
        pairs = zip(designs, peaks, strict=True)
        self.buckling = np.stack([design.buckling(load, own) for design, own in pairs])
        self.mass = np.array([design.mass.mass for design in designs])
        self.superposed = 0.0 if all(design.solved == load.key for design in designs) else SUPERPOSED

    def load_cases(self, weights: Floats) -> Instants:
        """Load cases of a rod whose mass properties are the weighted ones."""
        near = self._designs[int(np.abs(weights).argmax())]
        masses = [design.mass for design in self._designs]
        center = weights @ np.array([mass.center for mass in masses])
        inertia = np.tensordot(weights, np.array([mass.inertia for mass in masses]), 1)
        mass = MassProperties(float(weights @ self.mass), vector(center), tensor(inertia))
        return replace(near, mass=mass).load_cases(self._load)

    @cached_property
    def fatigue(self) -> Floats | None:
        """Utilisation against fatigue (n_designs, n) of the rows where it is large."""
        used = [design.fatigue(self._load, self._rows) for design in self._designs]
        known = [each for each in used if each is not None]
        return np.stack(known) if len(known) == len(used) else None


class InterpolatedDesign:
    """Figures and stresses that are interpolated at one design."""

    def __init__(self, loaded: _LoadedDesigns, tracked: TrackedNodes, weights: SurrogateWeights) -> None:
        self._loaded, self._tracked, self._surrogate = loaded, tracked, weights
        single = weights.weights.astype(np.float32)
        self._stress = np.tensordot(single, loaded.stress, 1)
        self._von_mises = np.sqrt((self._stress**2).sum(axis=0))
        self._used = self._von_mises * loaded.inverse_strength
        error = np.maximum(0.0, np.tensordot(single, loaded.error, 1))
        self._highest = (self._used + error * loaded.inverse_strength).max(axis=1)
        self._points = np.tensordot(single, loaded.points, 1)

    @property
    def sampled(self) -> bool:
        """Whether this is a sampled design."""
        return not self._surrogate.lines

    @cached_property
    def largest_error(self) -> float:
        """Estimated interpolation error of the largest utilisation over it."""
        case, row = np.unravel_index(int(self._used.argmax()), self._used.shape)
        return self._error(int(row), int(case))

    def _error(self, row: int, case: int) -> float:
        """Estimated interpolation error of the stress at a row over it."""
        if self.sampled:
            return self._loaded.superposed
        length = max(float(self._von_mises[case, row]), 1e-9)
        direction = np.asarray(self._stress[:, case, row] / length, np.float64)
        stress = np.asarray(self._loaded.stress[:, :, case, row] / length, np.float64)
        return self._surrogate.error(stress, direction) + _LEAST + self._loaded.superposed

    @property
    def figures(self) -> StudioFigures:
        """The figures with their error bars."""
        names, worst = self._loaded.names, int(self._used.max(axis=1).argmax())
        yielding = self._yielding(worst, float(self._highest.max()))
        return StudioFigures(
            mass_kg=float(self._surrogate.weights @ self._loaded.mass) / KG,
            cases=tuple(self._yielding(number, float(most)) for number, most in enumerate(self._highest)),
            governing=names[worst],
            yielding=yielding,
            fatigue=self._fatigue(yielding.bar_percent, yielding.interpolation_percent),
            buckling=self._buckling(),
        )

    def _yielding(self, case: int, highest: float) -> ShownFactor:
        """Factor against yielding in a load case; `highest`: the utilisation with its error of the mesh."""
        row = int(self._used[case].argmax())
        used, error = float(self._used[case, row]), 100 * self._error(row, case)
        peak = float(np.where(self._tracked.counts, self._von_mises[case], 0.0).max())
        factor = self._factor(used, 100 * (highest / used - 1) + error, error, row)
        return replace(factor, name=self._loaded.names[case], peak_MPa=peak)

    def _factor(self, used: float, bar: float, error: float, row: int) -> ShownFactor:
        node, sign = (each[row] for each in self._tracked.row_places)
        place = self._tracked.name(int(self._tracked.whole[row])), vector(self._points[node] * sign)
        return ShownFactor(SafetyFactor.of_stress(1 / used, bar), *place, error)

    def _fatigue(self, bar: float, error: float) -> ShownFactor | None:
        fatigue, rows = self._loaded.fatigue, self._tracked.fatigued
        if fatigue is None:
            return None
        used = np.where(self._tracked.counts[rows], self._surrogate.weights @ fatigue, 0.0)
        return self._factor(float(used.max()), bar, error, int(rows[used.argmax()]))

    def _buckling(self) -> ShownFactor | None:
        factors = self._surrogate.weights @ self._loaded.buckling
        worst = int(factors.argmin())
        if not np.isfinite(factors[worst]):
            return None
        plane = list(Plane)[worst].value.replace("_", " ")
        return ShownFactor(SafetyFactor(float(factors[worst])), f"the shank, {plane}")

    def drawn(self, shown: str) -> tuple[Singles, Singles]:
        """Places (n, 3) and stresses (n,) of the surface: of a load case, or the largest of all."""
        names, tracked = self._loaded.names, self._tracked
        of_case = shown != LARGEST_OF_CASES and shown in names
        values = self._von_mises[names.index(shown)] if of_case else self._von_mises.max(axis=0)
        nodes, sign = tracked.surface_places
        return self._points[nodes] * sign, values[tracked.surface]
