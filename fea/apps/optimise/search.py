"""The search: steps on moved meshes cover the way, a model of all designs tried finds the end.

On one mesh that is moved, figures change smoothly with the dimensions, but all of them are off by what meshes
scatter by. The last designs each have a mesh of their own, so that the one chosen meets the factors there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, NonlinearConstraint, linprog, minimize

from fea.apps.optimise.designs import Design, Designs
from geometry.arrays import Floats

# Scaled distance at which a design counts 1/e of one at the centre, and beyond which it does not count.
_NEAR, _FAR = 0.12, 0.4
# What the model of one mesh errs by, over what meshes scatter by, and over what margins change by from one
# bound of a dimension to the other: no design may tell a slope, which is nothing then.
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
    def of(cls, tried: Sequence[Design], about: Design) -> "LocalModel":
        """Fit the model about a design to those near it, which have the same limits."""
        names = [limit.name for limit in about.limits]
        known = [{limit.name: limit.margin for limit in design.limits} for design in tried]
        near = [
            (design, margins)
            for design, margins in zip(tried, known, strict=True)
            if np.linalg.norm(design.x - about.x) <= _FAR and margins.keys() >= set(names)
        ]
        away = np.array([design.x - about.x for design, _ in near])
        values = np.array(
            [[design.mass_kg / about.mass_kg, *(margins[name] for name in names)] for design, margins in near]
        )
        meshes = np.unique([design.mesh for design, _ in near])
        of_mesh = np.array([[design.mesh == mesh for mesh in meshes] for design, _ in near], dtype=float)
        weight = np.exp(-0.5 * (np.linalg.norm(away, axis=1) / _NEAR) ** 2)[:, None]
        n, m = away.shape[1], len(meshes)
        matrix = np.hstack([np.ones((len(near), 1)), away, of_mesh])
        penalty = np.diag([0.0, *[_OF_SLOPES] * n, *[_OF_MESHES] * m])[1:]
        solution = np.linalg.lstsq(
            np.vstack([weight * matrix, penalty]),
            np.vstack([weight * values, np.zeros((n + m, values.shape[1]))]),
            rcond=None,
        )[0]
        return cls(about.x, solution[0], solution[1 : n + 1].T)

    def at(self, x: Floats) -> tuple[float, Floats]:
        """Return mass and margins (k,) of a design (n,)."""
        mass, *margins = self.values + self.slopes @ (x - self.centre)
        return float(mass), np.array(margins)


# Steps by which the slopes of a round are told, and the first and the last radius of its trust region, of the
# first round and the second: scaled by the bounds.
_BESIDE = (0.06, 0.03)
_FIRST = (0.25, 0.08)
_LAST = (0.02, 0.005)
# Of all evaluations, until the first and the second round are over; and steps that a round takes at least.
_SHARE = (0.55, 0.8)
_STEPS = 4
# Of the radius, what is kept after a step that was none forward.
_SHORTER = 0.5
# Meshes that the first rod, the steps of a round and two rods on meshes of their own take at least, beside
# one for each dimension.
_LEAST = 12
# The least share of the stress that a model of its logarithm sees, where a limit does not matter.
_LITTLE = 1e-3
# Saving less mass than this share is no progress: new meshes differ by about as much.
_SETTLED = 1e-3
# Designs on meshes of their own without progress after which the search ends.
_PATIENT = 4
# How far such a design may be from the one before, and what is kept of it where the next is no better.
_NEXT, _NEARER = 0.1, 0.7
# Of what a design lacks, the share that the next one keeps in reserve; and what is kept of it when one holds.
_RAISED, _LOWERED = 0.5, 0.5
# Values of the model, over the number of dimensions, that are looked at for its lightest design.
_OF_MODEL = 25
# A lacking margin counts as so much more mass.
_LACKING = 2.0
# Scaled distance below which designs are the same.
_SAME = 1e-4
# Evaluations of a study that says nothing.
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
        if self.holding:
            return self.holding[0]
        return min((one for one in self.tried if one.remeshed), key=lambda design: design.lacking)

    @property
    def holding(self) -> list[Design]:
        """The rods that hold on a mesh of their own, the lightest first."""
        rods = [design for design in self.tried if design.remeshed and design.margin >= 0]
        return sorted(rods, key=lambda design: design.mass_kg)

    @property
    def holds(self) -> bool:
        """Whether the best rod holds."""
        return self.best.margin >= 0


def search(designs: Designs, start: Floats, most: int) -> SearchResult:
    """Search the lightest design that meets all limits, from (n,) scaled dimensions.

    At most `most` meshes are solved.

    Two rounds minimise the mass on moved copies of one mesh each. Further designs follow from what all tried
    so far say of those near them; each has a mesh of its own. Raises `GeometryError`, `MeshError`: a design
    cannot be drawn or meshed.
    """
    remeshed = [designs.begin(start)]
    mesh_cost = designs.count + 1  # a mesh of its own may be refined once more than the first
    slopes: Floats | None = None
    for number, share in enumerate(_SHARE):
        until = max(round(share * most), designs.count + (len(start) if slopes is None else 0) + _STEPS)
        left = min(until, most - 2 * mesh_cost) - designs.count
        if left <= (len(start) if slopes is None else 0):
            break
        x, slopes = _round(designs, remeshed[-1], left, number, slopes)
        if np.array_equal(x, remeshed[-1].x):
            break
        before = designs.count
        remeshed.append(designs.begin(x))
        mesh_cost = max(mesh_cost, designs.count - before + 1)
    if slopes is None:
        return SearchResult(tuple(designs.tried), designs.count, f"{most} evaluations are too few for a step")
    ended = _finished(designs, remeshed, most, mesh_cost)
    return SearchResult(tuple(designs.tried), designs.count, ended)


def _finished(designs: Designs, remeshed: list[Design], most: int, mesh_cost: int) -> str:
    """Try designs on meshes of their own until none is lighter; add them to `remeshed` and say why it ended.

    Of at most `most` meshes, one of these designs may take `mesh_cost`.
    """
    reserve, radius, waited = 0.0, _NEXT, 0
    while True:
        about, holds = min(remeshed, key=_merit), any(design.margin >= 0 for design in remeshed)
        if waited >= _PATIENT and holds:
            return f"further designs saved less than {100 * _SETTLED:g} % of the mass"
        if designs.count + mesh_cost > most:
            return f"too few of the {most} evaluations are left for another design"
        x = _lightest(designs, about, reserve, radius)
        if any(np.abs(x - other.x).max() < _SAME for other in remeshed):
            if about.margin >= 0 or waited >= _PATIENT:
                return f"none {'lighter' if holds else 'that meets the factors'} was found near the best one"
            reserve, waited = reserve + _RAISED * max(-about.margin, _SETTLED), waited + 1
            continue
        design = designs.begin(x)
        remeshed.append(design)
        saved = 1 - design.mass_kg / about.mass_kg
        progress = design.margin >= 0 and (saved > _SETTLED or about.margin < 0)
        reserve = reserve * _LOWERED if design.margin >= 0 else reserve - _RAISED * design.margin
        waited, radius = (0, radius) if progress else (waited + 1, radius * _NEARER)


def _lightest(designs: Designs, about: Design, reserve: float, radius: float) -> Floats:
    """The lightest design near another whose margins keep a reserve, by a model of those tried."""
    model = LocalModel.of(designs.tried, about)

    def figures(x: Floats) -> tuple[float, Floats]:
        mass, margins = model.at(x)
        return mass, margins - reserve

    return _minimised(designs, figures, about.x, radius)


def _merit(design: Design) -> float:
    return design.mass_kg * (1 + _LACKING * design.lacking)


def _round(
    designs: Designs, base: Design, most: int, number: int, slopes: Floats | None
) -> tuple[Floats, Floats]:
    """The best design (n,) in steps of a trust region, with at most `most` designs, and slopes (1 + k, n).

    The model is linear in the logarithms of the stresses, which bends as stress does. Its slopes are told by
    a design beside the base for each dimension, or are those `slopes` of the last round where there is no
    room for that; every further design corrects them (Broyden 1965).
    """
    names, last = [limit.name for limit in base.limits], designs.count + most

    def figures_of(design: Design) -> Floats:
        margins = {limit.name: limit.margin for limit in design.limits}
        used = [np.log(max(1 - margins.get(name, 1.0), _LITTLE)) for name in names]
        return np.array([design.mass_kg / base.mass_kg, *used])

    def corrected(slopes: Floats, about: Design, design: Design) -> Floats:
        step = design.x - about.x
        missed = figures_of(design) - figures_of(about) - slopes @ step
        return slopes + np.outer(missed, step) / max(float(step @ step), _SAME**2)

    if slopes is None or most >= len(base.x) + _STEPS:
        slopes = np.zeros((1 + len(names), len(base.x)))
        for axis in np.eye(len(base.x)):
            side = 1 if axis @ base.x + _BESIDE[number] <= 1 else -1
            slopes = corrected(slopes, base, designs.at(base.x + side * _BESIDE[number] * axis))
    about, radius = base, _FIRST[number]
    while designs.count < last and radius >= _LAST[number]:
        x = _stepped(designs, about, figures_of(about), slopes, radius)
        if np.abs(x - about.x).max() < _SAME:
            break
        design = designs.at(x)
        slopes = corrected(slopes, about, design)
        settled = _merit(design) > _merit(about) * (1 - _SETTLED)
        about = min(about, design, key=_merit)
        radius *= _SHORTER if settled else 1.0
    return about.x, slopes


def _stepped(designs: Designs, about: Design, figures: Floats, slopes: Floats, radius: float) -> Floats:
    """The lightest design (n,) near another: a linear programme, unless a rule forbids its solution."""
    low, high = _around(about.x, radius)
    limits = len(figures) - 1
    programme = linprog(
        [*slopes[0], *[_LACKING * figures[0]] * limits],  # a step, and what each limit lacks there
        A_ub=np.hstack([slopes[1:], -np.eye(limits)]),
        b_ub=-figures[1:],
        bounds=[*zip(low - about.x, high - about.x, strict=True), *[(0.0, None)] * limits],
    )
    if programme.success:
        x = np.clip(about.x + programme.x[: len(low)], low, high)
        if np.abs(designs.nearest(x, about.x) - x).max() < _SAME:
            return np.asarray(x)

    def model(x: Floats) -> tuple[float, Floats]:
        mass, *used = figures + slopes @ (x - about.x)
        return float(mass), 1 - np.exp(used)

    return _minimised(designs, model, about.x, radius)


def _around(about: Floats, radius: float) -> tuple[Floats, Floats]:
    return np.clip(about - radius, 0.0, 1.0), np.clip(about + radius, 0.0, 1.0)


def _minimised(
    designs: Designs, figures: Callable[[Floats], tuple[float, Floats]], about: Floats, radius: float
) -> Floats:
    """Return the design (n,) near another with the least mass that no rule forbids.

    `figures` returns the mass of a design, and constraints, which shall not be negative.
    """
    low, high = _around(about, radius)
    known = dict[bytes, tuple[float, Floats]]()

    def at(x: Floats) -> tuple[float, Floats]:
        if x.tobytes() not in known:
            within = np.clip(x, low, high)
            mass, margins = figures(within)
            away = np.linalg.norm(within - designs.nearest(within, about))
            known[x.tobytes()] = mass, np.append(margins, -away)
        return known[x.tobytes()]

    optimum = minimize(
        lambda x: at(x)[0],
        about,
        method="COBYQA",
        bounds=Bounds(low, high),
        constraints=NonlinearConstraint(lambda x: at(x)[1], 0.0, np.inf),
        options={
            "initial_tr_radius": radius / 2,
            "final_tr_radius": _SAME / 10,
            "maxfev": _OF_MODEL * len(about),
        },
    )
    return designs.nearest(np.clip(optimum.x, low, high), about)
