"""How far the piston comes nearer to the head than at rest: what the gap between them must leave.

At the dead centre of gas exchange nothing but inertia acts: it stretches the rod, opens its bores into ovals,
bends the piston pin and takes up the clearances, so that the piston rises. Warm parts grow; so does the
block, which carries the head away. The gap of the cold and of the warm engine are two sums of the same parts.
"""

import numpy as np

from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.speed_result import SpeedResult
from fea.analysis.summary_figures import HeadClearanceFigures
from fea.contact.elastic_pin import bending
from fea.judge.case_result import CaseResult
from fea.pins.contact import ContactPins
from fea.rod.loading import EngineLoading
from fea.study.material_table import thermal_expansion
from geometry.errors import InvalidValue
from geometry.surfaces import Surface

_TENSION = "tension"
# Half the angle of a bore, from where the pin pulls, over which its displacement is averaged, rad.
_WITHIN = np.radians(15.0)
# Assumed: pin to crown over the bore of the engine; clearance of a main bearing and bending of the crank, mm.
_CROWN, _CRANK = 0.40, 0.05
# Assumed: how much warmer than when it was assembled, K, and the expansion, 1/K, of an aluminium piston, of
# the rod, and of a block of aluminium or of cast iron.
_PISTON, _ROD_RISE, _ALUMINIUM, _IRON = (200.0, 21e-6), 80.0, (70.0, 23e-6), (70.0, 11e-6)
_STEEL = 11.5e-6


def head_clearance(rod: PreparedRod, result: SpeedResult) -> HeadClearanceFigures | None:
    """Sum up what the gap between piston and head must leave at one speed, mm.

    None without an engine, without a case of tension, or where the pins' clearances are not known because
    their pressure is prescribed.
    """
    loading, case, pins = rod.loading, result.cases.get(_TENSION), rod.pins
    if not isinstance(loading, EngineLoading) or case is None or not isinstance(pins, ContactPins):
        return None
    engine, fits = loading.engine, pins.fits
    length, crown = engine.rod_length, _CROWN * engine.bore
    pin = fits.piston_pin
    bent = 0.0 if pin is None else bending(pin, float(case.load.pin_axial))
    clearances = fits.small_clearance + fits.big_clearance
    stretched = stretch(case, length)
    cold = stretched + clearances + bent + _CRANK
    rise, expansion = _PISTON
    of_rod = _rod_expansion(rod) * length * _ROD_RISE
    of_piston = crown * rise * expansion
    grown = of_piston + of_rod
    height = engine.stroke / 2 + length + crown
    aluminium, iron = (height * change * own for change, own in (_ALUMINIUM, _IRON))
    return HeadClearanceFigures(
        rod_stretch_mm=stretched,
        clearances_mm=clearances,
        pin_bending_mm=bent,
        crank_mm=_CRANK,
        cold_mm=cold,
        piston_growth_mm=of_piston,
        rod_growth_mm=of_rod,
        aluminium_block_growth_mm=aluminium,
        iron_block_growth_mm=iron,
        hot_aluminium_block_mm=cold + grown - aluminium,
        hot_iron_block_mm=cold + grown - iron,
        crown_height_mm=crown,
    )


def _rod_expansion(rod: PreparedRod) -> float:
    """Thermal expansion of the rod's material, 1/K; that of steel where it is not known."""
    try:
        return thermal_expansion("material", rod.study.material)[0]
    except InvalidValue:
        return _STEEL


def stretch(case: CaseResult, length: float) -> float:
    """Return by how much the bores move apart where the pins pull, mm: joint and ovality count."""
    ends = ((Surface.BIG_END_BORE, 0.0, -1.0), (Surface.SMALL_END_BORE, length, 1.0))
    cap, crown = (_moved(case, surface, center, side) for surface, center, side in ends)
    return crown - cap


def _moved(case: CaseResult, surface: Surface, center: float, side: float) -> float:
    """Mean displacement along the rod of a bore about where its pin pulls, mm."""
    nodes = np.unique(case.mesh.facets[surface])
    across = case.mesh.points[nodes, :2] - [center, 0.0]
    angle = np.arctan2(across[:, 1], side * across[:, 0])
    near = nodes[np.abs(angle) <= max(_WITHIN, float(np.abs(angle).min()))]
    return float(case.distortion[near, 0].mean())
