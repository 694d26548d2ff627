"""What a load case does to the rod: fields on the whole rod and their extremes."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from fea.assess.case_error import CaseError
from fea.assess.safety import CAP, element_largest, safety_factor
from fea.assess.verdict import Peak, Verdict, peak
from fea.material import Material
from fea.stress.stress import principal, von_mises
from geometry.arrays import Floats
from loads.cases import LoadCase
from mesh.tetmesh import TetMesh


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
    error
        What may be wrong with them.
    von_mises_error
        (n_nodes,) estimated error of `von_mises`, MPa.
    """

    case: LoadCase
    displacement: Floats
    stress: Floats
    von_mises: Floats
    principal: Floats
    safety_factor: Floats
    part_von_mises: tuple[Floats, ...]
    error: CaseError
    von_mises_error: Floats

    @property
    def finite(self) -> bool:
        """Whether every number is one."""
        return bool(np.isfinite(self.stress).all() and np.isfinite(self.displacement).all())

    @property
    def displacement_size(self) -> float:
        """The largest displacement, mm."""
        return float(np.linalg.norm(self.displacement, axis=1).max())

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

    def cell_data(self, mesh: TetMesh, materials: Sequence[Material]) -> dict[str, npt.NDArray[Any]]:
        """Arrays of the elements, by their names in the VTU file: the worst node of each counts."""
        largest, factor = np.empty((2, len(mesh.tets)))
        for number, (equivalent, material) in enumerate(zip(self.part_von_mises, materials, strict=True)):
            own = slice(None) if mesh.part is None else mesh.part == number
            largest[own] = element_largest(equivalent, mesh.tets[own])
            factor[own] = safety_factor(largest[own], material.yield_strength)
        found = {"von_mises": largest, "safety_factor": factor, "error_percent": self.error.element_percent}
        return found if mesh.part is None else found | {"part": mesh.part.astype(np.uint8)}

    @property
    def judged(self) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
        """Von Mises stress, and utilisation (one over the safety factor), each (n_nodes,) with its error."""
        utilisation = 1 / self.safety_factor
        free = self.safety_factor < CAP  # where the factor is capped it says nothing of the stress
        ratio = np.divide(utilisation, self.von_mises, out=np.zeros_like(utilisation), where=free)
        return (self.von_mises, self.von_mises_error), (utilisation, self.von_mises_error * ratio)

    @cached_property
    def peak(self) -> Peak:
        """The largest von Mises stress, MPa."""
        return peak(*self.judged[0], self.error.masked)

    @cached_property
    def worst(self) -> Peak:
        """The largest utilisation."""
        return peak(*self.judged[1], self.error.masked)

    @property
    def error_percent(self) -> float:
        """Bar of the largest von Mises stress or of the least safety factor, whichever is larger."""
        return max(self.peak.error_percent, self.worst.error_percent)

    def verdict(self, tolerance_percent: float | None = None) -> Verdict:
        """The worse verdict on the largest von Mises stress and the least safety factor."""
        severity = list(Verdict)
        return max(
            (found.verdict(tolerance_percent) for found in (self.peak, self.worst)), key=severity.index
        )

    def extremes(self, mesh: TetMesh, tolerance_percent: float | None = None) -> dict[str, object]:
        """The figures of the summary, over the nodes that are not near a singular place."""
        hottest, worst, masked = self.peak, self.worst, self.error.masked
        counts = ~masked if not masked.all() else masked
        unmasked = {
            "unmasked_max_von_mises_MPa": hottest.unmasked,
            "unmasked_min_safety_factor": 1 / worst.unmasked,
            "unmasked_verdict": Verdict.DIVERGING.value,
            "singular_max_von_mises_MPa": hottest.singular,
            "singular_verdict": Verdict.DIVERGING.value,
        }
        return {
            "max_von_mises_MPa": hottest.value,
            "at_mm": mesh.points[hottest.node].tolist(),
            "max_principal_MPa": float(self.principal[counts, 0].max()),
            "min_principal_MPa": float(self.principal[counts, 2].min()),
            "max_displacement_mm": self.displacement_size,
            "min_safety_factor": 1 / worst.value,
            "error_percent": self.error_percent,
            "energy_error_percent": self.error.energy_percent,
            "verdict": self.verdict(tolerance_percent).value,
        } | (unmasked if masked.any() else {})


def case_result(
    case: LoadCase,
    displacement: Floats,
    stresses: Sequence[Floats],
    materials: Sequence[Material],
    error: CaseError,
) -> CaseResult:
    """Judge displacement (n_nodes, 3) and each part's stress (n_nodes, 6) of a case."""
    equivalents = tuple(von_mises(stress) for stress in stresses)
    factors = [
        safety_factor(equivalent, material.yield_strength)
        for equivalent, material in zip(equivalents, materials, strict=True)
    ]
    stress, equivalent, factor, off = stresses[0], equivalents[0], factors[0], error.part_von_mises[0]
    others = zip(stresses[1:], equivalents[1:], factors[1:], error.part_von_mises[1:], strict=True)
    for its_stress, its_equivalent, its_factor, its_error in others:
        worse = np.isnan(factor) | (its_factor < factor)
        stress = np.where(worse[:, None], its_stress, stress)
        equivalent = np.where(worse, its_equivalent, equivalent)
        off = np.where(worse, its_error, off)
        factor = np.where(worse, its_factor, factor)
    return CaseResult(
        case=case,
        displacement=displacement,
        stress=stress,
        von_mises=equivalent,
        principal=principal(stress),
        safety_factor=factor,
        part_von_mises=equivalents,
        error=error,
        von_mises_error=off,
    )
