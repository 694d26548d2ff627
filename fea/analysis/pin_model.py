"""How far the answer depends on how the pins press on the bores."""

from collections.abc import Sequence

import numpy as np

from fea.analysis.figures import PinModelFigures
from fea.analysis.prepare import PreparedRod
from fea.analysis.solve import PinModel
from fea.analysis.speed import SpeedResult
from fea.choices import CONTACT
from fea.rod.case_forces import NodalForces
from fea.stress.singular import masked_nodes
from fea.stress.stress import von_mises
from geometry.arrays import Mask
from loads.bearing import BorePressure
from loads.cases import LoadCase

# The two that are in use: a pin with much clearance, and one with little.
_OTHERS = ("cosine-180", "uniform-120")
# Relative difference of the smallest safety factor under two prescribed pressures that makes contact worth
# its cost: below it, the place that governs is far from the bores.
_SAME = 0.01


def pin_model_figures(rod: PreparedRod, result: SpeedResult) -> PinModelFigures | None:
    """Compare the smallest safety factor with that under another pressure, and with contact if they differ.

    None where the pins are in contact already.
    """
    if rod.options.in_contact:
        return None
    cases, asked = result.loads.cases, rod.options.pressure
    counts = next(iter(result.cases.values())).counts
    factors = {asked: min(case.min_safety_factor for case in result.cases.values())}
    with rod.clock("pin model"):
        name = next(other for other in _OTHERS if other != asked)
        pressure = BorePressure.parse(name)
        forces = NodalForces(rod.mesh.cell, rod.mesh.bores, rod.inertia, pressure, rod.options.support)
        factors[name] = _least(rod, PinModel(forces, rod.model), cases, counts)
        found = PinModelFigures(min_safety_factors=factors)
        if found.spread <= _SAME or rod.without_contact:
            return found
        near = masked_nodes(rod.mesh.cell, rod.fits.sharp)[rod.mesh.mirrored.source]
        away = counts & ~near if (counts & ~near).any() else counts
        factors[CONTACT] = _least(rod, PinModel(rod.contact, rod.model), cases, away)
    return PinModelFigures(min_safety_factors=factors)


def _least(rod: PreparedRod, pins: PinModel, cases: Sequence[LoadCase], counts: Mask) -> float:
    """The smallest safety factor of all cases at the nodes (n_nodes,) that count."""
    stresses = rod.fields.stresses(pins.equilibrium(cases))
    return min(
        material.yield_strength / float(np.nanmax(von_mises(np.moveaxis(stress[counts], 1, -1))))
        for material, stress in zip(rod.materials, stresses, strict=True)
    )
