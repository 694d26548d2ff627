"""Up to which multiple of its loads a rod that is bowed from the beginning carries, until it bends."""

from collections.abc import Mapping

import numpy as np

from fea.analysis.buckling import compression, shank_material
from fea.analysis.overload_figures import BendingFigures
from fea.analysis.prepared_rod import PreparedRod
from fea.judge.bent_column import BentColumn, Fibres, bent_column
from fea.judge.column import Plane
from fea.study.overload_table import BOW, OverloadTable
from loads.instants import Instants
from mesh.slices import cuts

_SECTIONS = 48  # from pin to pin


def overload_table(rod: PreparedRod) -> OverloadTable:
    """Return what the study says of overloads, or the defaults."""
    return rod.study.overload or OverloadTable()


def bent_columns(rod: PreparedRod, strength: float) -> Mapping[Plane, BentColumn]:
    """Follow the shank as a bowed column of a yield strength, MPa, in both planes, all of its material."""
    bores, mesh, material = rod.mesh.bores, rod.mesh.whole, shank_material(rod)
    ends = np.linspace(0.0, bores.rod_length, _SECTIONS + 1)
    middle = (ends[1:] + ends[:-1]) / 2
    low, high = bores.between
    sections = tuple(cuts(mesh, middle))
    bearing, bow = (low < middle) & (middle < high), overload_table(rod).bow_mm or BOW * bores.rod_length
    law = {"youngs_modulus": material.youngs_modulus, "yield_strength": strength, "bow": bow}
    return {plane: bent_column(plane, ends, Fibres.of(sections, plane), bearing, **law) for plane in Plane}


def weaker(rod: PreparedRod, strength: float) -> BentColumn:
    """Return the column of the plane in which the shank bends first, of a yield strength, MPa."""
    return min(bent_columns(rod, strength).values(), key=lambda column: column.limit)


def weaker_in_turns(rod: PreparedRod) -> BentColumn:
    """Return that column in repeated loading, which may soften the material."""
    return weaker(rod, shank_material(rod).flow_strength)


def bending_figures(rod: PreparedRod, cases: Instants) -> BendingFigures | None:
    """Return when the shank bends in repeated loading by the case that presses most; None if none does."""
    worst = cases[int(compression(cases).argmax())]
    if not (force := float(compression(worst))):
        return None
    return bending(weaker_in_turns(rod), worst.name, force)


def bending(column: BentColumn, case: str, force: float) -> BendingFigures:
    """Return the figures of a column under a load case that presses with a force, N."""
    return BendingFigures(
        case=case,
        force_N=force,
        plane=column.plane.value,
        bow_mm=column.bow,
        strength_MPa=column.strength,
        first_yield_N=column.perry,
        limit_N=column.limit,
    )
