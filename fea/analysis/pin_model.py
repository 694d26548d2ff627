"""How far the answer depends on how the pins press on the bores."""

from collections.abc import Sequence

import numpy as np

from fea.analysis.figures import PinModelFigures
from fea.analysis.prepare import PreparedRod
from fea.analysis.solve import PinModel
from fea.assess.safety import CAP
from fea.choices import CONTACT
from fea.rod.case_forces import NodalForces
from fea.stress.singular import masked_nodes
from fea.stress.stress import von_mises
from geometry.arrays import Mask
from loads.bearing import BorePressure
from loads.cases import LoadCase

# The two that are in use: for a pin with little clearance, and for one with much.
_OTHERS = ("cosine-180", "uniform-120")


def pin_model_figures(
    first: PreparedRod | None, last: PreparedRod, cases: Sequence[LoadCase], asked: float
) -> PinModelFigures | None:
    """Compare the smallest safety factor with that under another pressure, and with contact if they differ.

    Parameters
    ----------
    first, last
        The rod on the first, coarse mesh, where there are several, and on the last. The ratios of safety
        factors are those of the first, as errors of the mesh affect all of them alike; contact is looked at
        only there, where it costs little.
    cases
        Load cases.
    asked
        The smallest safety factor on the last mesh under the pressure that was asked for.

    Returns
    -------
    PinModelFigures or None
        None where the pins are in contact already.
    """
    rod = first or last
    if rod.options.in_contact:
        return None
    with rod.clock("pin model"):
        name = next(other for other in _OTHERS if other != rod.options.pressure)
        pressure = BorePressure.parse(name)
        forces = NodalForces(rod.mesh.cell, rod.mesh.bores, rod.inertia, pressure, rod.options.support)
        counts = ~rod.fields.errors.masked[rod.mesh.mirrored.source]
        known = first is None and asked < CAP  # on the only mesh there is
        scale = asked / (asked if known else _least(rod, rod.pins, cases, counts))
        factors = {rod.options.pressure: asked}
        factors[name] = scale * _least(rod, PinModel(forces, rod.model), cases, counts)
        found = PinModelFigures(min_safety_factors=factors)
        if first is None or not found.matters or rod.without_contact:
            return found
        near = masked_nodes(rod.mesh.cell, rod.fits.sharp)[rod.mesh.mirrored.source]
        factors[CONTACT] = scale * _least(rod, PinModel(rod.contact, rod.model), cases, counts & ~near)
    return PinModelFigures(min_safety_factors=factors)


def _least(rod: PreparedRod, pins: PinModel, cases: Sequence[LoadCase], counts: Mask) -> float:
    """The smallest safety factor of all cases at the nodes (n_nodes,) that count, or at all if none does."""
    stresses = rod.fields.stresses(pins.equilibrium(cases))
    chosen = counts if counts.any() else slice(None)
    return min(
        material.yield_strength / float(np.nanmax(von_mises(np.moveaxis(stress[chosen], 1, -1))))
        for material, stress in zip(rod.materials, stresses, strict=True)
    )
