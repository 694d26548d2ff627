"""From a solution on the symmetry cell to fields on the whole rod.

This is the only place between solvers and results that knows of parities: what solves hands over the parts
about y = 0, what judges gets the whole rod.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fea.base.choices import Support
from fea.base.material import Material
from fea.contact.assembly_state import SeatFields
from fea.judge.case_error import CaseErrors
from fea.judge.case_result import CaseFields
from fea.pins.model import PinModel, PinModelContext, Response
from fea.rod.meshed_rod import MeshedRod
from fea.solid.parity import Parity
from fea.solid.recovery import PartRecovery
from fea.solid.supports import referred_to_bores
from fea.solvers.static import Model, StaticSolution
from geometry.arrays import Floats
from geometry.surfaces import INTERFACES, Surface
from loads.instants import Instants
from mesh.tetmesh import MirroredMesh


@dataclass(frozen=True)
class Equilibrium:
    """Instants in equilibrium."""

    instants: Instants  #: what acts
    responses: tuple[Response, ...]  #: what the pins make of it
    solution: StaticSolution  #: the displacement, a column per instant


def equilibrium(responses: Sequence[Response], model: Model, instants: Instants) -> Equilibrium:
    """Solve what acts at instants, all with one factorisation per parity; errors as of `Model.solve`."""
    solution = model.solve([response.forces for response in responses])
    shifts = [response.shift for response in responses if response.shift is not None]
    if shifts:
        solution = solution.moved(shifts)
    return Equilibrium(instants, tuple(responses), solution)


# Surfaces of known traction.
_SURFACES = (
    Surface.FREE,
    Surface.BIG_END_BORE,
    Surface.SMALL_END_BORE,
    *(side for sides in INTERFACES for side in sides),
    Surface.BOLT_HEAD,
    Surface.BOLT_THREAD,
)


@dataclass(frozen=True, kw_only=True)
class FieldRecovery:
    """Carries solutions to the whole rod and recovers their stress."""

    mirrored: MirroredMesh  #: the whole rod from the cell
    materials: tuple[Material, ...]  #: one per part
    recovery: PartRecovery  #: nodal stress of each part on the cell
    errors: CaseErrors  #: of that stress
    clamped: bool  #: whether a clamp holds the rod; otherwise displacement is referred to the bores

    @classmethod
    def of(
        cls, structure: PinModelContext, mesh: MeshedRod, pins: PinModel, *, known_traction: bool = True
    ) -> "FieldRecovery":
        """Prepare the recovery for a rod and what loads its bores; see `fea.analysis.pipeline.prepare`."""
        held = (Surface.BIG_END_BORE,) if structure.support is Support.CLAMPED else ()
        known = tuple(surface for surface in _SURFACES if surface not in held) if known_traction else ()
        with structure.clock("stress"):
            return cls(
                mirrored=mesh.mirrored,
                materials=structure.materials,
                recovery=PartRecovery(mesh.cell, known),
                errors=CaseErrors(mesh, structure.materials, held or pins.singular_surfaces),
                clamped=bool(held),
            )

    def displaced(self, solved: Equilibrium) -> Floats:
        """Displacement (n_nodes, 3, n_cases) of the whole rod, mm, with its thermal expansion."""
        growth = [case.growth for case in solved.responses if case.growth is not None]
        return self.displacement(solved.solution.moved(growth) if growth else solved.solution)

    def displacement(self, solution: StaticSolution) -> Floats:
        """Displacement (n_nodes, 3, n_cases) of the whole rod, mm."""
        even, odd = (solution.displacement.get(parity) for parity in Parity)
        displacement = self.mirrored.vector(np.asarray(even), odd)
        if self.clamped:
            return displacement
        return referred_to_bores(self.mirrored.mesh, displacement)

    def _on_cell(self, solved: Equilibrium) -> dict[Parity, list[Floats]]:
        """Stress per parity and part (n_nodes, 6, n_cases) on the cell."""
        stress, solution = {}, solved.solution
        for parity, u in solution.displacement.items():
            traction = {
                surface: np.stack([case.traction[surface].part(parity) for case in solved.responses], axis=-1)
                for surface in solved.responses[0].traction
            }
            pressure = solution.pressure.get(parity)
            stress[parity] = self.recovery.nodal_stress(u, self.materials, parity, traction, pressure)
        return stress

    def _on_whole(self, stress: Mapping[Parity, Sequence[Floats]]) -> list[Floats]:
        """Stress per part (n_nodes, 6, n_cases) on the whole rod."""
        odd = stress.get(Parity.ANTISYMMETRIC)
        return [
            self.mirrored.tensor(even, None if odd is None else odd[number])
            for number, even in enumerate(stress[Parity.SYMMETRIC])
        ]

    def stresses(self, solved: Equilibrium) -> list[Floats]:
        """Recover the stress of every load case: per part (n_nodes, 6, n_cases) on the whole rod."""
        return self._on_whole(self._on_cell(solved))

    def __call__(self, solved: Equilibrium) -> list[tuple[CaseFields, list[Floats]]]:
        """Recover the fields of each load case, and the stress (n_nodes, 6) of each part, NaN outside it."""
        solution, stress = solved.solution, self._on_cell(solved)
        displacement, tensors = self.displaced(solved), self._on_whole(stress)
        errors, cases = self.errors(solution.displacement, stress, solution.pressure), []
        for index, (response, error) in enumerate(zip(solved.responses, errors, strict=True)):
            gap = response.gap
            fields = CaseFields(
                displacement=displacement[..., index],
                error=error,
                seats=self._seats(response),
                gap=None if gap is None else self.mirrored.scalar(gap.symmetric, gap.antisymmetric),
                assembly=response.assembly,
                touch=response.touch,
            )
            cases.append((fields, [tensor[..., index] for tensor in tensors]))
        return cases

    def _seats(self, response: Response) -> dict[Surface, SeatFields]:
        seats = {}
        for surface, pressure in response.pressure.items():
            nodes, traction = np.unique(self.mirrored.mesh.facets[surface]), response.traction[surface]
            here = self.mirrored.at(nodes)
            seats[surface] = SeatFields(
                nodes,
                here.scalar(pressure.symmetric, pressure.antisymmetric),
                here.vector(traction.symmetric, traction.antisymmetric),
            )
        return seats
