"""The mesh of a study's rod; nothing that solves is loaded for it."""

from collections.abc import Sequence
from typing import Any

from fea.analysis.assembling import drawn_assembly
from fea.machine.clock import Clock
from fea.rod.discretise import MeshRequest, discretise
from fea.rod.loading import EngineLoading
from fea.rod.meshed_rod import MeshedRod
from fea.study.study import Study
from geometry.errors import GeometryError
from mesh.sizing import SizeField
from mesh.tetmesh import MeshError

# Element size away from the peaks over the default size, where the mesh is refined: the first mesh shows just
# as well where small elements are needed, and those are where later meshes have them.
COARSER = 2.0


def mesh_study(
    study: Study,
    clock: Clock | None = None,
    *,
    wanted: Sequence[SizeField] = (),
    coarser: float = 1.0,
    movable: bool = False,
) -> MeshedRod:
    """Draw and mesh the rod of a study.

    `wanted`: element sizes that earlier solutions ask for; `movable`: whether the mesh is to follow other
    dimensions of the rod: see `fea.rod.discretise.moved`. Raises `InvalidValue`: a value of the study breaks
    a rule; `GeometryError` and `MeshError`: no solid or no usable mesh came out.
    """
    request = MeshRequest(
        size=study.mesh.size_mm,
        order=study.mesh.element.order,
        symmetry=study.analysis.symmetry,
        wanted=wanted,
        coarser=coarser,
        touched=study.in_contact,
        assembly=drawn_assembly(study),
        movable=movable,
    )
    if study.rod.mesh is not None:
        from fea.rod.given import given_rod  # noqa: PLC0415 - it loads scikit-fem, which meshing does without

        found = given_rod(study.rod.mesh, request, clock or Clock())
    else:
        found = discretise(study.rod, study.materials, request, clock or Clock())
    if study.rod.from_file:
        study.require_plausible(found.bores.lengths)
    return found


def mesh_loaded(study: Study, clock: Clock, **asked: Any) -> MeshedRod:
    """Draw and mesh a rod, as `asked` of `mesh_study`; a study without loads is refused before."""
    study.require_loading()
    if study.engine is not None and study.rod.length is not None:
        EngineLoading.of(study.engine, study.rod.length)
    return mesh_study(study, clock, **asked)


def adaptive_mesh(
    study: Study, clock: Clock, wanted: Sequence[SizeField] = (), *, movable: bool = False
) -> MeshedRod:
    """Draw and mesh as `mesh_study`; to reach a tolerance, coarsely but for the wanted sizes."""
    if study.tolerance_percent is None or study.mesh.size_mm is not None:
        return mesh_loaded(study, clock, wanted=wanted, movable=movable)
    try:
        return mesh_loaded(study, clock, wanted=wanted, coarser=COARSER, movable=movable)
    except (GeometryError, MeshError):  # what only smaller elements can follow
        return mesh_loaded(study, clock, wanted=wanted, movable=movable)
