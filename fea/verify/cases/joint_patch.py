"""Patch test of a joint: a constant stress, with shear in the joint, passes from one part to the other."""

import numpy as np

from fea.solid.traction import traction_forces
from fea.verify.assembled_body import AssembledBody
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, furthest
from fea.verify.cases.bolted_joint import SIDES, joint
from fea.verify.parted import along_x, apart
from geometry.arrays import Floats
from geometry.bodies import Prism, SideBySide, polygon
from geometry.surfaces import Surface

LENGTHS, WIDTH, HEIGHT = (0.4, 1.0), 0.6, 0.5  # mm
# XX YY ZZ XY YZ XZ, MPa. The shear in the joint is half of its pressure.
STRESS = np.array([-100.0, 60.0, 35.0, 40.0, -25.0, 30.0])
FRICTION = 0.8

_WHY = "only rounding errors remain, on elements of any shape"
GOALS = tuple(
    Goal(f"P{order} {what}, worst place", "1", 1.0, 1e-8, _WHY)
    for order in (1, 2)
    for what in ("pressure of the joint / exact", "shear stress of the joint / exact", "stress / exact")
)


def sheared(size: float, order: int) -> AssembledBody:
    """Two blocks in friction under the tractions of the constant stress."""
    ends = ((0.0, LENGTHS[0]), LENGTHS)
    blocks = tuple(
        Prism(
            polygon(
                *(((x, y), Surface.FREE) for x, y in zip((a, b, b, a), (0, 0, WIDTH, WIDTH), strict=True))
            ),
            (0.0, HEIGHT),
            bottom=Surface.FREE,
        )
        for a, b in ends
    )
    mesh = apart(SideBySide(blocks), size, LENGTHS[:1], along_x, {(0, 1): SIDES}, order=order)
    xx, yy, zz, xy, yz, xz = STRESS
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    def acting(_: Floats, normals: Floats) -> Floats:
        return np.asarray(normals @ tensor)

    loads = traction_forces(mesh, Surface.FREE, acting)[..., None]
    faces = [joint(mesh, friction=True)]
    return AssembledBody(mesh, (STEEL, STEEL), faces, [], loads, friction=FRICTION)


def compute(size: float) -> Computed:
    """Solve with elements of `size`, of both orders."""
    found: dict[str, float] = {}
    dofs = 0
    for order in (1, 2):
        body = sheared(size, order)
        state = body.step([1.0])
        pressure, along, around = body.stresses(state)
        shear = np.hypot(along, around) / np.hypot(STRESS[3], STRESS[5])
        u = body.displacement(state, [1.0])
        values = (pressure / -STRESS[0], shear, body.gauss_stress(u) / STRESS)
        for goal, value in zip(GOALS[3 * order - 3 : 3 * order], values, strict=True):
            found[goal.quantity] = furthest(value.ravel(), 1.0)
        dofs = body.mesh.points.size
    return Computed(found, dofs)


BENCHMARK = Benchmark(
    title="Patch test of a joint with friction on an irregular mesh",
    source="Taylor & Papadopoulos 1991, On a patch test for contact problems in two dimensions",
    goals=GOALS,
    compute=compute,
    size=0.2,
    converges=False,
)
