"""The rod of a study whose mesh comes from a file."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from fea.base.choices import Element
from fea.machine.clock import Clock
from fea.machine.system import memory_limit
from fea.rod.discretise import MeshRequest
from fea.rod.meshed_rod import Bores, MeshedRod, Meshing
from fea.rod.reading import SECONDS, read_isolated
from fea.solid.assembly import volume_points
from fea.solid.inertia import enclosed_volume
from fea.study.files import require_size
from fea.study.rod_table import LARGEST_MESH_FILE, RodTable
from geometry.assembly import Assembly
from geometry.errors import GeometryError, InvalidValue, require
from geometry.faces import Bore
from geometry.imports import ImportReport, RodFile, Role
from geometry.session import session
from geometry.surfaces import Mirror
from mesh.files.given import GivenMesh, given_mesh, mean_edge
from mesh.generate import NOTHING
from mesh.quality import measure
from mesh.tetmesh import MeshError, TetMesh, unmirrored

PART = "rod"
# Bytes that are read within a second, with room to spare; memory, bytes, for any file, and per byte of it:
# numbers as text take more of it than in the file.
_READING = 1e6
_MEMORY, _MEMORY_RATIO = 2 * 2**30, 24
_FIXED = (
    "the mesh comes from a file and was not refined: where an error bar is too wide, only a finer mesh or "
    "the solid itself (rod.step) can narrow it"
)
_OF_SURFACE = (
    "the file holds a surface of flat triangles, whose inside was meshed and not refined: fillets are as "
    "coarse as these triangles, which limits the answer more than the elements do. The error bars include "
    "it; the solid itself (rod.step) or finer triangles make them smaller"
)
_STIFF = "four-node tetrahedra are too stiff in bending: ten-node ones (C3D10) give far smaller errors"


def given_rod(file: RodFile, request: MeshRequest, clock: Clock) -> MeshedRod:
    """Read the mesh of a rod and name its bores; it is solved as a whole.

    `request`: its order is that of the study: first order cannot be had from a second-order mesh. Raises
    `InvalidValue`: the file is too large or cannot be read, or the study asks for another order; `MeshError`:
    the mesh is damaged or cannot be used, or its bores cannot be identified.
    """
    with clock("mesh"):
        try:
            require_size("rod.mesh", file.path, LARGEST_MESH_FILE)
            given = _read(file)
        except OSError as error:
            reason = error.strerror or str(error)
            raise InvalidValue("rod.mesh", str(file.path), f"cannot be read ({reason})") from error
        rule, remedy = "is not the order of the mesh, whose tetrahedra have ten nodes", "Leave it out."
        require(request.order >= given.mesh.order, "mesh.element", Element.P1, rule, remedy)
        notes = (_FIXED, _STIFF) if given.mesh.order == 1 else (_FIXED,)
        notes = (_OF_SURFACE,) if file.path.suffix.lower() == ".stl" else notes
        meshing = Meshing(given.size, given.quality, NOTHING, (), given=notes)
        return replace(meshed_rod(given.mesh, given.bores, [PART]), meshing=meshing, imported=given.imported)


def _read(file: RodFile) -> GivenMesh:
    size = file.path.stat().st_size
    memory = _MEMORY + _MEMORY_RATIO * size
    try:
        return read_isolated(
            partial(given_mesh, file),
            f"read {file.path}",
            who="the mesh reader",
            seconds=SECONDS + size / _READING,
            memory=memory,
        )
    except MemoryError as error:
        message = f"{file.path} needs more than {memory / 2**30:.1f} GiB to read. Use a coarser mesh"
        raise MeshError(message) from error


def meshed_rod(mesh: TetMesh, bores: tuple[Bore, Bore], parts: Sequence[str]) -> MeshedRod:
    """Return a finished mesh as a whole rod; `bores` of big and small end, `parts` by their numbers."""
    whole = unmirrored(mesh)
    volumes = [enclosed_volume(mesh)]
    if mesh.part is not None:
        volumes = np.bincount(mesh.part, volume_points(mesh)[1].sum(axis=1)).tolist()
    return MeshedRod(
        cell=mesh,
        mirrored=whole,
        drawn=mesh,
        drawn_node=whole.source,
        bores=Bores.of(bores),
        parts=dict(zip(parts, volumes, strict=True)),
        symmetry=Mirror.NONE,
        meshing=Meshing(mean_edge(mesh), measure(mesh), NOTHING, ()),
    )


def found_assembly(rod: RodTable, report: ImportReport) -> tuple[str, ...]:
    """Return joint, bolts and interfaces in words; empty without a cap. `report`: of the file's reader."""
    if report.assembly or rod.cad is None:
        return report.assembly
    if not any(one.kept and one.role is Role.CAP for one in report.solids):
        return ()
    job = partial(_read_listing, rod)
    try:
        listing = job() if memory_limit() is not None else read_isolated(job, f"read {rod.cad.path}")
    except (InvalidValue, GeometryError) as error:
        return (f"cannot be assembled with [assembly]: {error}",)
    return (*listing.assembly, *(text for text in listing.assumed if text not in report.assumed))


def _read_listing(rod: RodTable) -> ImportReport:
    with session():
        listing = rod.draw(assembly=Assembly()).imported
    if listing is None:
        raise ValueError("a solid from a file has an import report")
    return listing
