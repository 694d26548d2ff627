"""Displacement and pressure of rods with nearly incompressible parts: Taylor–Hood elements (1973).

Second-order displacement with a separate linear pressure neither locks nor has an oscillating mean stress, at
any Poisson's ratio. The displacement part contains only 2 μ ε, so that the factorised matrix is as well
conditioned as that of steel; the other parts keep their ordinary stiffness. The pressure is linear in each
element and continuous within each part, positive in tension: σ = 2 μ ε + p I, with p = λ ∇·u on average over
the elements of a vertex.

The equations A u + Dᵀ p = f, D u − C p = g are symmetric but indefinite. Their Schur complement
S = D A⁻¹ Dᵀ + C is positive definite. As A does not contain λ, and if the elements are stable, a mass matrix
over the shear modulus is spectrally equivalent to S for every mesh size and Poisson's ratio. Conjugate
gradients need about twenty steps, each with one solution with A, by its factor or by multigrid (Verfürth
1984; Benzi, Golub & Liesen 2005, sections 5 and 10.1).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from scipy import sparse

from fea.base.choices import MatrixAssembly, SolverName, Support
from fea.base.material import Material, of_parts
from fea.machine.clock import Clock
from fea.solid.assembly import (
    SymmetricMatrix,
    gauss_blocks,
    gauss_places,
    linear_interpolation,
    shape_functions,
    stiffness_degree,
)
from fea.solid.parity import Parity, ParityPair
from fea.solvers.direct import Operator
from fea.solvers.iterative import chebyshev, conjugate_gradients
from fea.solvers.residuals import Residuals, condition_of, probe, refined, worst_ratio
from fea.solvers.static import Model, StaticSolution, right_hand_sides
from geometry.arrays import Floats, Ints, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# Of the residual, in the norm of the preconditioner. Iterative refinement then improves the solution.
TOLERANCE = 1e-7
_REMEDY = (
    "Use a smaller --size, so that the nearly incompressible part has at least two elements through its "
    "thickness"
)
# Eigenvalue bounds of the Jacobi-scaled mass matrix of linear tetrahedra (Wathen 1987), and the number of
# Chebyshev steps that reduce its condition number from 5 to 1.02.
_MASS_BOUNDS = (0.5, 2.5)
_MASS_STEPS = 5


@dataclass(frozen=True)
class Constraint:
    """The matrices that couple displacement and pressure."""

    #: D (n_pressures, n_displacements), without the columns of constrained displacements
    divergence: sparse.csr_array
    mass: sparse.csr_array  #: M (n_pressures, n_pressures)
    compliance: Floats  #: (n_pressures,) 1/λ: C = compliance · M; constant among coupled pressures
    scale: Floats  #: (n_pressures,) 1/(2 μ) + 1/λ: scale · M preconditions S

    def compressed(self, p: Floats) -> Floats:
        """C p."""
        return np.asarray(self.compliance[:, None] * (self.mass @ p))

    def precondition(self, residual: Floats) -> Floats:
        """Approximate (scale · M)⁻¹."""
        return np.asarray(self.over_mass(residual) / self.scale[:, None])

    def over_mass(self, right: Floats) -> Floats:
        """M⁻¹ by a fixed number of Chebyshev steps (Wathen & Rees 2009)."""
        return chebyshev(self.mass.__matmul__, self.mass.diagonal(), right, _MASS_BOUNDS, _MASS_STEPS)


def solve_saddle(solve: Operator, constraint: Constraint, f: Floats, g: Floats) -> tuple[Floats, Floats]:
    """Solve A u + Dᵀ p = f, D u − C p = g with a factor of A, to the accuracy `TOLERANCE`.

    f (n_displacements, n_cases) is zero at constrained displacements; g is (n_pressures, n_cases). Raises
    `StagnationError`: the iteration does not converge: the mesh does not allow a stable pressure.
    """
    D = constraint.divergence

    def schur(p: Floats) -> Floats:
        return np.asarray(D @ solve(D.T @ p) + constraint.compressed(p))

    right = D @ solve(f) - g
    p = conjugate_gradients(schur, constraint.precondition, right, tolerance=TOLERANCE, remedy=_REMEDY)
    return solve(f - D.T @ p), p


_VERTICES = 4


@dataclass(frozen=True)
class PressureSpace:
    """The unknowns of the pressure and their matrices."""

    parts: tuple[int, ...]  #: numbers of the parts that have a pressure
    #: Per such part (n,) the node of the mesh that each of its unknowns belongs to; the unknowns of the parts
    #: are numbered consecutively
    vertex: tuple[Ints, ...]
    interpolation: tuple[sparse.csr_array, ...]  #: per such part (n_points, n) nodal values of its unknowns
    divergence: sparse.csr_array  #: D (n_unknowns, 3 n_nodes): ∫ q ∇·u dV = qᵀ D u, mm²
    #: M (n_unknowns, n_unknowns): ∫ q p dV = qᵀ M p, mm³; different parts are not coupled
    mass: sparse.csr_array
    #: lame_lambda, shear_modulus: (n_unknowns,) λ and μ of the unknown's part, MPa
    lame_lambda: Floats
    shear_modulus: Floats

    def compressed(self, pressure: Floats) -> Floats:
        """∫ q p / λ dV, (n_unknowns, n_cases), mm³, of pressures (n_unknowns, n_cases)."""
        return np.asarray((self.mass @ pressure) / self.lame_lambda[:, None])

    def nodal(self, pressure: Floats) -> dict[int, Floats]:
        """Pressure (n_points, n_cases) of each part that has one, from unknowns (n_unknowns, n_cases), MPa.

        At mid-edge nodes it is the mean of the ends; at nodes outside the part it is zero.
        """
        bounds = np.cumsum([nodes.size for nodes in self.vertex])[:-1]
        of_parts = zip(self.parts, self.interpolation, np.split(pressure, bounds), strict=True)
        return {number: np.asarray(weights @ values) for number, weights, values in of_parts}


def pressure_space(mesh: TetMesh, materials: dict[int, Material]) -> PressureSpace:
    """Number and integrate the pressure of parts of a mesh of second order, given by number with material."""
    number_of = np.zeros(len(mesh.tets), dtype=np.int64) if mesh.part is None else mesh.part
    parts = tuple(materials)
    tets = tuple(mesh.tets[number_of == number] for number in parts)
    vertex, interpolation = zip(*(linear_interpolation(part, len(mesh.points)) for part in tets), strict=True)
    sizes = [nodes.size for nodes in vertex]
    of_parts = zip(np.r_[0, np.cumsum(sizes)], vertex, tets, strict=False)
    rows = [first + np.searchsorted(nodes, part[:, :_VERTICES]) for first, nodes, part in of_parts]
    unknowns = np.concatenate(rows)
    soft, size = TetMesh(mesh.points, np.concatenate(tets)), sum(sizes)
    n_elements, n_nodes = soft.tets.shape
    values, _ = shape_functions(_VERTICES, gauss_places(n_nodes).T)
    squares = values[:, :, None] * values[:, None, :]
    divergence = np.empty((n_elements, _VERTICES, 3 * n_nodes))
    mass = np.empty((n_elements, _VERTICES, _VERTICES))
    for block, gauss in gauss_blocks(soft, stiffness_degree(n_nodes)):
        weighted = (gauss.gradients * gauss.volumes[:, :, None, None]).reshape(-1, len(values), 3 * n_nodes)
        divergence[block] = values.T @ weighted
        mass[block] = np.tensordot(gauss.volumes, squares, axes=1)
    columns = (3 * soft.tets[:, :, None] + np.arange(3)).reshape(n_elements, -1)
    constants = [(m.lame_lambda, m.shear_modulus) for m in materials.values()]
    lam, mu = np.repeat(np.array(constants), sizes, axis=0).T
    return PressureSpace(
        parts=parts,
        vertex=vertex,
        interpolation=interpolation,
        divergence=_summed(divergence, unknowns, columns, (size, 3 * len(mesh.points))),
        mass=_summed(mass, unknowns, unknowns, (size, size)),
        lame_lambda=lam,
        shear_modulus=mu,
    )


def _summed(values: Floats, rows: Ints, columns: Ints, shape: tuple[int, int]) -> sparse.csr_array:
    row = np.broadcast_to(rows[:, :, None], values.shape).ravel()
    column = np.broadcast_to(columns[:, None, :], values.shape).ravel()
    return sparse.csr_array(sparse.coo_array((values.ravel(), (row, column)), shape=shape))


@dataclass(frozen=True)
class MixedSystem:
    """The equations A u + Dᵀ p = f, D u − C p = 0 with their supports."""

    stiffness: SymmetricMatrix  #: A, N/mm, of the soft parts only with 2 μ ε
    space: PressureSpace  #: gives D, and C, which is the mass matrix over λ
    fixed: Mask  #: (3 n_nodes,) displacements that are zero
    alive: Mask  #: (n_pressures,) pressures that are not zero by symmetry

    def solve(self, inverse: Operator, f: Floats) -> tuple[Floats, Floats, Residuals]:
        """Displacements and pressures of forces (3 n_nodes, n_cases), N, refined as long as that helps.

        `inverse` solves with A including its supports. Raises `StagnationError`: no stable pressure.
        """
        held = self.fixed[:, None]

        def free(forces: Floats) -> Floats:
            return np.where(held, 0.0, inverse(np.where(held, 0.0, forces)))

        def corrected(both: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
            first, second = self.imbalance(*both, f)
            right = np.where(held, 0.0, -first), -second[self.alive]
            du, dp = solve_saddle(free, self._constraint, *right)
            u, p = both[0] + du, both[1].copy()
            p[self.alive] += dp
            return u, p

        nothing = np.zeros_like(f), np.zeros((len(self.alive), f.shape[1]))
        (u, p), checked = refined(corrected(nothing), corrected, lambda both: self._residuals(*both, f))
        return u, p, checked

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

    def imbalance(self, u: Floats, p: Floats, f: Floats) -> tuple[Floats, Floats]:
        """A u + Dᵀ p − f, which includes the forces of the supports, N, and D u − C p, mm³."""
        D = self.space.divergence
        return self.stiffness @ u + D.T @ p - f, D @ u - self.space.compressed(p)

    def _residuals(self, u: Floats, p: Floats, f: Floats) -> Residuals:
        """Residuals of both equations; the energy is uᵀAu + pᵀCp, that of shear and of compression.

        The imbalance is computed with the pressure that follows from u, the projection of λ ∇·u. Computed
        with p it could hide an error in a part that is far stiffer than the rest, where u is almost rigid.
        """
        first, second = self.imbalance(u, p, f)
        D, compressed = abs(self.space.divergence), self.space.compressed(p)
        most_u, most_p, most_f = (np.abs(field).max(axis=0) for field in (u, p, f))
        forces = self.stiffness.norm() * most_u + D.sum(axis=0).max() * most_p + most_f
        widths = D.sum(axis=1).max() * most_u + np.abs(compressed).max(axis=0)
        work = (u * f).sum(axis=0)
        energy = (u * (self.stiffness @ u)).sum(axis=0) + (p * compressed).sum(axis=0)
        of_forces = np.abs(first[~self.fixed]).max(axis=0)
        # C⁻¹ times the residual of D u = C p, approximately: the pressures that cause it.
        cause = self._constraint.over_mass(second[self.alive]) / self._constraint.compliance[:, None]
        untied = self.space.divergence[self.alive].T @ cause
        unbalanced = np.abs((first + untied)[~self.fixed]).max(axis=0)
        of_widths = np.abs(second[self.alive]).max(axis=0, initial=0.0)
        return Residuals(
            max(worst_ratio(of_forces, forces), worst_ratio(of_widths, widths)),
            worst_ratio(np.abs(energy - work), np.abs(work)),
            0.0,
            worst_ratio(unbalanced, most_f),
        )


class MixedModel(Model):
    """A meshed cell of second order, of which the `soft` parts have a pressure field.

    There is one material per part; the rest is as for `Model`.
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
        assembly: MatrixAssembly = MatrixAssembly.BATCHED,
    ) -> None:
        shearing = tuple(m.without_lambda() if n in soft else m for n, m in enumerate(materials))
        elastic = of_parts(shearing, mesh.part)
        super().__init__(mesh, elastic, support, solver, clock, assembly=assembly)
        with self._clock("assembly"):
            self._space = pressure_space(mesh, {number: materials[number] for number in soft})

    @property
    def solved_dofs(self) -> int:
        """Degrees of freedom over the parities factorised so far, including the pressures."""
        return super().solved_dofs + sum(int(self._alive(parity).sum()) for parity in self._factorised)

    def solve(self, loads: Sequence[ParityPair]) -> StaticSolution:
        """Solve as `Model.solve`, also for pressures; `StagnationError`: the mesh has no stable pressure."""
        pressure = {}

        def mixed(parity: Parity, slot: int, f: Floats) -> tuple[Floats, Residuals]:
            fixed = self._fixed(parity)
            if parity not in self._condition:  # at the cost of one more solution
                softest = np.where(fixed[:, None], 0.0, probe(self._K))
                self._condition[parity] = condition_of(self._K, self._solved(slot, softest), softest)
            system = MixedSystem(self._K, self._space, fixed, self._alive(parity))
            u, p, checked = system.solve(partial(self._solved, slot), f)
            pressure[parity] = self._space.nodal(p)
            restraints = self._restraints_off_planes(parity)
            reaction = float(np.abs(system.imbalance(u, p, f)[0][restraints]).max(initial=0.0))
            return u, replace(checked, reaction=reaction)

        return replace(self._solution(right_hand_sides(loads), mixed), pressure=pressure)

    def _alive(self, parity: Parity) -> Mask:
        """Pressures that are not zero by symmetry; an antisymmetric pressure is zero on y = 0."""
        vertex = np.concatenate(self._space.vertex)
        if parity is Parity.SYMMETRIC or Surface.SYMMETRY_Y not in self.mesh.facets:
            return np.ones(vertex.size, dtype=bool)
        return ~np.isin(vertex, self.mesh.facets[Surface.SYMMETRY_Y])
