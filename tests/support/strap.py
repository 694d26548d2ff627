"""A quarter of a plain strap with two eyes: a body with all the rod's surfaces that meshes in a moment."""

from functools import cache

import gmsh
import numpy as np

from fea.solid.bore import bore_facets, bore_load
from fea.solid.inertia import inertia
from fea.solid.parity import ParityPair
from fea.solid.supports import rigid_modes
from geometry.surfaces import Surface
from loads.bearing import BorePressure
from loads.instants import in_motion
from mesh.generate import tetrahedralise
from mesh.sizing import Refinement, Sizing
from mesh.tetmesh import TetMesh

LENGTH, BIG_BORE, SMALL_BORE, WIDTH = 60.0, 8.0, 5.0, 8.0  # radii of the bores


@cache
def strap(size: float = 4.0, order: int = 2) -> TetMesh:
    """The cell y ≥ 0, z ≥ 0 of the strap."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        return _meshed(size, order)
    finally:
        gmsh.finalize()


def _meshed(size: float, order: int) -> TetMesh:
    occ = gmsh.model.occ
    rings = [occ.addCylinder(0, 0, 0, 0, 0, WIDTH / 2, 14), occ.addCylinder(LENGTH, 0, 0, 0, 0, WIDTH / 2, 9)]
    bar = occ.addBox(0, -5, 0, LENGTH, 10, WIDTH / 2)
    solid, _ = occ.fuse([(3, bar)], [(3, ring) for ring in rings])
    places = ((0, BIG_BORE), (LENGTH, SMALL_BORE))
    bores = [occ.addCylinder(x, 0, 0, 0, 0, WIDTH, radius) for x, radius in places]
    solid, _ = occ.cut(solid, [(3, bore) for bore in bores])
    occ.intersect(solid, [(3, occ.addBox(-100, 0, 0, 300, 100, 100))])
    occ.synchronize()
    surfaces: dict[Surface, list[int]] = {surface: [] for surface in Surface}
    for _, face in gmsh.model.getEntities(2):
        surfaces[_name(face)].append(face)
    small = Refinement(tuple(surfaces[Surface.SMALL_END_BORE]), size / 2, WIDTH / 2)
    return tetrahedralise(surfaces, [small], Sizing(size, order))[0]


def _name(face: int) -> Surface:
    x0, _, _, x1, y1, z1 = gmsh.model.getBoundingBox(2, face)
    if y1 < 1e-5:
        return Surface.SYMMETRY_Y
    if z1 < 1e-5:
        return Surface.SYMMETRY_Z
    if gmsh.model.getType(2, face) == "Cylinder":
        if x1 < BIG_BORE + 0.1:
            return Surface.BIG_END_BORE
        if x0 > LENGTH - SMALL_BORE - 0.1 and x1 < LENGTH + SMALL_BORE + 0.1:
            return Surface.SMALL_END_BORE
    return Surface.FREE


DENSITY = 7.7e-9
COSINE = BorePressure.parse("cosine-180").tension


def tilted_load(mesh):
    """A pin force, a motion and the crank force that balances them."""
    body = inertia(mesh, DENSITY)
    rod = body.properties
    motion = in_motion((-2e6, 1e6), angular_velocity=300.0, angular_acceleration=3e4)
    (a_x, a_y), omega, alpha = motion.acceleration, motion.angular_velocity, motion.angular_acceleration
    x, about_origin = rod.center[0], rod.inertia_z + rod.mass * rod.center[0] ** 2
    pin = np.array([-3000.0, (about_origin * alpha + rod.mass * x * a_y) / LENGTH])
    crank = rod.mass * np.array([a_x - omega**2 * x, a_y + alpha * x]) - pin
    parts = [body.forces(motion)]
    for surface, center, radius, force in (
        (Surface.SMALL_END_BORE, LENGTH, SMALL_BORE, pin),
        (Surface.BIG_END_BORE, 0.0, BIG_BORE, crank),
    ):
        peak = COSINE.peak(np.hypot(*force), radius, WIDTH)
        facets = bore_facets(mesh, surface, center)
        load = bore_load(
            facets,
            len(mesh.points),
            tuple(force),
            lambda psi, p=peak: p * COSINE.unbounded(psi),
            COSINE.angle / 2,
        )
        parts.append(load.forces)
    odd = [part.antisymmetric for part in parts if part.antisymmetric is not None]
    return ParityPair(sum(part.symmetric for part in parts), sum(odd) if odd else None)


def without_rigid_motion(points, u):
    modes, flat = rigid_modes(points).reshape(-1, 6), u.reshape(-1)
    return (flat - modes @ np.linalg.lstsq(modes, flat)[0]).reshape(-1, 3)
