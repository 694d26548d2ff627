"""Solve K u = f for every load at once, one factorisation a parity, and check what came out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from fea.choices import SolverName, Support
from fea.machine.clock import Clock
from fea.material import Material, Materials
from fea.solid.assembly import SymmetricMatrix, pattern, stiffness
from fea.solid.errors import StagnationError
from fea.solid.parity import Parity, Split
from fea.solid.supports import (
    clamped,
    determinate_restraints,
    plane_conditions,
    require_restrained,
)
from fea.solvers import memory
from fea.solvers.condition import condition_of, probe
from fea.solvers.solvers import direct, linear_solver
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

Floats = npt.NDArray[np.float64]

# A direct solver leaves a few units in the last place, the iterative one some thousand. What would fail its
# check (1e-12) gets a step of refinement (Wilkinson 1963), or as many as help.
REFINE_ABOVE = 9e-13
# The same of what is left of the forces: a part far stiffer than the rest gives ‖K‖ all to itself, so that a
# backward error within its limit may hide forces that matter where the rest is.
REFINE_IMBALANCE = 1e-8
MOST_REFINEMENTS = 3
# So many right-hand sides of a direct solver are checked one by one; of more, a few random sums.
CHECKED_SINGLY = 8
_SUMS = 3


@dataclass(frozen=True)
class Residuals:
    """How well the equations of one parity are satisfied, the worst over its right-hand sides.

    Many right-hand sides of a direct solver are held against these by random sums of theirs, each column
    divided by ‖K‖ ‖u‖ + ‖f‖.

    Attributes
    ----------
    backward_error
        ‖Ku − f‖ / (‖K‖ ‖u‖ + ‖f‖), maximum norms (Rigal & Gaches 1967).
    energy
        |uᵀKu − uᵀf| / uᵀf.
    reaction
        Largest force at a restraint of inertia relief, N (of sums: in parts of that scale); it should vanish.
    imbalance
        ‖Ku − f‖ / ‖f‖, maximum norms.
    """

    backward_error: float
    energy: float
    reaction: float
    imbalance: float

    @property
    def rough(self) -> bool:
        """Whether refinement is worth a try."""
        return self.backward_error > REFINE_ABOVE or self.imbalance > REFINE_IMBALANCE

    def better_than(self, other: "Residuals") -> bool:
        """Whether a step of refinement from `other` helped."""
        return max(self.backward_error / REFINE_ABOVE, self.imbalance / REFINE_IMBALANCE) < max(
            other.backward_error / REFINE_ABOVE, other.imbalance / REFINE_IMBALANCE
        )


@dataclass(frozen=True)
class Solution:
    """Displacement of every load case.

    Attributes
    ----------
    displacement
        Per parity (n_nodes, 3, n_cases), mm; the antisymmetric part is absent where no load has one.
    residuals
        Per parity.
    pressure
        Per parity, by the number of each part that has one (`fea.solvers.mixed`): (n_nodes, n_cases), MPa,
        positive in tension.
    condition
        Of the stiffness, per parity (`fea.solvers.condition`), where it was estimated.
    """

    displacement: dict[Parity, Floats]
    residuals: dict[Parity, Residuals]
    pressure: dict[Parity, dict[int, Floats]] = field(default_factory=dict)
    condition: dict[Parity, float] = field(default_factory=dict)


class Model:
    """A meshed cell with its stiffness; factorised once a parity, on the first load that needs it.

    Parameters
    ----------
    mesh
        The meshed cell.
    material
        Of every element, or of each part.
    support
        How the rod is held.
    solver
        Which linear solver.
    clock
        Times the stages ``assembly``, ``factor`` and ``solve``.
    """

    def __init__(
        self,
        mesh: TetMesh,
        material: Material | Materials,
        support: Support,
        solver: SolverName = SolverName.AUTO,
        clock: Clock | None = None,
    ) -> None:
        self.mesh = mesh
        self._clock = clock or Clock()
        cut = Surface.SYMMETRY_Y in mesh.facets
        self.material = material
        self._solver = linear_solver(solver, mesh, material, slots=len(Parity) if cut else 1)
        self._factorised: list[Parity] = []
        self._condition: dict[Parity, float] = {}
        self._held = (
            clamped(mesh, Surface.BIG_END_BORE)
            if support is Support.CLAMPED
            else determinate_restraints(mesh)
        )
        with self._clock("assembly"):
            self._K = stiffness(mesh, material, pattern(mesh.tets, len(mesh.points)))

    @property
    def solved_dofs(self) -> int:
        """Unknowns over the parities factorised so far."""
        return sum(int(np.count_nonzero(~self._fixed(parity))) for parity in self._factorised)

    @property
    def solver(self) -> str:
        """Name of the solver used."""
        return self._solver.name

    @property
    def stiffness(self) -> SymmetricMatrix:
        """K without any support."""
        return self._K

    def restrained(self, parity: Parity) -> tuple[npt.NDArray[np.bool_], Callable[[Floats], Floats]]:
        """Degrees of freedom (n,) held for a parity about y = 0, and what solves for (n, k) forces then."""
        slot = self._slot(parity)
        return self._fixed(parity), lambda forces: self._solved(slot, forces)

    def _fixed(self, parity: Parity) -> npt.NDArray[np.bool_]:
        return (plane_conditions(self.mesh, parity) | self._held).ravel()

    def _slot(self, parity: Parity) -> int:
        """Slot of the solver that holds the factor of a parity."""
        if parity not in self._factorised:
            fixed = self._fixed(parity)
            require_restrained(self.mesh, fixed.reshape(-1, 3))
            with self._clock("factor"):
                self._solver.factorise(len(self._factorised), self._K.constrained(fixed))
            self._factorised.append(parity)
        return self._factorised.index(parity)

    def solve(self, loads: Sequence[Split]) -> Solution:
        """Displacements of the cell under each load.

        Raises
        ------
        UnderconstrainedError
            A rigid motion is left free.
        SingularMatrixError
            The factorisation broke down.
        """
        displacement: dict[Parity, Floats] = {}
        residuals: dict[Parity, Residuals] = {}
        for parity, f in right_hand_sides(loads).items():
            fixed = self._fixed(parity)
            slot = self._slot(parity)
            with self._clock("solve"):
                held = self._held.ravel() & ~plane_conditions(self.mesh, parity).ravel()
                u = self._probed(parity, slot, np.where(fixed[:, None], 0.0, f))
                u[fixed] = 0.0
                residuals[parity] = self._checked(u, f, fixed, held)
                for _ in range(MOST_REFINEMENTS):
                    if not residuals[parity].rough:
                        break
                    left = np.where(fixed[:, None], 0.0, f - self._K @ u)
                    better = u + np.where(fixed[:, None], 0.0, self._solved(slot, left))
                    found = self._checked(better, f, fixed, held)
                    if not found.better_than(residuals[parity]):
                        break
                    u, residuals[parity] = better, found
            displacement[parity] = u.reshape(len(self.mesh.points), 3, -1)
        return Solution(displacement, residuals, condition=dict(self._condition))

    def _checked(
        self, u: Floats, f: Floats, fixed: npt.NDArray[np.bool_], held: npt.NDArray[np.bool_]
    ) -> Residuals:
        """Hold every column against its right-hand side, or sums of many columns of a direct solver."""
        load = np.abs(f).max(axis=0)
        scale = self._K.norm() * np.abs(u).max(axis=0) + load
        if u.shape[1] > CHECKED_SINGLY and self._solver.name != SolverName.AMG:
            weights = _signed_shares(scale)
            # Of the columns the one whose load is the least part of its scale.
            least = np.full(_SUMS, np.min(load[load > 0] / scale[load > 0], initial=1.0))
            return _residuals(
                self._K, u @ weights, f @ weights, (np.ones(_SUMS), least), fixed=fixed, held=held
            )
        return _residuals(self._K, u, f, (scale, load), fixed=fixed, held=held)

    def _probed(self, parity: Parity, slot: int, f: Floats) -> Floats:
        """Solve, at first together with what tells the condition; an iterative solver has the loads alone."""
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
        """Solve with the factor in a slot; where the iterative solver stagnates, directly if that fits."""
        try:
            return self._solver.solve(slot, f)
        except StagnationError:
            slots = len(Parity) if Surface.SYMMETRY_Y in self.mesh.facets else 1
            if memory.direct_bytes(self.mesh.points.size, slots) > memory.SHARE * memory.available_bytes():
                raise
            self._solver = linear_solver(direct(), self.mesh, self.material, slots)
            parities, self._factorised = self._factorised, []
            for parity in parities:
                self._slot(parity)
            return self._solver.solve(slot, f)


def right_hand_sides(loads: Sequence[Split]) -> dict[Parity, Floats]:
    """Columns (3 n_nodes, n_cases) per parity; the antisymmetric one only where a load has that part."""

    def column_stack(parts: Sequence[Floats]) -> Floats:
        return np.stack([part.ravel() for part in parts], axis=1)

    sides = {Parity.SYMMETRIC: column_stack([load.symmetric for load in loads])}
    odd = [load.antisymmetric for load in loads if load.antisymmetric is not None]
    if len(odd) == len(loads):
        antisymmetric = column_stack(odd)
        # Purely axial loads leave rounding only.
        if np.abs(antisymmetric).max() > 1e-12 * np.abs(sides[Parity.SYMMETRIC]).max():
            sides[Parity.ANTISYMMETRIC] = antisymmetric
    return sides


def _signed_shares(scale: Floats) -> Floats:
    """Weights (n, k) of k sums of n columns, each counting by its scale (n,), with random signs.

    Whatever the others err by, a sum's residual at a place is no less than one column's there for at least
    one of that column's two signs (after Freivalds 1977): three sums let the worst column hide once in eight
    times at most, and a broken factor, which spoils them all, practically never.
    """
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (len(scale), _SUMS))
    return np.asarray(np.divide(signs, scale[:, None], out=np.zeros_like(signs), where=scale[:, None] != 0))


def _residuals(
    K: SymmetricMatrix,
    u: Floats,
    f: Floats,
    scales: tuple[Floats, Floats],
    *,
    fixed: npt.NDArray[np.bool_],
    held: npt.NDArray[np.bool_],
) -> Residuals:
    """Hold u (n, k) against f; `scales` are those of the backward error and of the imbalance, (k,) each."""
    product = K @ u
    left = np.abs(np.where(fixed[:, None], 0.0, product - f)).max(axis=0)
    work = (u * f).sum(axis=0)
    energy = (u * product).sum(axis=0)
    reaction = np.abs((product - f)[held]).max(initial=0.0)
    return Residuals(
        worst_ratio(left, scales[0]),
        worst_ratio(np.abs(energy - work), np.abs(work)),
        float(reaction),
        worst_ratio(left, scales[1]),
    )


def worst_ratio(error: Floats, scale: Floats) -> float:
    """Largest ratio; a load case without any load counts as exact, a value that is not finite as infinite."""
    if not (np.isfinite(error).all() and np.isfinite(scale).all()):
        return float("inf")
    loaded = scale > 0
    return float((error[loaded] / scale[loaded]).max(initial=0.0))
