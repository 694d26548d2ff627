"""Elements that make a run's checks refuse its mesh, and what to do otherwise about them."""

from collections.abc import Iterable, Sequence

import numpy as np

from fea.checks import LIMITS
from fea.material import Material, Materials
from fea.solid.inertia import inertia
from fea.study.study import Study
from geometry.solid import Solid
from mesh.quality import Quality, shape
from mesh.repair import Repair, of_elements
from mesh.tetmesh import TetMesh

_LEAST_SHAPE = 1 / LIMITS["flattest_element"]


def mesh_flaws(study: Study, solid: Solid, mesh: TetMesh, quality: Quality) -> Repair | None:
    """Find the elements that are too flat, and those whose straightened edges miss too much mass.

    Parameters
    ----------
    study
        Whose materials they are.
    solid
        As drawn in the open session.
    mesh, quality
        Of the drawn cell.

    Returns
    -------
    Repair or None
        None where the mesh passes the checks, or nothing can be done: mass that elements miss without having
        been straightened, their size decides.
    """
    if quality.least_shape >= _LEAST_SHAPE and not quality.mended:
        return None
    flat = shape(mesh) < _LEAST_SHAPE
    straight = np.zeros(len(mesh.tets), dtype=bool)
    if quality.mended and _misses_mass(study, solid, mesh):
        straight[list(quality.mended)] = True
    if not (flat | straight).any():
        return None
    found = {"flat": flat, "straight where the solid is curved": straight}
    what = " and ".join(_counted(int(bad.sum()), kind) for kind, bad in found.items() if bad.any())
    return of_elements(mesh.points[mesh.tets[flat | straight, :4]], what)


def mass_error(meshed: float, volumes: Iterable[float], materials: Sequence[Material]) -> float:
    """Relative difference of the meshed mass (whole rod, t) from that of the solid's parts, mm³."""
    solid = sum(m.density * volume for m, volume in zip(materials, volumes, strict=True))
    return abs(meshed / solid - 1)


def _counted(count: int, kind: str) -> str:
    return f"{count} {'element was' if count == 1 else 'elements were'} {kind}"


def _misses_mass(study: Study, solid: Solid, mesh: TetMesh) -> bool:
    materials = study.materials(part.name for part in solid.parts)
    density = materials[0].density if mesh.part is None else Materials(materials, mesh.part).density
    meshed = inertia(mesh, density).properties.mass
    return mass_error(meshed, (part.mass.mass for part in solid.parts), materials) > LIMITS["mesh_mass"]
