"""The rod at instants of the crank cycle, as an animation shows it."""

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt

from fea.analysis.pipeline import Analysis
from fea.cycle.unit_loads import Weights
from fea.machine.clock import Clock
from fea.output.errors import PictureError
from fea.output.pictures.animation import Frames, film
from fea.output.pictures.skin import Skin
from fea.stress.stress import von_mises
from fea.study.study import Study
from fea.units import RPM
from geometry.invalid import require

COUNT = 72  # frames of a cycle: one every 10°
# Instants worked out together: 72 bytes a node of the whole rod each.
BLOCK = 12


def animation_file(study: Study, rpm: float | None) -> Path | None:
    """Where the animation of a speed belongs, None where none is asked for.

    Raises
    ------
    InvalidValue
        It is asked for without the cycle.
    """
    if study.output.animate is None:
        return None
    rule = "needs the crank cycle"
    require(study.analysis.cycle, "--animate", study.output.animate, rule, "Add --cycle.")
    path = study.folder / study.output.animate
    speeds = study.speed.speeds()
    return path if len(speeds) == 1 else path.with_stem(f"{path.stem}-{rpm:g}rpm")


def filmed(analysis: Analysis, rpm: float, path: Path, clock: Clock) -> tuple[bytes, str]:
    """Return the content of an animation's file, or why there is none: figures are kept without it."""
    try:
        with clock("animation"):
            return film(frames(analysis, rpm), path.suffix), ""
    except PictureError as error:
        return b"", str(error)


def frames(analysis: Analysis, rpm: float) -> Frames:
    """Work out what an animation at a speed shows: displacement solved, stress superposed."""
    engine, gas, mesh = analysis.engine, analysis.gas, analysis.mesh.whole.mesh
    if engine is None or gas is None:
        raise ValueError("an animation needs an engine")
    angles = np.arange(COUNT) * 4 * math.pi / COUNT
    outer = Skin.of(mesh.points, mesh.tets)
    nodes, facets = np.unique(outer.facets, return_inverse=True)
    displacement = np.empty((COUNT, len(nodes), 3), np.float32)
    stress = np.empty((COUNT, len(nodes)), np.float32)
    weights = analysis.cycle_analysis.weights(engine, gas, rpm * RPM, angles)
    for start in range(0, COUNT, BLOCK):
        block = slice(start, start + BLOCK)
        moved = analysis.displacement(rpm, angles[block])[nodes]
        displacement[block] = np.moveaxis(moved, -1, 0)
        stress[block] = _von_mises(analysis, weights.at(block))[nodes].T
    return Frames(
        skin=Skin(mesh.points[nodes], facets.reshape(outer.facets.shape)),
        displacement=displacement,
        von_mises=stress,
        crank_angle=angles,
        crank_radius=engine.crank_radius,
        rod_length=engine.rod_length,
        pin_offset=engine.pin_offset,
        title=(analysis.study.name, f"{rpm:g} rpm"),
    )


def _von_mises(analysis: Analysis, weights: Weights) -> npt.NDArray[np.float64]:
    """Von Mises stress (n_nodes, n_instants) of the whole rod; where parts meet, the larger."""
    units, whole = analysis.cycle_analysis.units, analysis.mesh.whole
    largest = np.full((len(whole.source), weights.even.shape[1]), -np.inf)
    for number in range(len(units.parts)):
        tensors = units.tensor(number, weights, whole)
        largest = np.fmax(largest, von_mises(np.moveaxis(tensors, 1, -1)))
    return largest
