"""The data of an animation: the rod at instants of the crank cycle."""

import math
from pathlib import Path

import numpy as np

from fea.analysis.prepare import PreparedRod
from fea.cycle.unit_loads import Weights
from fea.machine.clock import Clock
from fea.output.errors import PictureError
from fea.output.pictures.animation import Frames, film
from fea.output.pictures.skin import Skin
from fea.stress.stress import von_mises
from fea.units import RPM
from geometry.arrays import Floats

COUNT = 72  # frames of a cycle: one every 10°
# Instants computed together: each takes 72 bytes per node of the whole rod.
BLOCK = 12


def filmed(rod: PreparedRod, rpm: float, path: Path, clock: Clock) -> tuple[bytes, str]:
    """Return the content of the file of an animation, or the reason why it could not be drawn."""
    try:
        with clock("animation"):
            return film(frames(rod, rpm), path.suffix), ""
    except PictureError as error:
        return b"", str(error)


def frames(rod: PreparedRod, rpm: float) -> Frames:
    """Compute the frames of an animation at a speed: displacement by solving, stress by superposition."""
    engine, gas, mesh = rod.engine.engine, rod.engine.gas, rod.mesh.whole
    angles = np.arange(COUNT) * 4 * math.pi / COUNT
    outer = Skin.of(mesh.points, mesh.tets)
    nodes, facets = np.unique(outer.facets, return_inverse=True)
    displacement = np.empty((COUNT, len(nodes), 3), np.float32)
    stress = np.empty((COUNT, len(nodes)), np.float32)
    weights = rod.cycle.weights(engine, gas, rpm * RPM, angles)
    for start in range(0, COUNT, BLOCK):
        block = slice(start, start + BLOCK)
        moved = rod.displacement(rpm, angles[block])[nodes]
        displacement[block] = np.moveaxis(moved, -1, 0)
        stress[block] = _von_mises(rod, weights.at(block))[nodes].T
    return Frames(
        skin=Skin(mesh.points[nodes], facets.reshape(outer.facets.shape)),
        displacement=displacement,
        von_mises=stress,
        crank_angle=angles,
        crank_radius=engine.crank_radius,
        rod_length=engine.rod_length,
        pin_offset=engine.pin_offset,
        title=(rod.name, f"{rpm:g} rpm"),
    )


def _von_mises(rod: PreparedRod, weights: Weights) -> Floats:
    """Von Mises stress (n_nodes, n_instants) of the whole rod; at an interface, the larger one."""
    units, whole = rod.cycle.units, rod.mesh.mirrored
    largest = np.full((len(whole.source), weights.even.shape[1]), -np.inf)
    for number in range(len(units.parts)):
        tensors = units.tensor(number, weights, whole)
        largest = np.fmax(largest, von_mises(np.moveaxis(tensors, 1, -1)))
    return largest
