"""Solve and check the equations of displacement and pressure with their supports."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy import sparse

from fea.material import Material
from fea.solid.assembly import SymmetricMatrix
from fea.solvers.linear.conjugate_gradients import Operator
from fea.solvers.pressure import PressureSpace
from fea.solvers.residuals import Residuals, worst_ratio
from fea.solvers.saddle import Constraint, iterate_saddle, solve_saddle
from fea.solvers.static import MOST_REFINEMENTS
from geometry.arrays import Floats, Mask


def shear_materials(materials: Sequence[Material], soft: Sequence[int]) -> tuple[Material, ...]:
    """Return the materials of the displacement equations: for the `soft` parts only 2 μ ε."""
    return tuple(m.without_lambda() if n in soft else m for n, m in enumerate(materials))


@dataclass(frozen=True)
class MixedSystem:
    """The equations A u + Dᵀ p = f, D u − C p = 0 with their supports.

    Attributes
    ----------
    stiffness
        A, N/mm, with the materials of `shear_materials`.
    space
        Gives D, and C, which is the mass matrix over λ.
    fixed
        (3 n_nodes,) displacements that are zero.
    alive
        (n_pressures,) pressures that are not zero by symmetry.
    """

    stiffness: SymmetricMatrix
    space: PressureSpace
    fixed: Mask
    alive: Mask

    def solve(self, inverse: Operator, f: Floats) -> tuple[Floats, Floats, Residuals]:
        """Displacements and pressures, each (n_unknowns, n_cases), refined as long as that helps.

        Parameters
        ----------
        inverse
            Solves with A including its supports.
        f
            (3 n_nodes, n_cases), N.

        Raises
        ------
        StagnationError
            The mesh does not allow a stable pressure.
        """
        return self._corrected(partial(solve_saddle, self._free(inverse), self._constraint), f)

    def iterate(self, precondition: Operator, f: Floats) -> tuple[Floats, Floats, Residuals]:
        """Solve as in `solve`, with an approximation of A⁻¹ including its supports."""
        stiffness, precondition = self._free(self.stiffness.__matmul__), self._free(precondition)
        return self._corrected(partial(iterate_saddle, stiffness, precondition, self._constraint), f)

    def _free(self, operator: Operator) -> Operator:
        """Restrict an operator to the free displacements."""
        cut = self.fixed[:, None]
        return lambda field: np.where(cut, 0.0, operator(np.where(cut, 0.0, field)))

    def _corrected(
        self, solve: Callable[[Floats, Floats], tuple[Floats, Floats]], f: Floats
    ) -> tuple[Floats, Floats, Residuals]:
        u, p = np.zeros_like(f), np.zeros((len(self.alive), f.shape[1]))
        found = Residuals(np.inf, np.inf, np.inf, np.inf)
        for _ in range(1 + MOST_REFINEMENTS):
            first, second = self._imbalance(u, p, f)
            du, dp = solve(np.where(self.fixed[:, None], 0.0, -first), -second[self.alive])
            better_u, better_p = u + du, p.copy()
            better_p[self.alive] += dp
            better = self._residuals(better_u, better_p, f)
            if not better.better_than(found):
                break
            u, p, found = better_u, better_p, better
            if not found.rough:
                break
        return u, p, found

    @cached_property
    def _constraint(self) -> Constraint:
        free = sparse.diags_array((~self.fixed).astype(float))
        compliance = 1 / self.space.lame_lambda[self.alive]
        return Constraint(
            sparse.csr_array(self.space.divergence[self.alive] @ free),
            sparse.csr_array(self.space.mass[self.alive][:, self.alive]),
            compliance,
            1 / (2 * self.space.shear_modulus[self.alive]) + compliance,
        )

    def _imbalance(self, u: Floats, p: Floats, f: Floats) -> tuple[Floats, Floats]:
        """A u + Dᵀ p − f and D u − C p."""
        D = self.space.divergence
        return self.stiffness @ u + D.T @ p - f, D @ u - self.space.compressed(p)

    def _residuals(self, u: Floats, p: Floats, f: Floats) -> Residuals:
        """Residuals of both equations; the energy is uᵀAu + pᵀCp, that of shear and of compression.

        The imbalance is computed with the pressure that follows from u, the projection of λ ∇·u. Computed
        with p it could hide an error in a part that is far stiffer than the rest, where u is almost rigid.
        """
        first, second = self._imbalance(u, p, f)
        D, compressed = abs(self.space.divergence), self.space.compressed(p)
        most_u, most_p, most_f = (np.abs(field).max(axis=0) for field in (u, p, f))
        forces = self.stiffness.norm() * most_u + D.sum(axis=0).max() * most_p + most_f
        widths = D.sum(axis=1).max() * most_u + np.abs(compressed).max(axis=0)
        work = (u * f).sum(axis=0)
        energy = (u * (self.stiffness @ u)).sum(axis=0) + (p * compressed).sum(axis=0)
        left = np.abs(first[~self.fixed]).max(axis=0)
        untied = self.space.divergence[self.alive].T @ self._constraint.decompressed(second[self.alive])
        unbalanced = np.abs((first + untied)[~self.fixed]).max(axis=0)
        return Residuals(
            max(
                worst_ratio(left, forces),
                worst_ratio(np.abs(second[self.alive]).max(axis=0, initial=0.0), widths),
            ),
            worst_ratio(np.abs(energy - work), np.abs(work)),
            0.0,
            worst_ratio(unbalanced, most_f),
        )

    def reactions(self, u: Floats, p: Floats, f: Floats) -> Floats:
        """Forces (3 n_nodes, n_cases) of the supports, N."""
        return self._imbalance(u, p, f)[0]
