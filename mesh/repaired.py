"""Mesh, and mesh again where that went wrong."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from typing import Protocol

from geometry.session import GmshLog
from mesh.errors import MeshError
from mesh.quality import Quality
from mesh.repair import Repair, UnsoundMeshError
from mesh.tetmesh import TetMesh

# Each costs another mesh; what can be repaired at all mostly takes one.
MAX_ROUNDS = 4


class Attempt(Protocol):
    """Meshes the open model."""

    def __call__(self, *, repair: Repair) -> tuple[TetMesh, Quality]:
        """Mesh with this done otherwise than at first."""


@dataclass(frozen=True)
class Meshed:
    """A mesh and how it came about.

    Attributes
    ----------
    mesh, quality
        As gmsh made it and it was mended.
    repair
        What was done otherwise than at first.
    warnings
        What gmsh had to say of this mesh.
    """

    mesh: TetMesh
    quality: Quality
    repair: Repair
    warnings: tuple[str, ...]


def repaired(
    attempt: Attempt,
    flaws: Callable[[TetMesh, Quality], Repair | None],
    log: GmshLog,
    tell: Callable[[str], None],
) -> Meshed:
    """Mesh the open model, and again with what a failure or `flaws` asks for.

    Where no round ends without flaws the first mesh stays, for the checks of the run to mark.

    Parameters
    ----------
    attempt
        Meshes.
    flaws
        What to do otherwise about a mesh; None where it is sound.
    log
        Of the session.
    tell
        Called with the cause of each round before it begins.

    Raises
    ------
    MeshError
        No round ended with a mesh; the first failure.
    """
    repair, first, failure = Repair(), None, None
    for rounds in count():
        begin = len(log.lines)
        try:
            mesh, quality = attempt(repair=repair)
        except MeshError as error:
            failure = failure or error
            more = error.repair if isinstance(error, UnsoundMeshError) else None
        else:
            meshed = Meshed(mesh, quality, repair, log.warnings_from(begin))
            more = flaws(mesh, quality)
            if more is None:
                return meshed
            first = first or meshed
        if more is None or rounds == MAX_ROUNDS:
            break
        repair += more
        tell(more.causes[0])
    if first is None:
        raise _told(failure, rounds)
    return first


def _told(failure: MeshError | None, rounds: int) -> MeshError:
    """Return the first failure, with how often something was tried about it."""
    if failure is not None and not rounds:
        return failure
    tries = f"{rounds} more attempts with other settings where it failed did no better"
    return MeshError(f"{failure} ({tries})")
