"""Which part of an assembled rod each imported solid is; a rod in one piece is split."""

import math
from collections.abc import Sequence

import gmsh

from geometry import kernel
from geometry.assembly import Assembly
from geometry.cad.cylinders import recognised
from geometry.errors import GeometryError
from geometry.faces import Bore, faces_of
from geometry.intake import Member, Role
from geometry.invalid import InvalidValue, require
from geometry.parting import BUSHING, CAP, LOWER_SHELL, ROD, UPPER_SHELL, divided

_ORDER = (ROD, CAP, BUSHING, UPPER_SHELL, LOWER_SHELL)


def named_parts(kept: Sequence[Member], bores: tuple[Bore, Bore], assembly: Assembly) -> dict[str, list[int]]:
    """Volumes by the names of the parts; a rod in one piece is split, and shells are cut out of its ring."""
    volumes: dict[str, list[int]] = {}
    for one in kept:
        volumes.setdefault(_name(one, bores), []).append(one.tag)
    if ROD not in volumes:
        listed = ", ".join(f"{one.name} ({one.role})" for one in kept)
        raise GeometryError(f"no solid of the file is a rod: {listed}. Name rod and cap in rod.solids")
    own = [name for name in (UPPER_SHELL, LOWER_SHELL) if name in volumes]
    if own:
        rule = f"the file has bearing shells of its own ({', '.join(own)})"
        thick = _thickness(volumes[own[0]])
        fits = not assembly.shell or math.isclose(assembly.shell, thick, rel_tol=0.02)
        remedy = f"Leave it out, or give their thickness, {thick:.4g} mm."
        require(fits, "assembly.shell_thickness_mm", assembly.shell, rule, remedy)
    if BUSHING not in volumes and assembly.bushing:
        rule = "needs a bushing in the small end, but the file has none"
        raise InvalidValue("assembly.bushing_interference_mm", None, rule, "Add the bushing to the file.")
    return _divided(volumes, bores, assembly, own)


def _divided(
    volumes: dict[str, list[int]], bores: tuple[Bore, Bore], assembly: Assembly, shells: Sequence[str]
) -> dict[str, list[int]]:
    """Split what the file has in one piece."""
    if shells and CAP not in volumes:
        raise GeometryError("the file has bearing shells, but no cap. Add the cap to the file")
    normal = assembly.normal if CAP not in volumes and assembly.split is not None else None
    radius = bores[0].radius + assembly.shell if assembly.shell and not shells else None
    if normal is None and radius is None:
        return {name: volumes[name] for name in _ORDER if name in volumes}
    if CAP in volumes:
        raise InvalidValue(
            "assembly.shell_thickness_mm",
            assembly.shell,
            "the shells are not among the solids of the file, whose cap is a part of its own",
            "Add them to the file, or leave it out.",
        )
    bodies = {name: volumes[name][0] for name in (ROD, BUSHING) if name in volumes}
    far = 3 * (bores[1].x + 2 * bores[0].radius)
    made = divided(bodies, normal, radius, far)
    gmsh.model.occ.synchronize()
    return {name: [tag] for name, tag in made.items()}


def _name(one: Member, bores: tuple[Bore, Bore]) -> str:
    """What a solid is in the assembly."""
    if one.role in (Role.ROD, Role.CAP, Role.ASSUMED_CAP):
        return ROD if one.role is Role.ROD else CAP
    x, _, _ = gmsh.model.occ.getCenterOfMass(kernel.SOLID, one.tag)
    if one.role is Role.BUSHING:
        if abs(x - bores[1].x) < bores[1].x / 2:
            return BUSHING
        return UPPER_SHELL if x > 0 else LOWER_SHELL
    raise GeometryError(
        f"it is not clear what {one.name} is in the assembly (taken for: {one.role}). Say it in "
        'rod.solids, as "cap: NAME" (rod, cap, bushing, shell, bolt or nut), or keep other solids'
    )


def _thickness(shell: Sequence[int]) -> float:
    """Of a half shell, from the radii of its cylinders, mm."""
    radii = [face.values[6] for face in map(recognised, faces_of(shell)) if face.shape == "Cylinder"]
    return max(radii, default=0.0) - min(radii, default=0.0)
