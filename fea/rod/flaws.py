"""Elements with which the checks of a run would fail, and the changes to the mesh that avoid them."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from fea.base.checks import LIMITS
from fea.base.material import Material, of_parts
from geometry.solid import Solid
from mesh.quality import Quality, scaled_jacobian, shape
from mesh.repair import Repair, of_elements
from mesh.tetmesh import TetMesh

# From the names of parts to the material of each.
MaterialsOf = Callable[[Iterable[str]], tuple[Material, ...]]

_LEAST_SHAPE = 1 / LIMITS["flattest_element"]
_BENT = 0.25  # scaled Jacobian of an element that can no longer follow its arc


def mesh_flaws(materials: MaterialsOf, solid: Solid, mesh: TetMesh, quality: Quality) -> Repair | None:
    """Find the elements that are too flat, and those whose straightened or bent edges miss too much mass.

    `materials`: gives the material of each named part; `solid`: as drawn in the open session.

    Returns None if the mesh passes the checks, or misses mass only because its elements are large.
    """
    flaws = {"too flat": shape(mesh) < _LEAST_SHAPE} if quality.least_shape < _LEAST_SHAPE else {}
    suspect = quality.mended or quality.least_scaled_jacobian < _BENT
    if mesh.order > 1 and suspect and _misses_mass(materials, solid, mesh):
        if quality.mended:
            flaws["straight where the solid is curved"] = np.isin(np.arange(len(mesh.tets)), quality.mended)
        else:
            flaws["too distorted"] = scaled_jacobian(mesh) < _BENT
    if not flaws:
        return None
    counts = ((int(bad.sum()), kind) for kind, bad in flaws.items())
    what = " and ".join(f"{n} {'element was' if n == 1 else 'elements were'} {kind}" for n, kind in counts)
    return of_elements(mesh.points[mesh.tets[np.any(list(flaws.values()), axis=0), :4]], what)


def mass_error(meshed: float, volumes: Iterable[float], materials: Sequence[Material]) -> float:
    """Relative difference of the meshed mass (whole rod, t) from that of the solid's parts, mm³."""
    solid = sum(m.density * volume for m, volume in zip(materials, volumes, strict=True))
    return abs(meshed / solid - 1)


def _misses_mass(materials: MaterialsOf, solid: Solid, mesh: TetMesh) -> bool:
    from fea.solid.inertia import inertia  # noqa: PLC0415 - only a suspect mesh needs it

    own = materials(part.name for part in solid.parts)
    meshed = inertia(mesh, of_parts(own, mesh.part).density).properties.mass
    return mass_error(meshed, (part.mass.mass for part in solid.parts), own) > LIMITS["mesh_mass"]
