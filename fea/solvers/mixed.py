"""Displacement and pressure of rods with nearly incompressible parts: Taylor–Hood elements (1973).

Second-order displacement with a separate linear pressure neither locks nor has an oscillating mean stress, at
any Poisson's ratio. The displacement part contains only 2 μ ε, so that the factorised matrix is as well
conditioned as that of steel; the other parts keep their ordinary stiffness.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from fea.choices import Assembly, SolverName, Support
from fea.machine.clock import Clock
from fea.material import Material, of_parts
from fea.solid.errors import StagnationError
from fea.solid.parity import Parity, Split
from fea.solid.supports import plane_conditions
from fea.solvers.condition import condition_of, probe
from fea.solvers.linear.choice import Preconditioner
from fea.solvers.mixed_system import MixedSystem, shear_materials
from fea.solvers.pressure import pressure_space
from fea.solvers.residuals import Residuals
from fea.solvers.static import Model, Solution, right_hand_sides
from geometry.arrays import Floats, Mask
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh


class MixedModel(Model):
    """A meshed cell of which some parts have a pressure field.

    Parameters
    ----------
    mesh
        The meshed cell, of second order.
    materials
        One per part.
    soft
        Numbers of the parts that get a pressure.
    support, solver, clock, assembly
        As for `Model`; the matrices of the pressure are always batched.
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
        assembly: Assembly = Assembly.BATCHED,
    ) -> None:
        shear = shear_materials(materials, soft)
        elastic = of_parts(shear, mesh.part)
        super().__init__(mesh, elastic, support, solver, clock, assembly=assembly)
        with self._clock("assembly"):
            self._space = pressure_space(mesh, {number: materials[number] for number in soft})

    @property
    def solved_dofs(self) -> int:
        """Degrees of freedom over the parities factorised so far, including the pressures."""
        return super().solved_dofs + sum(int(self._alive(parity).sum()) for parity in self._factorised)

    def solve(self, loads: Sequence[Split]) -> Solution:
        """Displacements and pressures of the cell under each load.

        Raises
        ------
        UnderconstrainedError, SingularMatrixError
            See `Model.solve`.
        StagnationError
            The mesh does not allow a stable pressure.
        """
        displacement, residuals, pressure = {}, {}, {}
        n_nodes = len(self.mesh.points)
        for parity, f in right_hand_sides(loads).items():
            slot = self._slot(parity)
            with self._clock("solve"):
                self._estimate_condition(parity, slot)
                system = MixedSystem(self._K, self._space, self._fixed(parity), self._alive(parity))
                u, p, found = self._settled(system, slot, f)
                held = self._held[parity] & ~plane_conditions(self.mesh, parity).ravel()
                reaction = float(np.abs(system.reactions(u, p, f)[held]).max(initial=0.0))
            displacement[parity] = u.reshape(n_nodes, 3, -1)
            pressure[parity] = self._space.nodal(p, n_nodes)
            residuals[parity] = replace(found, reaction=reaction)
        return Solution(displacement, residuals, pressure, dict(self._condition))

    def _settled(self, system: MixedSystem, slot: int, f: Floats) -> tuple[Floats, Floats, Residuals]:
        """Displacements and pressures; if the iterative solver stagnates, by the direct one if it fits."""
        if isinstance(self._solver, Preconditioner):
            try:
                return system.iterate(partial(self._solver.precondition, slot), f)
            except StagnationError as error:
                self._hand_over(error)
        return system.solve(partial(self._solved, slot), f)

    def _estimate_condition(self, parity: Parity, slot: int) -> None:
        """Estimate the condition number of the factorised matrix, at the cost of one more solution."""
        if parity not in self._condition:
            softest = np.where(self._fixed(parity)[:, None], 0.0, probe(self._K))
            self._condition[parity] = condition_of(self._K, self._solved(slot, softest), softest)

    def _alive(self, parity: Parity) -> Mask:
        """Pressures that are not zero by symmetry; an antisymmetric pressure is zero on y = 0."""
        vertex = np.concatenate(self._space.vertex)
        if parity is Parity.SYMMETRIC or Surface.SYMMETRY_Y not in self.mesh.facets:
            return np.ones(vertex.size, dtype=bool)
        return ~np.isin(vertex, self.mesh.facets[Surface.SYMMETRY_Y])
