"""The surface of a rod over the whole crank cycle: what a report superposes in the browser.

A cycle is a sum of few fields, each times a course over the crank angle. The stress of every instant is U w
with the unit stresses U and the weights w. Its proper orthogonal decomposition (method of snapshots, Sirovich
1987, Q. Appl. Math. 45, 561) needs no history of any node: with UᵀU = LᵀL the singular vectors of L w are the
courses, and each field is U times a fixed combination of weights. Such a combination is itself a load, so
that every field has a displacement too.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from fea.analysis.cycle.screened import product
from fea.analysis.cycle.unit_solutions import PartStress
from fea.analysis.prepared_rod import PreparedRod
from fea.judge.history import deviator_norm, deviatoric
from fea.pins.model import UnitLoadFields, Weights
from fea.solid.parity import Parity, ParityPair
from fea.solid.stress import von_mises
from fea.solvers.static import StaticSolution
from geometry.arrays import Floats, Ints, Reals
from mesh.tetmesh import tensor_signs

# Numbers of fields that are tried; the last is beyond what any cycle needs.
_COUNTS = (4, 6, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96, 128, 160, 192, 256, 384, 512)
# The error is looked at every so many instants, first at every so many nodes; so many nodes at a time.
_INSTANTS, _SOME, _NODES = 3, 5, 4000


@dataclass(frozen=True)
class SurfaceModes:
    """Fields whose sum, each times its course, is the stress at every instant."""

    stress: Floats  #: (n_nodes, 6, n_modes), MPa, components XX YY ZZ XY YZ XZ
    courses: Floats  #: (n_modes, n_instants), at most 1 in size
    loads: Floats  #: (n_units, n_modes) weights of the unit loads that cause each field
    error: float  #: largest von Mises stress of what is missing at any node and instant looked at, MPa


def modes(units: Reals, weights: Floats, tolerance: float) -> SurfaceModes:
    """Find as few fields as give the stress of a cycle to a tolerance.

    `units` (n_nodes, 6, n_units) unit stresses; `weights` (n_units, n_instants).
    """
    flat = np.asarray(units, np.float32).reshape(-1, units.shape[2])
    values, vectors = np.linalg.eigh((flat.T @ flat).astype(float))
    root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    _, sizes, courses = np.linalg.svd(root @ weights, full_matrices=False)
    kept = sizes > np.finfo(np.float32).eps * max(float(sizes[0]), np.finfo(float).tiny)
    sizes, courses = sizes[kept], courses[kept]
    loads, courses = weights @ (courses.T / sizes), sizes[:, None] * courses
    count, error = _enough(units, weights, loads, courses, tolerance)
    size = np.abs(courses[:count]).max(axis=1)
    scaled = loads[:, :count] * size
    stress = np.asarray(product(flat.reshape(units.shape), scaled), np.float64)
    return SurfaceModes(stress, courses[:count] / size[:, None], scaled, error)


def _enough(
    units: Reals, weights: Floats, loads: Floats, courses: Floats, tolerance: float
) -> tuple[int, float]:
    """The smallest number of fields within the tolerance, by bisection over some nodes, and its error."""
    counts = [*(count for count in _COUNTS if count < len(courses)), len(courses)]

    def error(number: int, nodes: Reals) -> float:
        count, worst = counts[number], 0.0
        left = (weights - loads[:, :count] @ courses[:count])[:, ::_INSTANTS]
        for start in range(0, len(nodes), _NODES):
            block = deviatoric(np.asarray(nodes[start : start + _NODES], np.float32))
            worst = max(worst, float(deviator_norm(product(block, left)).max()))
        return worst

    some, low, high = units[::_SOME], 0, len(counts) - 1
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if error(middle, some) <= tolerance else (middle + 1, high)
    for number in range(low, len(counts) - 1):
        left = error(number, units)
        if left <= tolerance:
            return counts[number], left
    return counts[-1], 0.0


# Largest error of the stress, relative to the peak of the cycle: a quarter of what a report may err by.
TOLERANCE = 5e-4
# Modes whose displacement is solved for. Displacement is smoother than stress: what further modes add to it
# is far less than a line's width.
_MOVING = 24
# Unit loads whose forces are held at once.
_FORCES = 32
# Largest differences from directly solved load cases: of the stress, relative to the peak, that of a
# superposition of pressures that jump; and of the displacement, relative to the largest of the case.
_ALIKE, _ALIKE_MOVED = 0.05, 0.02
# Instants from one to the next at which parts that meet at a node are compared.
_EVERY = 15


@dataclass(frozen=True)
class ParityMotion:
    """Stress and displacement of one parity about y = 0."""

    stress: Floats  #: (n_rows, 6, n_modes), MPa
    #: (n_rows, 3, n_moving), mm, relative to the bores; of the first modes. None are left where displacement
    #: is more than what the unit loads cause, as in parts that slide on each other.
    displacement: Floats
    courses: Floats  #: (n_modes, n_instants)


@dataclass(frozen=True)
class Motion:
    """Stress and displacement of the surface at every instant of a cycle.

    At instant t the stress of row r is E = Σ stress[r] · courses[:, t], and that of a surface node is E of
    its row plus, where there is an odd part, the sign of its y times that part; its `sign` turns components.
    """

    nodes: Ints  #: (n,) surface nodes of the whole rod
    #: row, sign: (n,) the row of each, (n, 3) as `mesh.tetmesh.MirroredMesh.sign`
    row: Ints
    sign: Floats
    #: even, odd: the parts about y = 0; the second is None where the rod is not cut there
    even: ParityMotion
    odd: ParityMotion | None
    angles: Floats  #: (n_instants,) crank angles, rad
    error: float  #: largest von Mises stress of what the modes leave out, relative to the peak
    peak: float  #: the largest von Mises stress of the cycle that counts, MPa
    strength: Floats  #: (n_rows,) yield strength of the part whose stress a row shows, MPa

    @property
    def moves(self) -> bool:
        """Whether displacement is known."""
        return bool(self.even.displacement.shape[2])

    def still(self) -> "Motion":
        """Return the motion without displacement."""
        even, odd = (
            None if motion is None else replace(motion, displacement=motion.displacement[..., :0])
            for motion in (self.even, self.odd)
        )
        return replace(self, even=even or self.even, odd=odd)

    def stress(self, angle: float) -> Floats:
        """Stress (n, 6) of the surface nodes at a crank angle, rad, linear between instants; MPa."""
        return np.asarray(tensor_signs(self.sign) * self._combined("stress", angle))

    def displacement(self, angle: float) -> Floats:
        """Displacement (n, 3) of the surface nodes at a crank angle, rad, linear between instants; mm."""
        return np.asarray(self.sign * self._combined("displacement", angle))

    def _combined(self, name: str, angle: float) -> Floats:
        even = self._of(self.even, name, angle)[self.row]
        if self.odd is None:
            return even
        return np.asarray(even + self.sign[:, 1:2] * self._of(self.odd, name, angle)[self.row])

    def _of(self, parity: ParityMotion, name: str, angle: float) -> Floats:
        modes: Floats = getattr(parity, name)
        course = [np.interp(angle, self.angles, values) for values in parity.courses[: modes.shape[2]]]
        return np.asarray(modes @ np.array(course))


def motion(rod: PreparedRod, rpm: float, peak: float) -> Motion:
    """Work out the modes of a rod's surface at a speed.

    `peak`: largest von Mises stress of the cycle, MPa, to which tolerances are relative. Raises
    `InvalidValue`: there is no engine.
    """
    analysis, whole, cycle = rod.cycle, rod.mesh.mirrored, rod.crank_cycle(rpm)
    angles = cycle.engine.cycle_angles
    weights = analysis.weights(cycle, angles)
    nodes = np.unique(np.concatenate([facets.ravel() for facets in whole.mesh.facets.values()]))
    cell, row = np.unique(whole.source[nodes], return_inverse=True)
    part = _parts(analysis.units.parts, rod, cell, weights)
    even, odd = (_gathered(analysis.units.parts, part, cell, parity) for parity in Parity)
    tolerance = TOLERANCE / 2 * peak
    if len(analysis.units.sides) > 1:
        by_parity = [modes(even, weights.even, tolerance), modes(odd, weights.odd, tolerance)]
    else:
        by_parity = [modes(np.concatenate([even, odd], axis=2), np.concatenate(weights), 2 * tolerance)]
    moved = _displacements(rod, by_parity, cell)
    parities = [ParityMotion(mode.stress, u, mode.courses) for mode, u in zip(by_parity, moved, strict=True)]
    return Motion(
        nodes=nodes,
        row=row.astype(np.int64),
        sign=whole.sign[nodes],
        even=parities[0],
        odd=parities[1] if len(parities) > 1 else None,
        angles=angles,
        error=sum(mode.error for mode in by_parity) / peak,
        peak=peak,
        strength=np.array([material.yield_strength for material in rod.materials])[part],
    )


def _parts(parts: Sequence[PartStress], rod: PreparedRod, cell: Ints, weights: Weights) -> Ints:
    """The part (n_rows,) whose stress a node shows: where parts meet, the one that is closer to yielding."""
    chosen, usage = np.zeros(len(cell), np.int64), np.full(len(cell), -np.inf)
    shared = np.sum([np.isin(cell, stress.nodes) for stress in parts], axis=0) > 1
    some = weights.at(slice(None, None, _EVERY))
    for number, (stress, material) in enumerate(zip(parts, rod.materials, strict=True)):
        mine = np.isin(cell, stress.nodes)
        worst = np.where(mine, 0.0, -np.inf)
        both = np.flatnonzero(mine & shared)
        if both.size:
            at = np.searchsorted(stress.nodes, cell[both])
            even, odd = stress.even[at] @ some.even, stress.odd[at] @ some.odd
            sides = [even + odd, even - odd]
            largest = [von_mises(np.moveaxis(side, 1, -1)).max(axis=1) for side in sides]
            worst[both] = np.max(largest, axis=0) / material.yield_strength
        better = worst > usage
        chosen[better], usage[better] = number, worst[better]
    return chosen


def _gathered(parts: Sequence[PartStress], part: Ints, cell: Ints, parity: Parity) -> Floats:
    """Unit stresses (n_rows, 6, n_units) of one parity, each row of its part."""
    first = parts[0].even if parity is Parity.SYMMETRIC else parts[0].odd
    stresses = np.empty((len(cell), 6, first.shape[2]), first.dtype)
    for number, stress in enumerate(parts):
        rows = np.flatnonzero(part == number)
        units = stress.even if parity is Parity.SYMMETRIC else stress.odd
        stresses[rows] = units[np.searchsorted(stress.nodes, cell[rows])]
    return stresses


def _displacements(rod: PreparedRod, by_parity: Sequence[SurfaceModes], cell: Ints) -> list[Floats]:
    """Displacement (n_rows, 3, n_moving) of the first modes of each parity."""
    even, odd = rod.cycle.basis.fields()
    if len(by_parity) == 1:
        joined = by_parity[0].loads[:, :_MOVING]
        forces = _forces(even, joined[: even.count]) + _forces(odd, joined[even.count :])
        loads = [ParityPair(force, None) for force in forces]
    else:
        sides = [_forces(of, one.loads[:, :_MOVING]) for of, one in zip((even, odd), by_parity, strict=True)]
        count = max(len(side) for side in sides)
        sides = [np.concatenate([side, np.zeros((count - len(side), *side.shape[1:]))]) for side in sides]
        loads = [ParityPair(*pair) for pair in zip(*sides, strict=True)]
    solution = rod.model.solve(loads)
    first = _of_cell(rod, cell)
    return [
        _one(rod, solution, parity)[first][..., : min(_MOVING, each.loads.shape[1])]
        for parity, each in zip(Parity, by_parity, strict=False)
    ]


def _forces(fields: UnitLoadFields, weights: Floats) -> Floats:
    """Nodal forces (n, n_nodes, 3) of combinations (n_units, n) of unit loads."""
    total: Floats | float = 0.0
    for start in range(0, fields.count, _FORCES):
        units = slice(start, min(start + _FORCES, fields.count))
        total = total + np.tensordot(weights[units].T, np.stack(list(fields.forces(units))), axes=1)
    return np.asarray(total)


def _one(rod: PreparedRod, solution: StaticSolution, parity: Parity) -> Floats:
    """Displacement (n_nodes, 3, n) of the whole rod by the loads of one parity alone, mm."""
    u = solution.displacement.get(parity)
    still = np.zeros_like(solution.displacement[Parity.SYMMETRIC])
    if parity is Parity.SYMMETRIC:
        alone = {Parity.SYMMETRIC: still if u is None else u}
    else:
        alone = {Parity.SYMMETRIC: still, parity: still if u is None else u}
    return rod.fields.displacement(StaticSolution(alone, {}))


def _of_cell(rod: PreparedRod, cell: Ints) -> Ints:
    """Nodes of the whole rod that are the cell's own, for nodes of the cell."""
    whole = rod.mesh.mirrored
    original = np.empty(int(whole.source.max()) + 1, np.int64)
    # A node of the cell comes before its images.
    original[whole.source[::-1]] = np.arange(len(whole.source))[::-1]
    return original[cell]


class SolvedInstant(NamedTuple):
    """A directly solved instant: crank angle, rad, von Mises stress (n_nodes,), displacement (n_nodes, 3)."""

    angle: float
    von_mises: Floats
    displacement: Floats


def agreeing(moving: Motion, cases: Iterable[SolvedInstant]) -> tuple[Motion | None, str]:
    """Compare a motion with directly solved instants.

    Returns the motion as it is, or without displacement where that differs; or None, and why, where the
    stress does.
    """
    stress, moved = 0.0, 0.0
    for case in cases:
        apart = von_mises(moving.stress(case.angle)) - case.von_mises[moving.nodes]
        stress = max(stress, float(np.abs(apart).max()) / moving.peak)
        away = moving.displacement(case.angle) - case.displacement[moving.nodes]
        largest = float(np.abs(case.displacement).max())
        moved = max(moved, float(np.abs(away).max()) / largest if largest else 0.0)
    if stress > _ALIKE:
        return None, f"its stress differs from the load cases by {100 * stress:.2g} % of the peak"
    return (moving if moved <= _ALIKE_MOVED else moving.still()), ""
