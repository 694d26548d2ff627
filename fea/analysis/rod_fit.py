"""Dimensions of a study's rod fitted to mass properties."""

import dataclasses
from collections.abc import Sequence

from fea.study.rod_table import RodTable, dimension_of
from fea.study.study import Study
from fea.units import KG, KG_M2
from geometry.fit import Fit, Targets, fit
from geometry.invalid import require


def fitted(
    study: Study,
    free: Sequence[str],
    mass_kg: float | None,
    center_of_gravity_mm: float | None,
    inertia_kg_m2: float | None,
) -> tuple[RodTable, Fit]:
    """Adjust named dimensions of the study's rod until its mass properties meet the targets.

    Parameters
    ----------
    study
        Gives the rod to start from and the density.
    free
        Keys of the [rod] table that may change.
    mass_kg, center_of_gravity_mm, inertia_kg_m2
        Targets; where all are None, those that the [rod] table gives.

    Returns
    -------
    tuple
        The rod of the study with the dimensions found; mass properties that it gives stay only where they
        are the targets. And how well they are met.

    Raises
    ------
    InvalidValue
        No target, nothing free, a key that is no dimension, or a rod without dimensions.
    """
    rod = study.rod.solid()
    density, *others = (
        part.density for part in study.materials(["rod", "bushing"] if rod.bushing else ["rod"])
    )
    bushing = next(iter(others), None)
    given = study.rod.mass
    if (mass_kg, center_of_gravity_mm, inertia_kg_m2) == (None, None, None):
        remedy = "Say --mass-kg, --center-of-gravity-mm or --inertia-kg-m2, or give them in [rod]."
        require(given is not None, "--fit", list(free), "has no target", remedy)
    own = mass_kg is center_of_gravity_mm is inertia_kg_m2 is None
    if given is not None and own:
        targets = Targets(density, given.mass, given.center[0], given.inertia_z, bushing)
    else:
        targets = Targets(
            density,
            None if mass_kg is None else mass_kg * KG,
            center_of_gravity_mm,
            None if inertia_kg_m2 is None else inertia_kg_m2 * KG_M2,
            bushing,
        )
    found = fit(rod, targets, [dimension_of(key) for key in free])
    table = dataclasses.replace(study.rod, dimensions=found.rod, length=found.rod.length)
    return (table if own else dataclasses.replace(table, mass=None)), found
