"""Nodal stress of every unit load, its superposition, and its histories at single places."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise, product, starmap, zip_longest

import numpy as np

from fea.base.material import Material
from fea.judge.history import deviatoric, signed_equivalent, tensor
from fea.machine.threads import side_by_side
from fea.pins.model import NOT_JOINT, JointBounds, UnitLoadFields, Weights
from fea.solid.parity import Parity, ParityPair
from fea.solid.recovery import PartRecovery
from fea.solvers.static import Model, StaticSolution
from geometry.arrays import Floats, Ints
from mesh.tetmesh import MirroredMesh

# Bytes of the displacements that are solved for at once (starting a solver costs as much as ten columns),
# and the smallest number of columns of a block, for large meshes.
SOLVED_BYTES = 64 * 2**20
SOLVED = 20
# Unit stresses that would take more than this are kept in single precision: a millionth of the stress is far
# less than any error of the mesh.
DOUBLE_BYTES = 192 * 2**20
# Number of columns whose stress is recovered at once, so that they fit into the caches.
RECOVERED = 12


@dataclass(frozen=True)
class PartStress:
    """Unit stresses of one part."""

    nodes: Ints  #: (n,) its nodes in the cell
    #: even, odd: (n, 6, n_units), MPa, of the unit loads of each parity
    even: Floats
    odd: Floats
    joint: JointBounds = NOT_JOINT  #: unit loads whose deviations are bounded jointly

    def histories(self, weights: Weights, sides: tuple[int, ...], rows: slice | Ints) -> list[Floats]:
        """Histories (n, 6, n_instants) of some nodes, and of their images across y = 0 (side −1).

        In the components of `fea.judge.history`. An image has the components of its node: the signs of XY
        and YZ should be reversed, but they affect neither lengths nor products of the deviatoric vectors.
        """
        even, odd = (
            deviatoric(unit[rows][..., : len(weight)]) @ weight.astype(unit.dtype)
            for unit, weight in zip((self.even, self.odd), weights, strict=True)
        )
        return [even + odd if side > 0 else even - odd for side in sides]


@dataclass(frozen=True)
class UnitSolutions:
    """The unit solutions of a rod.

    They take 48 bytes per node of the cell and unit load, 3.5 kB per node for the 74 of a half cosine, or
    half of that where they are very large.
    """

    parts: tuple[PartStress, ...]  #: unit stresses, one entry per part
    sides: tuple[int, ...]  #: (1, −1) if the cell represents its image across y = 0 too, else (1,)
    count: int  #: number of unit loads solved
    backward_error: float  #: the largest backward error of the solutions

    @property
    def joint(self) -> JointBounds:
        """Unit loads whose deviations are bounded jointly."""
        return self.parts[0].joint

    def bounded(self, joint: JointBounds) -> "UnitSolutions":
        """Return the solutions with deviations of other unit loads bounded jointly."""
        return replace(self, parts=tuple(replace(part, joint=joint) for part in self.parts))

    def followed_by(self, more: "UnitSolutions") -> "UnitSolutions":
        """Return these solutions, then others of the same rod."""
        parts = (
            replace(stress, even=_after(stress.even, other.even), odd=_after(stress.odd, other.odd))
            for stress, other in zip(self.parts, more.parts, strict=True)
        )
        worst = max(self.backward_error, more.backward_error)
        return UnitSolutions(tuple(parts), self.sides, self.count + more.count, worst)

    def of(self, nodes: Ints) -> "UnitSolutions":
        """Return those of some nodes of the cell; of a part without any of them, those of one node."""
        rows = [np.flatnonzero(np.isin(stress.nodes, nodes)) for stress in self.parts]
        rows = [at if at.size else np.zeros(1, dtype=np.int64) for at in rows]
        parts = (
            replace(stress, nodes=stress.nodes[at], even=stress.even[at], odd=stress.odd[at])
            for stress, at in zip(self.parts, rows, strict=True)
        )
        return replace(self, parts=tuple(parts))

    def tensor(self, part: int, weights: Weights, whole: MirroredMesh) -> Floats:
        """Stress (n_nodes, 6, n_instants) of a part on the whole rod; NaN at nodes outside the part."""
        stress = self.parts[part]
        even, odd = np.full((2, int(whole.source.max()) + 1, 6, weights.even.shape[1]), np.nan)
        for field, unit, weight in zip((even, odd), (stress.even, stress.odd), weights, strict=True):
            field[stress.nodes] = unit[..., : len(weight)] @ weight.astype(unit.dtype)
        return whole.tensor(even, odd) if len(self.sides) > 1 else whole.tensor(even + odd)


def unit_solutions(
    model: Model,
    recovery: PartRecovery,
    materials: Sequence[Material],
    fields: tuple[UnitLoadFields, UnitLoadFields],
    *,
    cut_y: bool,
    single: bool = False,
) -> UnitSolutions:
    """Solve even and odd unit loads with the factors of `model` and recover their nodal stress.

    `single`: whether stress is kept in single precision, and not only where there is much of it. Raises
    `UnderconstrainedError` and `SingularMatrixError` as `Model.solve`.
    """
    even, odd = fields
    solved = partial(_solved, model, recovery, materials, single=single)
    if cut_y:  # an even and an odd load share a column, because each parity has its own factor
        stresses, errors = solved(fields=fields)
    else:
        alone = [solved(fields=(of_parity,)) for of_parity in fields]
        stresses, errors = [found[0][0] for found in alone], [error for found in alone for error in found[1]]
    parts = tuple(starmap(PartStress, zip(recovery.nodes, *stresses, strict=True)))
    return UnitSolutions(parts, (1, -1) if cut_y else (1,), even.count + odd.count, max(errors))


def _after(one: Floats, other: Floats) -> Floats:
    return np.concatenate([one, other.astype(one.dtype)], axis=2)


def _solution(model: Model, fields: tuple[UnitLoadFields, ...], units: slice) -> StaticSolution:
    """Solve some unit loads; those of two parities in pairs."""
    sums = {parity: of.sums(units) for parity, of in zip(Parity, fields, strict=False)}
    condensed = {parity: total for parity, total in sums.items() if total is not None}
    if condensed:
        return model.solve_sums(condensed)
    if len(fields) == 1:
        return model.solve([ParityPair(one, None) for one in fields[0].forces(units)])
    even, odd = (of.forces(units) for of in fields)
    none = np.zeros_like(even[0] if even else odd[0])
    return model.solve(list(starmap(ParityPair, zip_longest(even, odd, fillvalue=none))))


def _solved(
    model: Model,
    recovery: PartRecovery,
    materials: Sequence[Material],
    *,
    fields: tuple[UnitLoadFields, ...],
    single: bool,
) -> tuple[list[list[Floats]], list[float]]:
    """Stress per parity and part (n, 6, n_units), and backward errors."""
    nodes, errors = recovery.nodes, list[float]()
    double = not single and 48 * sum(map(len, nodes)) * sum(of.count for of in fields) <= DOUBLE_BYTES
    stresses = [
        [np.empty((len(each), 6, of.count), np.float64 if double else np.float32) for each in nodes]
        for of in fields
    ]
    count, column = max(of.count for of in fields), len(fields) * model.mesh.points.nbytes
    for start, stop in _like_blocks(0, count, max(SOLVED, SOLVED_BYTES // column)):
        solution = _solution(model, fields, slice(start, stop))
        errors += [item.backward_error for item in solution.residuals.values()]
        pieces = [range(*ends) for ends in _like_blocks(start, stop, RECOVERED)]
        every = product(zip(Parity, fields, stresses, strict=False), pieces)
        side_by_side(partial(_recover, recovery, materials, solution, start), every)
    return stresses, errors


def _like_blocks(start: int, stop: int, most: int) -> Iterator[tuple[int, int]]:
    """Divide a range into blocks of similar size."""
    return pairwise(np.linspace(start, stop, -(-(stop - start) // most) + 1).astype(int).tolist())


def _recover(
    recovery: PartRecovery,
    materials: Sequence[Material],
    solution: StaticSolution,
    first: int,
    item: tuple[tuple[Parity, UnitLoadFields, list[Floats]], range],
) -> None:
    """Put the stress of some units of one parity in its place; `first` is the first solved."""
    (parity, fields, stresses), units = item
    columns = slice(units.start, min(units.stop, fields.count))
    if columns.stop <= columns.start:
        return
    solved = slice(columns.start - first, columns.stop - first)
    pressure = {number: p[:, solved] for number, p in solution.pressure.get(parity, {}).items()}
    u, traction = solution.displacement[parity][..., solved], fields.traction(columns)
    recovered = recovery.part_stress(u, materials, parity, traction, pressure)
    for part, stress in zip(stresses, recovered, strict=True):
        part[..., columns] = stress


MOST_SPOTS = 5
# Places closer to each other than this fraction of the rod's length count as one.
_APART = 0.1


@dataclass(frozen=True)
class PlaceHistory:
    """One of the worst places."""

    #: node, part: node on the whole rod; number of the part that the stress belongs to
    node: int
    part: int
    place: Floats  #: (3,) mm
    stress: Floats  #: (6, n_instants), MPa, components XX YY ZZ XY YZ XZ
    signed: Floats  #: (n_instants,) signed von Mises stress, MPa


def distinct(points: Floats, factor: Floats, length: float, first: Sequence[int] = ()) -> list[int]:
    """Nodes of the smallest factors, behind the `first`, that are not close; at most `MOST_SPOTS`.

    `points` (n_nodes, 3), mm; images across z = 0 count as one place; `factor` (n_nodes,); `length`: of the
    rod, mm.
    """
    folded = np.abs(points * [0, 0, 1]) + points * [1, 1, 0]
    open_ = points[:, 2] >= -1e-9 * length
    chosen: list[int] = []
    while len(chosen) < MOST_SPOTS and open_.any():
        free = int(np.where(open_, factor, np.inf).argmin())
        node = first[len(chosen)] if len(chosen) < len(first) else free
        chosen.append(node)
        open_ &= np.linalg.norm(folded - folded[node], axis=1) > _APART * length
    return chosen


def spots(
    places: Iterable[tuple[int, int]], units: UnitSolutions, weights: Weights, whole: MirroredMesh
) -> tuple[PlaceHistory, ...]:
    """Return the histories of some nodes of the whole rod, each given with the number of its part."""
    found = []
    for node, number in places:
        part = units.parts[number]
        row = np.searchsorted(part.nodes, whole.source[node])[None]
        x, y, z = whole.sign[node]
        side = int(y) if len(units.sides) > 1 else 1
        (history,) = part.histories(weights, (side,), row)
        stress = tensor(history[0]) * np.array([1, 1, 1, x * y, y * z, x * z])[:, None]
        signed = signed_equivalent(history)[0]
        found.append(PlaceHistory(node, number, whole.mesh.points[node], stress, signed))
    return tuple(found)
