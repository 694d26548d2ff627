"""Solve K u = f for all loads at once, with one factorisation per parity, and check the solution."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeVar

import numpy as np
from scipy import sparse

from fea.base.choices import MatrixAssembly, SolverName, Support
from fea.base.material import Material, Materials
from fea.machine.clock import Clock
from fea.solid.assembly import Pattern, SymmetricMatrix, pattern, stiffness
from fea.solid.errors import StagnationError
from fea.solid.parity import Parity, ParityPair
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
from fea.solvers.direct import LinearSolver, direct, factorise
from fea.solvers.residuals import Residuals, condition_of, probe, refined, residuals
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

Result = TypeVar("Result")


@dataclass(frozen=True)
class StaticSolution:
    """Displacement of every load case."""

    #: Per parity (n_nodes, 3, n_cases), mm; the antisymmetric part is absent if no load has one
    displacement: dict[Parity, Floats]
    residuals: dict[Parity, Residuals]  #: per parity
    #: Per parity and number of a part (`fea.solvers.mixed`): (n_nodes, n_cases), MPa, positive in tension
    pressure: dict[Parity, dict[int, Floats]] = field(default_factory=dict)
    #: Condition number of the stiffness, per parity (`fea.solvers.residuals`), if it was estimated
    condition: dict[Parity, float] = field(default_factory=dict)

    def moved(self, shifts: Sequence[ParityPair]) -> "StaticSolution":
        """Return the solution with a further displacement in each case, which causes no stress."""
        moved = {
            parity: u + np.stack([shift.part(parity) for shift in shifts], axis=-1)
            for parity, u in self.displacement.items()
        }
        return replace(self, displacement=moved)


@dataclass(frozen=True)
class Symbolic:
    """Data common to the stiffnesses of meshes with the same elements: see `Model.handed_on`."""

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
        assembly: MatrixAssembly = MatrixAssembly.BATCHED,
        symbolic: Symbolic | None = None,
    ) -> None:
        self.mesh = mesh
        self._clock = clock or Clock()
        self.material = material
        if symbolic is not None and not np.array_equal(symbolic.tets, mesh.tets):
            symbolic = None
        self._slots = len(Parity) if Surface.SYMMETRY_Y in mesh.facets else 1
        self._new_solver = partial(linear_solver, solver, mesh, material, self._slots)
        self._solver = self._new_solver() if symbolic is None else symbolic.solver
        self._factorised: list[Parity] = []  # by the slot of the factor
        self._condition: dict[Parity, float] = {}
        self._condensed: dict[Parity, sparse.csc_array] = {}
        self._restraints = _restraints(mesh, support)
        with self._clock("assembly"):
            self._layout = pattern(mesh.tets, len(mesh.points)) if symbolic is None else symbolic.layout
            if assembly is MatrixAssembly.BATCHED:
                self._K = stiffness(mesh, material, self._layout)
            else:
                self._K = assembled_stiffness(mesh, material)

    @property
    def solved_dofs(self) -> int:
        """Degrees of freedom over the parities factorised so far."""
        return sum(int(np.count_nonzero(~self._fixed(parity))) for parity in self._factorised)

    @property
    def solver(self) -> str:
        """Name of the solver used."""
        return self._solver.name

    @property
    def _iterative(self) -> bool:
        return self._solver.name == SolverName.AMG

    def handed_on(self) -> Symbolic | None:
        """Return what a model of the moved mesh can reuse; None with an iterative solver."""
        if self._iterative:
            return None
        symbolic = Symbolic(self.mesh.tets, self._layout, self._solver)
        self._solver, self._factorised = self._new_solver(), []
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
            return self._with_fallback(lambda solver: solver.work(slot, free))

    def _factorised_by(self, factorise: Callable[[int, SymmetricMatrix], Result], parity: Parity) -> Result:
        fixed = self._fixed(parity)
        require_restrained(self.mesh, fixed.reshape(-1, 3))
        new = parity not in self._factorised
        slot = len(self._factorised) if new else self._factorised.index(parity)
        with self._clock("factor"):
            result = factorise(slot, self._K.constrained(fixed))
        if new:
            self._factorised.append(parity)
        return result

    def _fixed(self, parity: Parity) -> Mask:
        return plane_conditions(self.mesh, parity).ravel() | self._restraints[parity]

    def _restraints_off_planes(self, parity: Parity) -> Mask:
        """Degrees of freedom (n,) that stop a rigid motion and that no mirror plane fixes."""
        return self._restraints[parity] & ~plane_conditions(self.mesh, parity).ravel()

    def _slot(self, parity: Parity) -> int:
        if parity not in self._factorised:
            self._factorised_by(self._solver.factorise, parity)
        return self._factorised.index(parity)

    def solve(self, loads: Sequence[ParityPair]) -> StaticSolution:
        """Displacements of the cell under each load.

        Raises `UnderconstrainedError`: the supports leave a rigid motion free; `SingularMatrixError`: the
        factorisation broke down.
        """
        return self._solution(right_hand_sides(loads), self._refined)

    def displaced(self, forces: Mapping[Parity, Floats]) -> dict[Parity, Floats]:
        """Displacements (n_nodes, 3, k) of the cell under nodal forces (k, n_nodes, 3) of each parity."""
        sides = {parity: part.reshape(len(part), -1).T for parity, part in forces.items()}
        return self._solution(sides, self._refined).displacement

    def solve_sums(self, columns: Mapping[Parity, Floats]) -> StaticSolution:
        """Displacements under sums of the forces of `compliance`, by columns of weights (k, n)."""

        def summed(parity: Parity, slot: int, weights: Floats) -> tuple[Floats, Residuals]:
            forces = self._condensed[parity]
            u = self._solver.solve_sums(slot, unheld(forces, self._fixed(parity)), weights)
            return self._refined(parity, slot, forces @ weights, u)

        return self._solution(columns, summed)

    def _solution(
        self,
        sides: Mapping[Parity, Floats],
        solved: Callable[[Parity, int, Floats], tuple[Floats, Residuals]],
    ) -> StaticSolution:
        displacement, checked = {}, {}
        for parity, side in sides.items():
            slot = self._slot(parity)
            with self._clock("solve"):
                u, checked[parity] = solved(parity, slot, side)
            displacement[parity] = u.reshape(len(self.mesh.points), 3, -1)
        return StaticSolution(displacement, checked, condition=dict(self._condition))

    def _refined(
        self, parity: Parity, slot: int, f: Floats, u: Floats | None = None
    ) -> tuple[Floats, Residuals]:
        """Solve for (n, k) forces, and refine an inaccurate solution `u` as long as that helps."""
        fixed, restraints = self._fixed(parity), self._restraints_off_planes(parity)
        held = fixed[:, None]
        if u is None:
            u = self._probed(parity, slot, np.where(held, 0.0, f))
        u[fixed] = 0.0

        def corrected(u: Floats) -> Floats:
            residual = np.where(held, 0.0, f - self._K @ u)
            return np.asarray(u + np.where(held, 0.0, self._solved(slot, residual)))

        def checked(u: Floats) -> Residuals:
            return residuals(self._K, u, f, fixed=fixed, restraints=restraints, singly=self._iterative)

        return refined(u, corrected, checked)

    def _probed(self, parity: Parity, slot: int, f: Floats) -> Floats:
        """Solve; the first time together with the probe for the condition number, unless iteratively."""
        if parity in self._condition:
            return self._solved(slot, f)
        if self._iterative:
            u = self._solved(slot, f)
            self._condition[parity] = condition_of(self._K, u, f)
            return u
        softest = np.where(self._fixed(parity)[:, None], 0.0, probe(self._K))
        u = self._solved(slot, np.hstack([f, softest]))
        self._condition[parity] = condition_of(self._K, u[:, -1:], softest)
        return u[:, :-1]

    def _solved(self, slot: int, f: Floats) -> Floats:
        return self._with_fallback(lambda solver: solver.solve(slot, f))

    def _with_fallback(self, solve: Callable[[LinearSolver], Floats]) -> Floats:
        """Solve; if the iterative solver stagnates, directly if that fits."""
        try:
            return solve(self._solver)
        except StagnationError as error:
            self._fall_back(error)
            return solve(self._solver)

    def _fall_back(self, error: StagnationError) -> None:
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


def right_hand_sides(loads: Sequence[ParityPair]) -> dict[Parity, Floats]:
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

    Where `fixed` (n_nodes, 3), it is that of `moved` (n_nodes, 3), mm; zero by default. Raises
    `UnderconstrainedError`: a rigid motion is free; `SingularMatrixError`: the factorisation broke down.
    """
    require_restrained(mesh, fixed)
    K = stiffness(mesh, material, pattern(mesh.tets, len(mesh.points)))
    held = fixed.ravel()
    u = np.zeros(held.size) if moved is None else np.where(held, moved.ravel(), 0.0)
    right = np.where(held, 0.0, forces.ravel() - K @ u)
    u += np.where(held, 0.0, factorise(K.constrained(held))(right[:, None])[:, 0])
    return np.asarray(u.reshape(-1, 3, 1))
