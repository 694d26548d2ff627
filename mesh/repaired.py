"""Mesh a solid, and mesh it again with other settings if that fails."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from typing import Protocol

from geometry.session import GmshLog
from mesh.errors import MeshError
from mesh.quality import Quality
from mesh.repair import Repair, UnsoundMeshError
from mesh.tetmesh import TetMesh

# Each round costs another mesh; most repairs that succeed at all take one.
MAX_ROUNDS = 4


class Attempt(Protocol):
    """Meshes the open model."""

    def __call__(self, *, repair: Repair) -> tuple[TetMesh, Quality]:
        """Mesh with the changed settings of `repair`."""


@dataclass(frozen=True)
class Meshed:
    """A mesh and how it was made.

    Attributes
    ----------
    mesh, quality
        The repaired mesh and its quality.
    repair
        Settings that differ from those of the first attempt.
    warnings
        Warnings of gmsh about this mesh.
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
    """Mesh the open model; after a failure or with flaws, mesh it again with the changes they call for.

    If every attempt has flaws, the first mesh is returned, and the checks of the run will fail on it.

    Parameters
    ----------
    attempt
        Meshes the model.
    flaws
        Returns the changes that a mesh calls for; None if it is sound.
    log
        The messages of the session.
    tell
        Called with the cause of each new attempt before it begins.

    Raises
    ------
    MeshError
        No attempt produced a mesh; this is the first failure.
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
    """Return the first failure, with the number of further attempts."""
    if failure is not None and not rounds:
        return failure
    tries = f"{rounds} further attempts with other settings at the faulty places failed too"
    return MeshError(f"{failure} ({tries})")
