"""Solve K u = f for all loads at once, with one factorisation per parity, and check the solution."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeVar

import numpy as np
from scipy import sparse

from fea.base.choices import Assembly, SolverName, Support
from fea.base.material import Material, Materials
from fea.machine.clock import Clock
from fea.solid.assembly import Pattern, SymmetricMatrix, pattern, stiffness
from fea.solid.errors import StagnationError
from fea.solid.parity import Parity, Split
from fea.solid.scikit_fem import assembled_stiffness
from fea.solid.supports import (
    clamped,
    determinate_restraints,
    isostatic_restraints,
    plane_conditions,
    require_restrained,
)
from fea.solvers import choice as memory
from fea.solvers.choice import linear_solver
from fea.solvers.direct import direct, factorise
from fea.solvers.linear_solver import LinearSolver
from fea.solvers.residuals import Residuals, condition_of, probe, refined, residuals
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

Made = TypeVar("Made")


@dataclass(frozen=True)
class Solution:
    """Displacement of every load case."""

    #: Per parity (n_nodes, 3, n_cases), mm; the antisymmetric part is absent if no load has one
    displacement: dict[Parity, Floats]
    residuals: dict[Parity, Residuals]  #: per parity
    #: Per parity, by the number of each part that has one (`fea.solvers.mixed`): (n_nodes, n_cases), MPa,
    #: positive in tension
    pressure: dict[Parity, dict[int, Floats]] = field(default_factory=dict)
    #: Condition number of the stiffness, per parity (`fea.solvers.residuals`), if it was estimated
    condition: dict[Parity, float] = field(default_factory=dict)

    def moved(self, shifts: Sequence[Split]) -> "Solution":
        """Return the solution with a further displacement in each case, which causes no stress."""
        moved = {p: np.stack([each.part(p) for each in shifts], axis=-1) for p in self.displacement}
        return replace(self, displacement={p: u + moved[p] for p, u in self.displacement.items()})


@dataclass(frozen=True)
class Symbolic:
    """What the stiffnesses of meshes with the same elements share: see `Model.handed_on`."""

    tets: Ints  #: (n_elements, n_nodes) of the meshes
    layout: Pattern  #: where the elements' blocks lie in the matrix
    solver: LinearSolver  #: which has ordered and analysed it


class Model:
    """A meshed cell with its stiffness, factorised once per parity, for the first load that needs it.

    The clock times the stages ``assembly``, ``factor`` and ``solve``. `symbolic`: handed on by a model of a
    mesh that was moved to this one; ignored if its elements are others.
    """

    def __init__(
        self,
        mesh: TetMesh,
        material: Material | Materials,
        support: Support,
        solver: SolverName = SolverName.AUTO,
        clock: Clock | None = None,
        *,
        assembly: Assembly = Assembly.BATCHED,
        symbolic: Symbolic | None = None,
    ) -> None:
        self.mesh = mesh
        self._clock = clock or Clock()
        self.material = material
        if symbolic is not None and not np.array_equal(symbolic.tets, mesh.tets):
            symbolic = None
        self._slots = len(Parity) if Surface.SYMMETRY_Y in mesh.facets else 1
        self._begun = partial(linear_solver, solver, mesh, material, self._slots)
        self._solver = self._begun() if symbolic is None else symbolic.solver
        self._factorised: list[Parity] = []
        self._condition: dict[Parity, float] = {}
        self._condensed: dict[Parity, sparse.csc_array] = {}
        self._restraints = _restraints(mesh, support)
        with self._clock("assembly"):
            self._layout = pattern(mesh.tets, len(mesh.points)) if symbolic is None else symbolic.layout
            batched = assembly is Assembly.BATCHED
            self._K = (
                stiffness(mesh, material, self._layout) if batched else assembled_stiffness(mesh, material)
            )

    @property
    def solved_dofs(self) -> int:
        """Degrees of freedom over the parities factorised so far."""
        return sum(int(np.count_nonzero(~self._fixed(parity))) for parity in self._factorised)

    @property
    def solver(self) -> str:
        """Name of the solver used."""
        return self._solver.name

    def handed_on(self) -> Symbolic | None:
        """Return what a model of the moved mesh can reuse; None with an iterative solver."""
        if self._solver.name == SolverName.AMG:
            return None
        symbolic = Symbolic(self.mesh.tets, self._layout, self._solver)
        self._solver, self._factorised = self._begun(), []
        return symbolic

    @property
    def stiffness(self) -> SymmetricMatrix:
        """K without any support."""
        return self._K

    def restrained(self, parity: Parity) -> tuple[Mask, Callable[[Floats], Floats]]:
        """Constrained degrees of freedom (n,) of a parity about y = 0, and the solver for (n, k) forces."""
        slot = self._slot(parity)
        return self._fixed(parity), lambda forces: self._solved(slot, forces)

    def compliance(self, parity: Parity, forces: sparse.csc_array) -> Floats:
        """Work FᵀK⁻¹F (k, k) of sparse forces F (n, k) of one parity on the displacements that they cause.

        The forces need not balance: restraints that stop rigid motions react them.
        """
        self._condensed[parity], free = forces, unheld(forces, self._fixed(parity))
        return self._factorised_by(partial(self._solver.condense, forces=free), parity)

    def work(self, parity: Parity, forces: Floats) -> Floats:
        """Work (k, k) of nodal forces (k, n_nodes, 3) of one parity on what they cause: see `compliance`."""
        free = np.where(self._fixed(parity), 0.0, forces.reshape(len(forces), -1)).T
        slot = self._slot(parity)
        with self._clock("solve"):
            return self._done(lambda solver: solver.work(slot, free))

    def _factorised_by(self, factorise: Callable[[int, SymmetricMatrix], Made], parity: Parity) -> Made:
        fixed, known = self._fixed(parity), parity in self._factorised
        require_restrained(self.mesh, fixed.reshape(-1, 3))
        slot = self._factorised.index(parity) if known else len(self._factorised)
        with self._clock("factor"):
            made = factorise(slot, self._K.constrained(fixed))
        if not known:
            self._factorised.append(parity)
        return made

    def _fixed(self, parity: Parity) -> Mask:
        return plane_conditions(self.mesh, parity).ravel() | self._restraints[parity]

    def _restraints_off_planes(self, parity: Parity) -> Mask:
        """Degrees of freedom (n,) that stop a rigid motion and that no mirror plane fixes."""
        return self._restraints[parity] & ~plane_conditions(self.mesh, parity).ravel()

    def _slot(self, parity: Parity) -> int:
        if parity not in self._factorised:
            self._factorised_by(self._solver.factorise, parity)
        return self._factorised.index(parity)

    def solve(self, loads: Sequence[Split]) -> Solution:
        """Displacements of the cell under each load.

        Raises `UnderconstrainedError`: the supports leave a rigid motion free; `SingularMatrixError`: the
        factorisation broke down.
        """
        return self._solution(right_hand_sides(loads), self._refined)

    def displaced(self, forces: Mapping[Parity, Floats]) -> dict[Parity, Floats]:
        """Displacements (n_nodes, 3, k) of the cell under nodal forces (k, n_nodes, 3) of each parity."""
        sides = {parity: own.reshape(len(own), -1).T for parity, own in forces.items()}
        return self._solution(sides, self._refined).displacement

    def solve_sums(self, columns: Mapping[Parity, Floats]) -> Solution:
        """Displacements under sums of the forces of `compliance`, by columns of weights (k, n)."""

        def summed(parity: Parity, slot: int, own: Floats) -> tuple[Floats, Residuals]:
            forces = self._condensed[parity]
            u = self._solver.solve_sums(slot, unheld(forces, self._fixed(parity)), own)
            return self._refined(parity, slot, forces @ own, u)

        return self._solution(columns, summed)

    def _solution(
        self,
        sides: Mapping[Parity, Floats],
        solved: Callable[[Parity, int, Floats], tuple[Floats, Residuals]],
    ) -> Solution:
        displacement, left = {}, {}
        for parity, side in sides.items():
            slot = self._slot(parity)
            with self._clock("solve"):
                u, left[parity] = solved(parity, slot, side)
            displacement[parity] = u.reshape(len(self.mesh.points), 3, -1)
        return Solution(displacement, left, condition=dict(self._condition))

    def _refined(
        self, parity: Parity, slot: int, f: Floats, u: Floats | None = None
    ) -> tuple[Floats, Residuals]:
        """Solve for (n, k) forces, and refine an inaccurate solution `u` as long as that helps."""
        fixed = self._fixed(parity)
        restraints = self._restraints_off_planes(parity)
        if u is None:
            u = self._probed(parity, slot, np.where(fixed[:, None], 0.0, f))
        u[fixed] = 0.0

        def corrected(u: Floats) -> Floats:
            left = np.where(fixed[:, None], 0.0, f - self._K @ u)
            return np.asarray(u + np.where(fixed[:, None], 0.0, self._solved(slot, left)))

        def checked(u: Floats) -> Residuals:
            singly = self._solver.name == SolverName.AMG
            return residuals(self._K, u, f, fixed=fixed, restraints=restraints, singly=singly)

        return refined(u, corrected, checked)

    def _probed(self, parity: Parity, slot: int, f: Floats) -> Floats:
        """Solve; the first time together with the probe for the condition number, unless iteratively."""
        if parity in self._condition:
            return self._solved(slot, f)
        if self._solver.name == SolverName.AMG:
            u = self._solved(slot, f)
            self._condition[parity] = condition_of(self._K, u, f)
            return u
        softest = np.where(self._fixed(parity)[:, None], 0.0, probe(self._K))
        u = self._solved(slot, np.hstack([f, softest]))
        self._condition[parity] = condition_of(self._K, u[:, -1:], softest)
        return u[:, :-1]

    def _solved(self, slot: int, f: Floats) -> Floats:
        return self._done(lambda solver: solver.solve(slot, f))

    def _done(self, what: Callable[[LinearSolver], Floats]) -> Floats:
        """Solve; if the iterative solver stagnates, directly if that fits."""
        try:
            return what(self._solver)
        except StagnationError as error:
            self._hand_over(error)
            return what(self._solver)

    def _hand_over(self, error: StagnationError) -> None:
        """Continue with the direct solver, or raise the iterative one's error if memory does not allow it."""
        need = memory.direct_bytes(self.mesh.points.size, self._slots)
        if need > memory.SHARE * memory.available_bytes():
            raise error
        self._solver = linear_solver(direct(), self.mesh, self.material, self._slots)
        parities, self._factorised = self._factorised, []
        for parity in parities:
            self._slot(parity)


def _restraints(mesh: TetMesh, support: Support) -> dict[Parity, Mask]:
    """Degrees of freedom (n,) that a support holds, by the parity about y = 0."""
    if support is Support.CLAMPED:
        return dict.fromkeys(Parity, clamped(mesh, Surface.BIG_END_BORE).ravel())
    if mesh.interfaces:  # each part by itself, as contact holds them together
        return {parity: isostatic_restraints(mesh, (parity, Parity.SYMMETRIC)) for parity in Parity}
    return dict.fromkeys(Parity, determinate_restraints(mesh).ravel())


def unheld(forces: sparse.csc_array, fixed: Mask) -> sparse.csc_array:
    """Sparse forces (n, k) without those on fixed degrees of freedom (n,), whose zeros stay stored."""
    data = forces.data * ~fixed[forces.indices]
    return sparse.csc_array((data, forces.indices, forces.indptr), forces.shape)


def right_hand_sides(loads: Sequence[Split]) -> dict[Parity, Floats]:
    """Columns (3 n_nodes, n_cases) per parity; the antisymmetric ones only if a load has that part."""

    def column_stack(parts: Sequence[Floats]) -> Floats:
        return np.stack([part.ravel() for part in parts]).T  # by columns, as direct solvers take them

    sides = {Parity.SYMMETRIC: column_stack([load.symmetric for load in loads])}
    odd = [load.antisymmetric for load in loads if load.antisymmetric is not None]
    if len(odd) == len(loads):
        antisymmetric = column_stack(odd)
        # The antisymmetric part of purely axial loads is only rounding.
        if np.abs(antisymmetric).max() > 1e-12 * np.abs(sides[Parity.SYMMETRIC]).max():
            sides[Parity.ANTISYMMETRIC] = antisymmetric
    return sides


def displacement(
    mesh: TetMesh, material: Material, forces: Floats, fixed: Mask, moved: Floats | None = None
) -> Floats:
    """Solve K u = f (n_nodes, 3, 1), mm, for forces (n_nodes, 3), N, with some displacements prescribed.

    Where `fixed` (n_nodes, 3), the displacement is that of `moved` (n_nodes, 3), mm; zero by default. Raises
    `UnderconstrainedError`: the supports leave a rigid motion free; `SingularMatrixError`: the factorisation
    broke down.
    """
    require_restrained(mesh, fixed)
    K = stiffness(mesh, material, pattern(mesh.tets, len(mesh.points)))
    held = fixed.ravel()
    u = np.zeros(held.size) if moved is None else np.where(held, moved.ravel(), 0.0)
    right = np.where(held, 0.0, forces.ravel() - K @ u)
    u += np.where(held, 0.0, factorise(K.constrained(held))(right[:, None])[:, 0])
    return np.asarray(u.reshape(-1, 3, 1))
