"""What a load case does to the rod: fields on the whole rod and their extremes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fea.assess.safety import element_largest, safety_factor
from fea.material import Material
from fea.solid.stress import principal, von_mises
from loads.cases import LoadCase
from mesh.tetmesh import Floats, TetMesh


@dataclass(frozen=True)
class CaseResult:
    """Fields of one load case on the whole rod.

    Attributes
    ----------
    case
        What acts.
    displacement
        (n_nodes, 3), mm, seen from the bores.
    stress
        (n_nodes, 6), MPa, components XX YY ZZ XY YZ XZ.
    von_mises
        (n_nodes,), MPa.
    principal
        (n_nodes, 3), MPa, largest first.
    safety_factor
        (n_nodes,) against yielding.
    part_von_mises
        Per part (n_nodes,), MPa, NaN where it has no node. Where parts meet the fields above are those
        of the part that is nearer to yielding.
    """

    case: LoadCase
    displacement: Floats
    stress: Floats
    von_mises: Floats
    principal: Floats
    safety_factor: Floats
    part_von_mises: tuple[Floats, ...]

    @property
    def finite(self) -> bool:
        """Whether every number is one."""
        return bool(np.isfinite(self.stress).all() and np.isfinite(self.displacement).all())

    def point_data(self) -> dict[str, npt.NDArray[np.float64]]:
        """Arrays at the nodes, by their names in the VTU file."""
        return {
            "displacement": self.displacement,
            "stress": self.stress,
            "von_mises": self.von_mises,
            "principal_1": self.principal[:, 0],
            "principal_2": self.principal[:, 1],
            "principal_3": self.principal[:, 2],
            "safety_factor": self.safety_factor,
        }

    def cell_data(self, mesh: TetMesh, materials: Sequence[Material]) -> dict[str, npt.NDArray[np.float64]]:
        """Arrays of the elements, by their names in the VTU file: the worst node of each counts."""
        largest, factor = np.empty((2, len(mesh.tets)))
        for number, (equivalent, material) in enumerate(zip(self.part_von_mises, materials, strict=True)):
            own = slice(None) if mesh.part is None else mesh.part == number
            largest[own] = element_largest(equivalent, mesh.tets[own])
            factor[own] = safety_factor(largest[own], material.yield_strength)
        return {"von_mises": largest, "safety_factor": factor}

    def extremes(self, mesh: TetMesh) -> dict[str, object]:
        """The figures of the summary."""
        hottest = int(self.von_mises.argmax())
        return {
            "max_von_mises_MPa": float(self.von_mises[hottest]),
            "at_mm": mesh.points[hottest].tolist(),
            "max_principal_MPa": float(self.principal[:, 0].max()),
            "min_principal_MPa": float(self.principal[:, 2].min()),
            "max_displacement_mm": float(np.linalg.norm(self.displacement, axis=1).max()),
            "min_safety_factor": float(self.safety_factor.min()),
        }


def case_result(
    case: LoadCase, displacement: Floats, stresses: Sequence[Floats], materials: Sequence[Material]
) -> CaseResult:
    """Judge displacement (n_nodes, 3) and each part's stress (n_nodes, 6) of a case."""
    equivalents = tuple(von_mises(stress) for stress in stresses)
    factors = [
        safety_factor(equivalent, material.yield_strength)
        for equivalent, material in zip(equivalents, materials, strict=True)
    ]
    stress, equivalent, factor = stresses[0], equivalents[0], factors[0]
    for other, its_equivalent, its_factor in zip(stresses[1:], equivalents[1:], factors[1:], strict=True):
        worse = np.isnan(factor) | (its_factor < factor)
        stress = np.where(worse[:, None], other, stress)
        equivalent = np.where(worse, its_equivalent, equivalent)
        factor = np.where(worse, its_factor, factor)
    return CaseResult(case, displacement, stress, equivalent, principal(stress), factor, equivalents)
