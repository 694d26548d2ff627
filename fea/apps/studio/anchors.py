"""Stresses between designs that are solved, interpolated from the stress tensors of these, the anchors.

All anchors are on one mesh, moved; `fea.apps.studio.stars` says how they are added up, and the error of that.
"""

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import Any

import numpy as np

from fea.analysis.buckling import compression
from fea.analysis.cycle.rows import PartRows
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.refinement import usage
from fea.analysis.speed_result import SpeedResult
from fea.apps.studio.frame import LARGEST_OF_CASES, CaseFigures, Factor, Figures, Singles
from fea.apps.studio.stars import SAME, Mix, Star, stars
from fea.base.material import Material
from fea.base.units import DEG, KG
from fea.judge.column import Plane, column
from fea.judge.history import FROM_TENSOR, signed_equivalent
from fea.judge.safety_factor import SafetyFactor
from fea.output.report.surface import NumberedSurface
from fea.pins.model import UnitLoads
from fea.rod.loading import EngineLoading, Loading
from fea.rod.places import place_name
from fea.study.study import Study
from geometry.arrays import Floats, Ints, vector
from geometry.mass import MassProperties, tensor
from geometry.section import Section
from loads.instants import Instants, joined

UNIT = 0.15  # a change of a dimension by this share is a unit of distance
_LEAST = 2e-4  # of the stress: what elements change that are curved in some rods and straight in others
VAGUE = 0.05  # share of the stress beyond which nothing is shown
# Of the largest utilisation in any load case of the first anchor: nodes inside the rod that are followed, and
# of that against fatigue.
_INSIDE, _TIRED = 0.6, 0.75
# Relative error of stresses that are superposed: the series of the pins' pressure (`fea.pins.prescribed`).
SUPERPOSED = 5e-4
_EVERY = 2 * DEG  # crank angles at which fatigue is looked at
_RECENT = 2  # loads whose fields are kept
_MOST = 64  # anchors that are kept, of some 10 MB each
# Crank angle, rad, between load cases of one name that are different peaks of the cycle.
_TURN = 10 * DEG
Angles = Mapping[str, float]  # crank angle, rad, by load case


@dataclass(frozen=True)
class Loaded:
    """What loads a rod, and what it is made of."""

    study: Study
    rpm: float | None
    materials: tuple[Material, ...]

    @property
    def key(self) -> tuple[object, ...]:
        """What the load cases follow from."""
        engine = self.study.engine
        return (self.rpm, engine and (engine.gas_scale or 1.0), engine and engine.piston_mass_kg)

    @property
    def elastic(self) -> tuple[object, ...]:
        """What the stresses under given loads follow from: in one material, not from Young's modulus."""
        first = self.materials[0].youngs_modulus
        return tuple((one.youngs_modulus / first, one.poissons_ratio, one.density) for one in self.materials)


@dataclass(frozen=True, eq=False)
class Anchor:
    """A design that is solved."""

    x: Floats  #: (n,) its scaled dimensions
    loading: Callable[[Study], Loading]  #: of its length
    mass: MassProperties
    points: Singles  #: (n_nodes, 3) of the nodes of the cell that are followed
    parts: list[PartRows]  #: their unit stresses
    loads: UnitLoads | None  #: None where forces are given, which do not change
    solved: tuple[object, ...]  #: the `Loaded.key` for which its load cases are solved
    deviators: Mapping[str, Singles]  #: (5, n_rows) of each of these; empty where there are several parts
    angles: Angles  #: their crank angles
    errors: Mapping[str, Singles]  #: (n_rows,) of each, relative to the stress
    column: tuple[tuple[Section, ...], Section]

    def cases(self, loaded: Loaded, angles: Angles | None = None) -> Instants:
        """The load cases; those at other crank angles than these (rad, by name) are taken there instead."""
        loading = self.loading(loaded.study)
        cases = loading.at(self.mass, loaded.rpm).cases
        if not isinstance(loading, EngineLoading) or loaded.rpm is None or angles is None:
            return cases
        cycle = loading.crank_cycle(self.mass, loaded.rpm)
        return joined(
            [
                cycle.at(np.array([angles[case.name]]))[0].named(case.name) if _apart(case, angles) else case
                for case in cases
            ]
        )

    def stress(self, loaded: Loaded, cases: Instants) -> Singles:
        """Deviators (5, n_cases, n_rows) of load cases, as they were solved or superposed."""
        same = loaded.key == self.solved
        solved = [same and case.name in self.deviators and not _apart(case, self.angles) for case in cases]
        pairs = zip(cases.names, solved, strict=True)
        own = [self.deviators[name] if there else None for name, there in pairs]
        if not all(solved):
            weights = self._unit_loads.weights(cases)
            every = np.concatenate([part.every(weights)[:, :5] for part in self.parts])
            own = [every[..., number].T if one is None else one for number, one in enumerate(own)]
        return np.stack([one for one in own if one is not None], axis=1).astype(np.float32)

    @property
    def _unit_loads(self) -> UnitLoads:
        if self.loads is None:
            raise ValueError("given forces have no unit loads")
        return self.loads

    def buckles(self, loaded: Loaded, cases: Instants) -> Floats:
        """Forces (2,) at which it buckles in either plane, over what compresses it."""
        pushed, steel = float(compression(cases).max()), loaded.materials[0]
        elastic = (steel.youngs_modulus, steel.yield_strength)
        critical = [column(plane, *self.column, *elastic).least for plane in Plane]
        return np.array(critical) / pushed if pushed else np.full(2, np.inf)

    def tired(self, loaded: Loaded, rows: Ints | slice) -> Floats | None:
        """Utilisation (n,) of some rows against fatigue; None without a crank cycle or strengths."""
        loading = self.loading(loaded.study)
        if not isinstance(loading, EngineLoading) or loaded.rpm is None:
            return None
        cycle = loading.crank_cycle(self.mass, loaded.rpm)
        weights = self._unit_loads.weights(cycle.at(np.arange(0, 4 * np.pi, _EVERY)), cycle)
        used, first = [], 0
        every = np.arange(sum(len(part.points) for part in self.parts))[rows]
        for part, material in zip(self.parts, loaded.materials, strict=True):
            here = every[(every >= first) & (every < first + len(part.points))] - first
            first += len(part.points)
            if not here.size:
                continue
            signed = signed_equivalent(part.stress(weights, here))
            extremes = signed.max(axis=1), signed.min(axis=1)
            used.append(1 / part.made_of(material).fatigue_factor(*extremes, here))
        found = np.concatenate(used)
        return found if found.any() else None


class Followed:
    """The nodes of a mesh that are followed, and the rows of stresses on both sides of y = 0 of each part."""

    def __init__(self, rod: PreparedRod, result: SpeedResult, surface: NumberedSurface) -> None:
        whole, cases = rod.mesh.mirrored, tuple(result.cases.values())
        used = np.max([1 / case.of_rod for case in cases], axis=0)
        inside = np.flatnonzero(used >= _INSIDE * used.max())
        self.nodes = np.unique(whole.source[np.concatenate([surface.nodes, inside])])
        self.surface, self.symmetry, self._rod = surface, rod.mesh.symmetry, rod
        sides = (1, -1) if rod.mesh.cut_y else (1,)
        self.parts = [np.intersect1d(own, self.nodes) for own in rod.fields.recovery.nodes]
        node = np.concatenate([np.tile(own, len(sides)) for own in self.parts])
        side = np.concatenate([np.repeat(sides, len(own)) for own in self.parts])
        self.part = np.repeat(np.arange(len(self.parts)), [len(sides) * len(own) for own in self.parts])
        # The node of the whole rod of each row: one on its side of y = 0, at z >= 0.
        images = np.full((2, len(rod.mesh.cell.points)), -1)
        order = np.argsort(whole.sign[:, 2], kind="stable")
        images[(whole.sign[order, 1] < 0).astype(int), whole.source[order]] = order
        images[1] = np.where(images[1] < 0, images[0], images[1])
        self.whole = images[(side < 0).astype(int), node]
        self.flip = np.array([1, 1, 1, -1, -1, 1])[None] ** (side < 0).astype(int)[:, None]
        self.counts = np.asarray(cases[0].counts[self.whole])
        # The row of each node of the surface, and its row of `nodes` with the signs of its coordinates.
        row = np.full((2, len(rod.mesh.cell.points)), -1)
        row[(side < 0).astype(int), node] = np.arange(len(node))
        row[1] = np.where(row[1] < 0, row[0], row[1])
        at = surface.nodes
        self.shown = row[(whole.sign[at, 1] < 0).astype(int), whole.source[at]]
        self.places = np.searchsorted(self.nodes, whole.source[at]), whole.sign[at].astype(np.float32)
        self.row_places = np.searchsorted(self.nodes, node), whole.sign[self.whole]
        self.name = cache(partial(place_name, rod.mesh))
        # What the load cases tell of the utilisation against fatigue; else the stress.
        used, *_ = usage(rod, cases) or (np.max([case.von_mises for case in cases], axis=0),)
        tired = used[self.whole]
        self.tired = np.flatnonzero(tired >= _TIRED * tired[self.counts].max())

    def anchor(self, x: Floats, loaded: Loaded, rod: PreparedRod, result: SpeedResult) -> Anchor:
        """Keep what is followed of a rod that is solved."""
        cases, given, length = result.cases, rod.loading, rod.mesh.bores.rod_length
        errors = {
            name: (case.von_mises_error / np.maximum(case.von_mises, 1e-9))[self.whole].astype(np.float32)
            for name, case in cases.items()
        }
        deviators = {
            name: (FROM_TENSOR[:5] @ (case.stress[self.whole] * self.flip).T).astype(np.float32)
            for name, case in cases.items()
        }
        found = Anchor(
            x=x,
            loading=lambda study: EngineLoading.of(study.engine, length) if study.engine else given,
            mass=rod.mass,
            points=rod.mesh.cell.points[self.nodes].astype(np.float32),
            parts=[],
            loads=None,
            solved=loaded.key,
            deviators=deviators if len(self.parts) == 1 else {},
            angles=_angles(joined([case.load for case in cases.values()])),
            errors=errors,
            column=rod.shank,
        )
        return self._spanned(found, rod) if isinstance(given, EngineLoading) else found

    def _spanned(self, anchor: Anchor, rod: PreparedRod) -> Anchor:
        """The anchor with unit stresses, in single precision."""
        analysis = rod.full_cycle
        units = analysis.units.of(self.nodes)
        single: Any = partial(np.asarray, dtype=np.float32)
        parts = [replace(own, even=single(own.even), odd=single(own.odd)) for own in units.parts]
        basis = copy(analysis.basis)
        basis.units = replace(units, parts=tuple(parts))
        slim = replace(analysis, basis=basis, masked=np.zeros_like(analysis.masked), direct=lambda *_: [])
        rows = [PartRows(slim, number) for number in range(len(self.parts))]
        return replace(anchor, parts=rows, loads=analysis.loads)


def _angles(cases: Instants) -> Angles:
    return {case.name: float(case.crank_angle) for case in cases}


def _apart(case: Instants, angles: Angles) -> bool:
    """Whether a load case is at another crank angle; that of the gas alone is at rest."""
    angle = float(case.crank_angle)
    return bool(case.in_cycle) and bool(abs(angle - angles.get(case.name, angle)) > _TURN)


class Anchors:
    """The anchors on one mesh, and what is interpolated from them."""

    def __init__(self, followed: Followed, elastic: tuple[object, ...]) -> None:
        self.followed, self.elastic = followed, elastic
        self.every: list[Anchor] = []
        self._stars: list[Star] = []
        self._known: dict[object, list[_Stack]] = {}

    def add(self, anchor: Anchor) -> None:
        """Add an anchor, or replace that of the same design; of many, those near it are kept."""
        others = [one for one in self.every if np.abs(one.x - anchor.x).max(initial=0.0) > SAME]
        others.sort(key=lambda one: float(np.abs(one.x - anchor.x).max()))
        self.every = [anchor, *others][:_MOST]
        self._stars = list(stars(np.array([one.x for one in self.every])))
        self._known.clear()

    def star(self, x: Floats) -> Star | None:
        """Return the star for scaled dimensions; None beyond the anchors."""
        covering = (one for one in self._stars if one.covers(x))
        return min(covering, key=lambda one: (one.away(x), one.changed(x).size), default=None)

    def at(self, x: Floats, loaded: Loaded) -> "Between | None":
        """Interpolate at scaled dimensions; None beyond the anchors, or with another elasticity."""
        if loaded.elastic != self.elastic or not self.every:
            return None
        star = self.star(x)
        if star is None:
            return None
        mix, which = star.at(x), self.every
        if not mix.lines:
            mix, which = mix._replace(weights=np.ones(1)), [self.every[star.center]]
        key = (loaded.key, loaded.materials, len(which), id(which[0]))
        if key not in self._known:
            recent = list(self._known.items())[-_RECENT:]
            self._known = dict(recent) | {key: [_Stack(which, loaded, self.followed)]}
        stacks = self._known[key]
        stack = stacks[0]
        if stack.ambiguous:
            cases = stack.cases(mix.weights)
            for stack in stacks:
                if not any(_apart(case, stack.angles) for case in cases):
                    break
            else:
                stack = _Stack(which, loaded, self.followed, _angles(cases))
                stacks.append(stack)
        return Between(stack, self.followed, mix)


class _Stack:
    """The fields of some anchors under one load, (n_anchors, …, n_rows) each."""

    def __init__(
        self, anchors: list[Anchor], loaded: Loaded, followed: Followed, angles: Angles | None = None
    ) -> None:
        self.anchors, self.loaded, self._followed = anchors, loaded, followed
        own = [one.cases(loaded) for one in anchors]
        self.angles = _angles(own[0]) if angles is None else angles
        #: Whether the peak of a load case is at another crank angle in some designs than in others
        self.ambiguous = any(_apart(case, self.angles) for cases in own for case in cases)
        cases = [one.cases(loaded, self.angles) for one in anchors] if self.ambiguous else own
        self.names = [case.name for case in cases[0] if all(case.name in other.names for other in cases)]
        some = [each[np.isin(each.names, self.names)] for each in cases]
        self.stress = np.stack([one.stress(loaded, each) for one, each in zip(anchors, some, strict=True)])
        errors = [one.errors for one in anchors]  # of a load case that was not solved, those of another
        relative = [[own.get(name, next(iter(own.values()))) for name in self.names] for own in errors]
        self.error = np.array(relative) * np.linalg.norm(self.stress, axis=1)
        strength = np.array([one.yield_strength for one in loaded.materials], np.float32)[followed.part]
        self.share = np.where(followed.counts, 1 / strength, 0)  # of what counts: utilisation over stress
        self.points = np.stack([one.points for one in anchors])
        self.buckles = np.stack([one.buckles(loaded, each) for one, each in zip(anchors, own, strict=True)])
        self.mass = np.array([one.mass.mass for one in anchors])
        direct = all(one.deviators and loaded.key == one.solved for one in anchors)
        self.superposed = 0.0 if direct else SUPERPOSED

    def cases(self, weights: Floats) -> Instants:
        """Load cases of a rod whose mass properties are those of the anchors, weighted."""
        near = self.anchors[int(np.abs(weights).argmax())]
        masses = [one.mass for one in self.anchors]
        center = weights @ np.array([mass.center for mass in masses])
        inertia = np.tensordot(weights, np.array([mass.inertia for mass in masses]), 1)
        mass = MassProperties(float(weights @ self.mass), vector(center), tensor(inertia))
        return replace(near, mass=mass).cases(self.loaded)

    @cached_property
    def tired(self) -> Floats | None:
        """Utilisation against fatigue (n_anchors, n) of the rows where it is large."""
        found = [one.tired(self.loaded, self._followed.tired) for one in self.anchors]
        known = [own for own in found if own is not None]
        return np.stack(known) if len(known) == len(found) else None


class Between:
    """What is interpolated at one design."""

    def __init__(self, stack: _Stack, followed: Followed, mix: Mix) -> None:
        self._stack, self._followed, self._mix, self._weights = stack, followed, mix, mix.weights
        single = self._weights.astype(np.float32)
        self._stress = np.tensordot(single, stack.stress, 1)
        self.von_mises = np.sqrt((self._stress**2).sum(axis=0))
        self.used = self.von_mises * stack.share
        error = np.maximum(0.0, np.tensordot(single, stack.error, 1))
        self.highest = (self.used + error * stack.share).max(axis=1)
        self._points = np.tensordot(single, stack.points, 1)

    @cached_property
    def worst_gap(self) -> float:
        """Estimated error of the largest utilisation over it."""
        case, row = np.unravel_index(int(self.used.argmax()), self.used.shape)
        return self.gap(int(row), int(case))

    @property
    def solved(self) -> bool:
        """Whether this design is an anchor."""
        return not self._mix.lines

    def gap(self, row: int, case: int) -> float:
        """Estimated error of the stress at a row over it."""
        length = max(float(self.von_mises[case, row]), 1e-9)
        direction = np.asarray(self._stress[:, case, row] / length, np.float64)
        if self.solved:
            return self._stack.superposed
        stress = np.asarray(self._stack.stress[:, :, case, row] / length, np.float64)
        return self._mix.error(stress, direction) + _LEAST + self._stack.superposed

    @property
    def figures(self) -> Figures:
        """The figures with their bars."""
        cases = [self._case(number) for number in range(len(self._stack.names))]
        rows, top = self.used.argmax(axis=1), self.used.max(axis=1)
        worst = int(top.argmax())
        row, gap = int(rows[worst]), self.gap(int(rows[worst]), worst)
        bar = 100 * (float(self.highest.max()) / float(top[worst]) - 1 + gap)
        return Figures(
            mass_kg=float(self._weights @ self._stack.mass) / KG,
            cases=tuple(cases),
            governing=self._stack.names[worst],
            yielding=self._factor(1 / float(top[worst]), bar, 100 * gap, row),
            fatigue=self._fatigue(bar, 100 * gap),
            buckling=self._buckling(),
        )

    def _case(self, number: int) -> CaseFigures:
        row = int(self.used[number].argmax())
        used, gap = float(self.used[number, row]), self.gap(row, number)
        bar = 100 * (float(self.highest[number]) / used - 1 + gap)
        factor = self._factor(1 / used, bar, 100 * gap, row)
        peak = float(np.where(self._followed.counts, self.von_mises[number], 0.0).max())
        return CaseFigures(**vars(factor), name=self._stack.names[number], peak_MPa=peak)

    def _factor(self, factor: float, bar: float, gap: float, row: int) -> Factor:
        place, sign = self._followed.row_places
        at = vector(self._points[place[row]] * sign[row])
        known = SafetyFactor.of_stress(factor, bar)
        return Factor.of(known, self._followed.name(int(self._followed.whole[row])), at, gap)

    def _fatigue(self, bar: float, gap: float) -> Factor | None:
        tired = self._stack.tired
        if tired is None:
            return None
        used = self._weights @ tired
        used = np.where(self._followed.counts[self._followed.tired], used, 0.0)
        worst = int(used.argmax())
        return self._factor(1 / float(used[worst]), bar, gap, int(self._followed.tired[worst]))

    def _buckling(self) -> Factor | None:
        factors = self._weights @ self._stack.buckles
        worst = int(factors.argmin())
        if not np.isfinite(factors[worst]):
            return None
        plane = list(Plane)[worst].value.replace("_", " ")
        return Factor.of(SafetyFactor(float(factors[worst])), f"the shank, {plane}")

    def drawn(self, shown: str) -> tuple[Singles, Singles]:
        """Places (n, 3) and stresses (n,) of the surface: of a load case, or the largest of all."""
        names, place = self._stack.names, self._followed.places
        of_case = shown != LARGEST_OF_CASES and shown in names
        values = self.von_mises[names.index(shown)] if of_case else self.von_mises.max(axis=0)
        return self._points[place[0]] * place[1], values[self._followed.shown]
