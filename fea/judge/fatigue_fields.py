"""What the load cases tell of fatigue before a cycle is computed, each field with its error."""

import itertools
from collections.abc import Sequence

import numpy as np

from fea.base.choices import Fatigue
from fea.base.material import Material
from fea.judge.case_result import CaseResult
from fea.judge.fatigue import fatigue_factor
from fea.judge.history import deviatoric, signed_equivalent
from fea.rod.surface_regions import SurfaceRegions
from fea.stress.stress import von_mises
from geometry.arrays import Floats
from mesh.tetmesh import TetMesh


def amplitude(cases: Sequence[CaseResult]) -> tuple[Floats, Floats]:
    """Largest amplitude of the von Mises stress between any two cases (n_nodes,), and its error, MPa."""
    pairs = [
        (von_mises(one.stress - other.stress) / 2, (one.von_mises_error + other.von_mises_error) / 2)
        for one, other in itertools.combinations(cases, 2)
    ]
    value, error = pairs[0]
    for other, its_error in pairs[1:]:
        larger = other > value
        value, error = np.where(larger, other, value), np.where(larger, its_error, error)
    return value, error


def usage(
    cases: Sequence[CaseResult],
    mesh: TetMesh,
    materials: Sequence[Material],
    regions: SurfaceRegions,
    criterion: Fatigue,
) -> tuple[Floats, Floats] | None:
    """One over the safety factor against fatigue between the cases (n_nodes,), and its error.

    Mean and amplitude are those of the signed equivalent stress, as over a cycle; `regions` are of the whole
    rod's surface. None where a strength that the criterion needs is not known.
    """
    rows = np.arange(len(mesh.points))
    signed = signed_equivalent(deviatoric(np.stack([case.stress for case in cases], axis=-1)))
    off = np.stack([case.von_mises_error for case in cases], axis=-1)
    highest, lowest = signed.argmax(axis=1), signed.argmin(axis=1)
    mean = (signed[rows, highest] + signed[rows, lowest]) / 2
    half = (signed[rows, highest] - signed[rows, lowest]) / 2
    error = (off[rows, highest] + off[rows, lowest]) / 2
    used, more = np.zeros((2, len(rows)))
    for number, material in enumerate(materials):
        of_part = rows if mesh.part is None else np.unique(mesh.tets[mesh.part == number])
        surface = regions.at(of_part).factors(material)
        at = mean[of_part], half[of_part], error[of_part]
        now = fatigue_factor(criterion, at[0], at[1], material, surface)
        worse = fatigue_factor(criterion, at[0] + at[2], at[1] + at[2], material, surface)
        if now is None or worse is None:
            return None
        own = 1 / now
        larger = own > used[of_part]
        used[of_part[larger]], more[of_part[larger]] = own[larger], (1 / worse - own)[larger]
    return used, more
