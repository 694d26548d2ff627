"""Write an animation of the crank cycle, drawn by a separate process that cannot affect the results."""

from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.result import InstantFields
from fea.base.units import DEG
from fea.machine.clock import Clock
from fea.machine.remedies import system_remedy
from fea.output.folder import PictureError, require_target, stored
from fea.output.pictures.picture import environments, run_drawing
from fea.output.pictures.surface import CycleAnimation, DrawnSurface
from fea.output.units import scale, unit

SUFFIXES = (".gif", ".mp4")
TIMEOUT = 600.0  # seconds; 72 frames take about ten


def require_film(path: Path) -> None:
    """Refuse an animation. Raises `InvalidValue`: its suffix or folder; `PictureError`: no encoder."""
    require_target("--animate", path, SUFFIXES)
    if path.suffix.lower() == ".mp4" and find_spec("imageio_ffmpeg") is None:
        remedy = "Install it (pip install imageio-ffmpeg), or write a .gif file."
        raise PictureError(f"{path.name} needs imageio-ffmpeg, which is not installed. {remedy}")


def drawn(film: CycleAnimation, suffix: str) -> bytes:
    """Return the content of an animation's file. Raises `PictureError`; the message says what to install."""
    with TemporaryDirectory() as scratch:
        target = Path(scratch, f"film{suffix.lower()}")
        for environment in environments():
            job = "fea.output.pictures.animation_frames:draw_film"
            failure = run_drawing(job, film, target, environment=environment, timeout=TIMEOUT)
            if not failure:
                return target.read_bytes()
    raise PictureError(f"the animation could not be drawn: {failure}. Remedy: {system_remedy('pictures')}.")


def write_film(path: Path, content: bytes) -> None:
    """Write the file of an animation completely or not at all; raises `StorageError`."""
    with stored(path) as place:
        place.write_bytes(content)


COUNT = 72  # frames of a cycle: of a four-stroke engine, one every 10°


def filmed(rod: PreparedRod, rpm: float, path: Path, clock: Clock) -> tuple[bytes, str]:
    """Return the content of the file of an animation, or the reason why it could not be drawn."""
    try:
        with clock("animation"):
            return drawn(computed(rod, rpm), path.suffix), ""
    except PictureError as error:
        return b"", str(error)


def computed(rod: PreparedRod, rpm: float) -> CycleAnimation:
    """Compute the frames of an animation at a speed: displacement by solving, stress by superposition."""
    engine, mesh = rod.engine.engine, rod.mesh.whole
    instants = InstantFields(rod, rpm, engine.cycle_degrees / COUNT)
    outer = DrawnSurface.of(mesh.points, mesh.tets)
    nodes, facets = np.unique(outer.facets, return_inverse=True)
    displacement = np.empty((COUNT, len(nodes), 3), np.float32)
    stress = np.empty((COUNT, len(nodes)), np.float32)
    for k, (moved, _, equivalent, _) in enumerate(instants.solved()):
        displacement[k] = moved[nodes]
        stress[k] = scale("MPa") * equivalent[nodes]
    return CycleAnimation(
        skin=DrawnSurface(mesh.points[nodes], facets.reshape(outer.facets.shape)),
        displacement=displacement,
        von_mises=stress,
        crank_angle=np.array(instants.degrees) * DEG,
        crank_radius=engine.crank_radius,
        rod_length=engine.rod_length,
        pin_offset=engine.pin_offset,
        title=(rod.study.name, f"{rpm:g} rpm"),
        unit=unit("MPa"),
    )
