"""How far the answer depends on how the pins press on the bores."""

import numpy as np

from fea.analysis.figures import PinModelFigures
from fea.analysis.prepare import PreparedRod
from fea.base.choices import CONTACT
from fea.judge.verdict import CAP
from fea.pins.model import PinModel
from fea.stress.singular import masked_nodes
from fea.stress.stress import von_mises
from fea.study.pin_models import pin_model
from geometry.arrays import Mask
from loads.instants import Instants

# Smallest safety factors by the name of the pressure on the bores.
Factors = dict[str, float]
# The two that are in use: for a pin with little clearance, and for one with much.
_OTHERS = ("cosine-180", "uniform-120")


def least_factors(rod: PreparedRod, cases: Instants, known: float | None = None) -> Factors | None:
    """Compute the smallest safety factor under the pressure asked for and under another one, by its name.

    A coarse mesh of the rod, where there is one, shows the ratios just as well: its errors affect all alike.
    Contact is looked at too if they differ, unless the factor under the pressure asked for is `known`.

    Returns None where the pins are in contact already.
    """
    if pin_model(rod.options.pressure).in_contact:
        return None
    with rod.clock("pin model"):
        asked = rod.options.pressure
        name = next(other for other in _OTHERS if other != asked)
        counts = ~rod.fields.errors.masked[rod.mesh.mirrored.source]
        own = _least(rod, rod.pins, cases, counts) if known is None else known
        factors = {asked: own, name: _least(rod, rod.structure.pins(name), cases, counts)}
        if known is not None or not PinModelFigures(min_safety_factors=factors).matters:
            return factors
        contact, mesh = rod.structure.pins(CONTACT), rod.mesh
        if contact.excluded_because:
            return factors
        near = masked_nodes(mesh.cell, contact.singular_surfaces, mesh.cell_creases)[mesh.mirrored.source]
        return factors | {CONTACT: _least(rod, contact, cases, counts & ~near)}


def pin_model_figures(
    coarse: Factors | None, rod: PreparedRod, cases: Instants, asked: float
) -> PinModelFigures | None:
    """Compare the smallest safety factor with that under other pressures.

    `coarse` are the factors on an earlier mesh, where there is one, and `asked` is the smallest safety factor
    under the pressure asked for on the mesh of `rod`, which gives the answer.

    Returns None where the pins are in contact already.
    """
    factors = coarse or least_factors(rod, cases, asked if asked < CAP else None)
    if factors is None:
        return None
    scale = asked / factors[rod.options.pressure]
    return PinModelFigures(min_safety_factors={name: scale * factor for name, factor in factors.items()})


def _least(rod: PreparedRod, pins: PinModel, cases: Instants, counts: Mask) -> float:
    """The smallest safety factor of all cases at the nodes (n_nodes,) that count, or at all if none does."""
    stresses = rod.fields.stresses(rod.equilibrium(cases, pins=pins))
    chosen = counts if counts.any() else slice(None)
    return min(
        material.yield_strength / float(np.nanmax(von_mises(np.moveaxis(stress[chosen], 1, -1))))
        for material, stress in zip(rod.materials, stresses, strict=True)
    )
