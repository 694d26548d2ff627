"""The search: steps on moved meshes cover the way, a model of all designs tried finds the end.

On one mesh that is moved, figures change smoothly with the dimensions, but all of them are off by the scatter
of meshes. The last designs each have a mesh of their own, so that the chosen one meets the factors there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, NonlinearConstraint, linprog, minimize

from fea.apps.optimise.designs import Design, Designs
from geometry.arrays import Floats

# Scaled distance at which a design counts 1/e of one at the centre, and beyond which it does not count.
_NEAR, _FAR = 0.12, 0.4
# Error of the model of one mesh, over the scatter of meshes, and over the change of margins from one bound of
# a dimension to the other: no design may determine a slope, which is nothing then.
_OF_MESHES, _OF_SLOPES = 0.3, 0.01


@dataclass(frozen=True)
class LocalModel:
    """Mass and margins near a design `centre` (n,), linear in the scaled dimensions, on the mean of meshes.

    `values` (1 + k,) and `slopes` (1 + k, n) are of the mass, relative to that of the centre, and of each
    margin.
    """

    centre: Floats
    values: Floats
    slopes: Floats

    @classmethod
    def of(cls, tried: Sequence[Design], centre: Design) -> "LocalModel":
        """Fit the model about a design to those near it, which have the same constraints."""
        names = [constraint.name for constraint in centre.constraints]
        near, values = list[Design](), []
        for design in tried:
            margins = _margins(design)
            if np.linalg.norm(design.x - centre.x) <= _FAR and margins.keys() >= set(names):
                near.append(design)
                values.append([design.mass_kg / centre.mass_kg, *(margins[name] for name in names)])
        away = np.array([design.x - centre.x for design in near])
        meshes = np.unique([design.mesh for design in near])
        of_mesh = np.array([[design.mesh == mesh for mesh in meshes] for design in near], dtype=float)
        weight = np.exp(-0.5 * (np.linalg.norm(away, axis=1) / _NEAR) ** 2)[:, None]
        n, m = away.shape[1], len(meshes)
        matrix = np.hstack([np.ones((len(near), 1)), away, of_mesh])
        penalty = np.diag([0.0, *[_OF_SLOPES] * n, *[_OF_MESHES] * m])[1:]
        solution = np.linalg.lstsq(
            np.vstack([weight * matrix, penalty]),
            np.vstack([weight * np.array(values), np.zeros((n + m, 1 + len(names)))]),
            rcond=None,
        )[0]
        return cls(centre.x, solution[0], solution[1 : n + 1].T)

    def at(self, x: Floats) -> tuple[float, Floats]:
        """Return mass and margins (k,) of a design (n,)."""
        mass, *margins = self.values + self.slopes @ (x - self.centre)
        return float(mass), np.array(margins)


def _margins(design: Design) -> dict[str, float]:
    return {constraint.name: constraint.margin for constraint in design.constraints}


# Of the first round and the second, scaled by the bounds: steps by which slopes are determined, and the first
# and the last radius of the trust region.
_BESIDE = (0.06, 0.03)
_FIRST = (0.25, 0.08)
_LAST = (0.02, 0.005)
# Share of all evaluations until each round is over; and steps that a round takes at least.
_SHARE = (0.55, 0.8)
_STEPS = 4
# Share of the radius that is kept after a step without progress.
_SHORTER = 0.5
# Meshes that the first rod, the steps of a round and two rods on meshes of their own take at least, beside
# one for each dimension.
_LEAST = 12
# The least share of the stress that a model of its logarithm sees, where a constraint does not matter.
_LITTLE = 1e-3
# Saving less mass than this share is no progress: new meshes differ by about as much.
_SETTLED = 1e-3
# Designs on meshes of their own without progress after which the search ends.
_PATIENT = 4
# Largest distance of such a design from the one before, and share of it kept where the next is no better.
_NEXT, _NEARER = 0.1, 0.7
# Share of a violated margin that the next design keeps in reserve; and share of it kept when one holds.
_RAISED, _LOWERED = 0.5, 0.5
# Evaluations of the model for its lightest design, over the number of dimensions.
_OF_MODEL = 25
# Mass by which a violated margin counts, relative to it.
_VIOLATED = 2.0
# Scaled distance below which designs are the same.
_SAME = 1e-4
# Evaluations of a study that does not limit them.
USUAL = 150


def fewest(dimensions: int) -> int:
    """Return the number of meshes below which a search can decide nothing."""
    return dimensions + _LEAST


@dataclass(frozen=True)
class SearchResult:
    """All designs that were tried, the number of meshes solved, and why the search ended."""

    tried: tuple[Design, ...]
    count: int
    ended: str

    @property
    def first(self) -> Design:
        """The rod that it began with."""
        return self.tried[0]

    @property
    def best(self) -> Design:
        """The lightest rod that meets the required factors on its own mesh, or the one that lacks least."""
        remeshed = (design for design in self.tried if design.remeshed)
        return self.holding[0] if self.holding else min(remeshed, key=lambda design: design.violation)

    @property
    def holding(self) -> list[Design]:
        """The rods that hold on a mesh of their own, the lightest first."""
        rods = [design for design in self.tried if design.remeshed and design.margin >= 0]
        return sorted(rods, key=lambda design: design.mass_kg)


def search(designs: Designs, start: Floats, most: int) -> SearchResult:
    """Search the lightest design that meets all constraints, from (n,) scaled dimensions.

    At most `most` meshes are solved.

    Two rounds minimise the mass on moved copies of one mesh each. Further designs follow from a model of all
    that were tried near them; each has a mesh of its own. Raises `GeometryError`, `MeshError`: a design
    cannot be drawn or meshed.
    """
    remeshed = [designs.begin(start)]
    mesh_cost = designs.count + 1  # a mesh of its own may be refined once more than the first
    slopes: Floats | None = None
    for number, share in enumerate(_SHARE):
        needed = len(start) if slopes is None else 0
        until = max(round(share * most), designs.count + needed + _STEPS)
        left = min(until, most - 2 * mesh_cost) - designs.count
        if left <= needed:
            break
        x, slopes = _round(designs, remeshed[-1], left, number, slopes)
        if np.array_equal(x, remeshed[-1].x):
            break
        before = designs.count
        remeshed.append(designs.begin(x))
        mesh_cost = max(mesh_cost, designs.count - before + 1)
    if slopes is None:
        ended = f"{most} evaluations are too few for a step"
    else:
        ended = _finished(designs, remeshed, most, mesh_cost)
    return SearchResult(tuple(designs.tried), designs.count, ended)


def _finished(designs: Designs, remeshed: list[Design], most: int, mesh_cost: int) -> str:
    """Try designs on meshes of their own until none is lighter; add them to `remeshed` and say why it ended.

    Of at most `most` meshes, one of these designs may take `mesh_cost`.
    """
    reserve, radius, waited = 0.0, _NEXT, 0
    while True:
        best, holds = min(remeshed, key=_merit), any(design.margin >= 0 for design in remeshed)
        if waited >= _PATIENT and holds:
            return f"further designs saved less than {100 * _SETTLED:g} % of the mass"
        if designs.count + mesh_cost > most:
            return f"too few of the {most} evaluations are left for another design"
        x = _lightest(designs, best, reserve, radius)
        if any(np.abs(x - other.x).max() < _SAME for other in remeshed):
            if best.margin >= 0 or waited >= _PATIENT:
                return f"none {'lighter' if holds else 'that meets the factors'} was found near the best one"
            reserve, waited = reserve + _RAISED * max(-best.margin, _SETTLED), waited + 1
            continue
        design = designs.begin(x)
        remeshed.append(design)
        saved = 1 - design.mass_kg / best.mass_kg
        progress = design.margin >= 0 and (saved > _SETTLED or best.margin < 0)
        reserve = reserve * _LOWERED if design.margin >= 0 else reserve - _RAISED * design.margin
        waited, radius = (0, radius) if progress else (waited + 1, radius * _NEARER)


def _lightest(designs: Designs, centre: Design, reserve: float, radius: float) -> Floats:
    """The lightest design near another whose margins keep a reserve, by a model of those tried."""
    model = LocalModel.of(designs.tried, centre)

    def figures(x: Floats) -> tuple[float, Floats]:
        mass, margins = model.at(x)
        return mass, margins - reserve

    return _minimised(designs, figures, centre.x, radius)


def _merit(design: Design) -> float:
    return design.mass_kg * (1 + _VIOLATED * design.violation)


def _round(
    designs: Designs, base: Design, most: int, number: int, slopes: Floats | None
) -> tuple[Floats, Floats]:
    """The best design (n,) in steps of a trust region, with at most `most` designs, and slopes (1 + k, n).

    The model is linear in the logarithms of the stresses, which bends as stress does. Its slopes come from a
    design beside the base for each dimension, or are those `slopes` of the last round where there is no room
    for that; every further design corrects them (Broyden 1965).
    """
    names, last = list(_margins(base)), designs.count + most

    def figures_of(design: Design) -> Floats:
        margins = _margins(design)
        used = [np.log(max(1 - margins.get(name, 1.0), _LITTLE)) for name in names]
        return np.array([design.mass_kg / base.mass_kg, *used])

    def corrected(slopes: Floats, centre: Design, design: Design) -> Floats:
        step = design.x - centre.x
        missed = figures_of(design) - figures_of(centre) - slopes @ step
        return slopes + np.outer(missed, step) / max(float(step @ step), _SAME**2)

    if slopes is None or most >= len(base.x) + _STEPS:
        slopes = np.zeros((1 + len(names), len(base.x)))
        for axis in np.eye(len(base.x)):
            side = 1 if axis @ base.x + _BESIDE[number] <= 1 else -1
            slopes = corrected(slopes, base, designs.at(base.x + side * _BESIDE[number] * axis))
    best, radius = base, _FIRST[number]
    while designs.count < last and radius >= _LAST[number]:
        x = _stepped(designs, best, figures_of(best), slopes, radius)
        if np.abs(x - best.x).max() < _SAME:
            break
        design = designs.at(x)
        slopes = corrected(slopes, best, design)
        settled = _merit(design) > _merit(best) * (1 - _SETTLED)
        best = min(best, design, key=_merit)
        radius *= _SHORTER if settled else 1.0
    return best.x, slopes


def _stepped(designs: Designs, centre: Design, figures: Floats, slopes: Floats, radius: float) -> Floats:
    """The lightest design (n,) near another: a linear programme, unless a rule forbids its solution."""
    low, high = _around(centre.x, radius)
    count = len(figures) - 1
    programme = linprog(
        [*slopes[0], *[_VIOLATED * figures[0]] * count],  # a step, and the violation of each constraint there
        A_ub=np.hstack([slopes[1:], -np.eye(count)]),
        b_ub=-figures[1:],
        bounds=[*zip(low - centre.x, high - centre.x, strict=True), *[(0.0, None)] * count],
    )
    if programme.success:
        x = np.clip(centre.x + programme.x[: len(low)], low, high)
        if np.abs(designs.nearest(x, centre.x) - x).max() < _SAME:
            return np.asarray(x)

    def model(x: Floats) -> tuple[float, Floats]:
        mass, *used = figures + slopes @ (x - centre.x)
        return float(mass), 1 - np.exp(used)

    return _minimised(designs, model, centre.x, radius)


def _around(centre: Floats, radius: float) -> tuple[Floats, Floats]:
    return np.clip(centre - radius, 0.0, 1.0), np.clip(centre + radius, 0.0, 1.0)


def _minimised(
    designs: Designs, figures: Callable[[Floats], tuple[float, Floats]], centre: Floats, radius: float
) -> Floats:
    """Return the design (n,) near another with the least mass that no rule forbids.

    `figures` returns the mass of a design, and constraints, which must not be negative.
    """
    low, high = _around(centre, radius)
    cache = dict[bytes, tuple[float, Floats]]()

    def at(x: Floats) -> tuple[float, Floats]:
        if x.tobytes() not in cache:
            within = np.clip(x, low, high)
            mass, margins = figures(within)
            away = np.linalg.norm(within - designs.nearest(within, centre))
            cache[x.tobytes()] = mass, np.append(margins, -away)
        return cache[x.tobytes()]

    optimum = minimize(
        lambda x: at(x)[0],
        centre,
        method="COBYQA",
        bounds=Bounds(low, high),
        constraints=NonlinearConstraint(lambda x: at(x)[1], 0.0, np.inf),
        options={
            "initial_tr_radius": radius / 2,
            "final_tr_radius": _SAME / 10,
            "maxfev": _OF_MODEL * len(centre),
        },
    )
    return designs.nearest(np.clip(optimum.x, low, high), centre)
