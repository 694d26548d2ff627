"""Displacement and pressure of rods with nearly incompressible parts: Taylor & Hood's pair (1973).

Second-order displacement with a linear pressure of its own neither locks nor lets the mean stress oscillate,
whatever Poisson's ratio. The displacement alone carries 2 μ ε, so that what is factorised is as well
conditioned as steel; the other parts keep their plain stiffness.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy import sparse

from fea.choices import SolverName, Support
from fea.machine.clock import Clock
from fea.material import Material, Materials
from fea.solid.parity import Parity, Split
from fea.solid.pressure import PressureSpace, pressure_space
from fea.solid.saddle import Constraint, solve_saddle
from fea.solid.solve import (
    MOST_REFINEMENTS,
    REFINE_ABOVE,
    Model,
    Residuals,
    Solution,
    right_hand_sides,
    worst_ratio,
)
from fea.solid.supports import plane_conditions
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


class MixedModel(Model):
    """A meshed cell some parts of which have a pressure.

    Parameters
    ----------
    mesh
        The meshed cell, of second order.
    materials
        One a part.
    soft
        Numbers of the parts that get a pressure.
    support, solver, clock
        As for `Model`.
    """

    def __init__(
        self,
        mesh: TetMesh,
        materials: Sequence[Material],
        soft: Sequence[int],
        support: Support,
        *,
        solver: SolverName = SolverName.AUTO,
        clock: Clock | None = None,
    ) -> None:
        shear = tuple(m.without_lambda() if k in soft else m for k, m in enumerate(materials))
        super().__init__(
            mesh, shear[0] if mesh.part is None else Materials(shear, mesh.part), support, solver, clock
        )
        with self._clock("assembly"):
            self._space = pressure_space(mesh, {number: materials[number] for number in soft})

    @property
    def solved_dofs(self) -> int:
        """Unknowns over the parities factorised so far, pressures among them."""
        return super().solved_dofs + sum(int(self._alive(parity).sum()) for parity in self._factorised)

    def solve(self, loads: Sequence[Split]) -> Solution:
        """Displacements and pressures of the cell under each load.

        Raises
        ------
        UnderconstrainedError, SingularMatrixError
            See `Model.solve`.
        StagnationError
            The mesh does not hold a stable pressure.
        """
        displacement, residuals, pressure = {}, {}, {}
        for parity, f in right_hand_sides(loads).items():
            slot = self._slot(parity)
            with self._clock("solve"):
                u, p, residuals[parity] = self._refined(parity, slot, f)
            displacement[parity] = u.reshape(len(self.mesh.points), 3, -1)
            pressure[parity] = self._space.nodal(p, len(self.mesh.points))
        return Solution(displacement, residuals, pressure)

    def _alive(self, parity: Parity) -> Mask:
        """Pressures that are free: an antisymmetric one vanishes on y = 0."""
        vertex = np.concatenate(self._space.vertex)
        if parity is Parity.SYMMETRIC or Surface.SYMMETRY_Y not in self.mesh.facets:
            return np.ones(vertex.size, dtype=bool)
        return ~np.isin(vertex, self.mesh.facets[Surface.SYMMETRY_Y])

    def _refined(self, parity: Parity, slot: int, f: Floats) -> tuple[Floats, Floats, Residuals]:
        """Displacements and pressures, corrected as long as that helps."""
        fixed = self._fixed(parity)
        alive = self._alive(parity)
        constraint = _constraint(self._space, fixed, alive)

        def solve(right: Floats) -> Floats:
            return np.where(fixed[:, None], 0.0, self._solved(slot, np.where(fixed[:, None], 0.0, right)))

        u, p = np.zeros_like(f), np.zeros((len(alive), f.shape[1]))
        found = Residuals(np.inf, np.inf, np.inf)
        for _ in range(1 + MOST_REFINEMENTS):
            first, second = self._imbalance(u, p, f)
            du, dp = solve_saddle(solve, constraint, -first, -second[alive])
            better_u, better_p = u + du, p.copy()
            better_p[alive] += dp
            better = self._quality(better_u, better_p, f, parity)
            if not better.backward_error < found.backward_error:
                break
            u, p, found = better_u, better_p, better
            if not found.backward_error > REFINE_ABOVE:
                break
        return u, p, found

    def _imbalance(self, u: Floats, p: Floats, f: Floats) -> tuple[Floats, Floats]:
        """Residuals A u + Dᵀ p − f and D u − C p."""
        D = self._space.divergence
        return self._K @ u + D.T @ p - f, D @ u - self._space.compressed(p)

    def _quality(self, u: Floats, p: Floats, f: Floats, parity: Parity) -> Residuals:
        """Both equations count; the energy is uᵀAu + pᵀCp, that of shear and of compression."""
        fixed, alive = self._fixed(parity), self._alive(parity)
        held = self._held.ravel() & ~plane_conditions(self.mesh, parity).ravel()
        first, second = self._imbalance(u, p, f)
        D, compressed = abs(self._space.divergence), self._space.compressed(p)
        most_u, most_p, most_f = (np.abs(field).max(axis=0) for field in (u, p, f))
        forces = self._K.norm() * most_u + D.sum(axis=0).max() * most_p + most_f
        widths = D.sum(axis=1).max() * most_u + np.abs(compressed).max(axis=0)
        work = (u * f).sum(axis=0)
        energy = (u * (self._K @ u)).sum(axis=0) + (p * compressed).sum(axis=0)
        return Residuals(
            max(
                worst_ratio(np.abs(np.where(fixed[:, None], 0.0, first)).max(axis=0), forces),
                worst_ratio(np.abs(second[alive]).max(axis=0), widths),
            ),
            worst_ratio(np.abs(energy - work), np.abs(work)),
            float(np.abs(first[held]).max(initial=0.0)),
        )


def _constraint(space: PressureSpace, fixed: Mask, alive: Mask) -> Constraint:
    free = sparse.diags_array((~fixed).astype(float))
    compliance = 1 / space.lame_lambda[alive]
    return Constraint(
        sparse.csr_array(space.divergence[alive] @ free),
        sparse.csr_array(space.mass[alive][:, alive]),
        compliance,
        1 / (2 * space.shear_modulus[alive]) + compliance,
    )
