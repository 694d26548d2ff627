"""Write an animation of the crank cycle, drawn by a separate process that cannot affect the results."""

import math
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import numpy.typing as npt

from fea.machine.clock import Clock
from fea.output.pictures.child import REMEDY, environments, run_drawing
from fea.output.pictures.skin import Skin
from fea.output.target import PictureError, StorageError, require_target
from fea.pins.unit_loads import Weights
from fea.run.prepare import PreparedRod
from fea.stress.stress import von_mises
from geometry.arrays import Floats

Singles = npt.NDArray[np.float32]

SUFFIXES = (".gif", ".mp4")
TIMEOUT = 600.0  # seconds; 72 frames take about ten


@dataclass(frozen=True)
class Frames:
    """The data of an animation: a rod at instants of the cycle.

    Attributes
    ----------
    skin
        Its outer surface without load, rod frame, mm.
    displacement
        (n_frames, n_nodes, 3) of the skin's nodes, rod frame, mm.
    von_mises
        (n_frames, n_nodes), MPa.
    crank_angle
        (n_frames,), rad.
    crank_radius, rod_length, pin_offset
        Of the engine, mm.
    title
        Lines of the title: study and speed.
    """

    skin: Skin
    displacement: Singles
    von_mises: Singles
    crank_angle: Floats
    crank_radius: float
    rod_length: float
    pin_offset: float
    title: tuple[str, ...]


def require_film(path: Path) -> None:
    """Refuse an animation that cannot be written, before anything is computed.

    Raises
    ------
    InvalidValue
        The suffix is not known, or the directory does not exist.
    PictureError
        An MP4 file is requested, but its encoder is not installed.
    """
    require_target("--animate", path, SUFFIXES)
    if path.suffix.lower() == ".mp4" and find_spec("imageio_ffmpeg") is None:
        remedy = "Install it (pip install imageio-ffmpeg), or write a .gif file."
        raise PictureError(f"{path.name} needs imageio-ffmpeg, which is not installed. {remedy}")


def film(frames: Frames, suffix: str) -> bytes:
    """Draw an animation and return the content of its file.

    Raises
    ------
    PictureError
        It could not be drawn; the message says what to install.
    """
    with TemporaryDirectory() as scratch:
        source, target = Path(scratch, "frames.npz"), Path(scratch, f"film{suffix.lower()}")
        np.savez(
            source,
            points=frames.skin.points,
            facets=frames.skin.facets,
            displacement=frames.displacement,
            von_mises=frames.von_mises,
            crank_angle=frames.crank_angle,
        )
        engine = {name: getattr(frames, name) for name in ("crank_radius", "rod_length", "pin_offset")}
        orders = {"source": str(source), "target": str(target), "engine": engine, "title": frames.title}
        for environment in environments():
            said = run_drawing("fea.output.pictures.animation_frames", orders, environment, TIMEOUT)
            if target.is_file():
                return target.read_bytes()
    raise PictureError(f"the animation could not be drawn: {said}. {REMEDY}")


def write_film(path: Path, content: bytes) -> None:
    """Write the file of an animation completely or not at all; raises `StorageError`."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(content)
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        message = f"{path} could not be written: {error.strerror}. Choose another path, or free disk space."
        raise StorageError(message) from error


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
    engine, mesh = rod.engine.engine, rod.mesh.whole
    angles = np.arange(COUNT) * 4 * math.pi / COUNT
    outer = Skin.of(mesh.points, mesh.tets)
    nodes, facets = np.unique(outer.facets, return_inverse=True)
    displacement = np.empty((COUNT, len(nodes), 3), np.float32)
    stress = np.empty((COUNT, len(nodes)), np.float32)
    weights = rod.cycle.weights(rod.crank_cycle(rpm), angles)
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
