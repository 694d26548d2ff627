"""Bolted joints: prismatic blocks, centric and eccentric, and the joint diagram of a clamped tube.

Of a prismatic block that a bolt compresses evenly, the load acting where the bolt does, the stress is linear
over the section. With the stiffness k_B of the bolt and k_P = E A / l of the block, Φ = k_B / (k_B + k_P):
the bolt carries F_V + Φ F and the joint F_V − (1 − Φ) F, until at an eccentricity e the edge at c opens where
F_V = F (1 − Φ + e c A / I). Of a tube between the head and the nut of a bolt, the compliance is found on the
same mesh without a joint, from the mean approach of its seats: VDI 2230's joint diagram, in which bolt and
parts are measured alike.
"""

from dataclasses import replace

import numpy as np

from fea.contact.interfaces import BoltPull, MatingFaces
from fea.solid.traction import traction_forces
from fea.solvers.constrained import displacement
from fea.verify.assembled_body import AssembledBody, pulled
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import STEEL, held
from fea.verify.parted import along_x, apart, bars, parted
from geometry.arrays import Floats
from geometry.bodies import Revolution, SideBySide, polygon
from geometry.surfaces import Surface
from mesh.generate import Fine, mesh_body
from mesh.separate import separated
from mesh.tetmesh import TetMesh

SIDES = (Surface.JOINT, Surface.JOINT_CAP)
ENDS, HALF_WIDTH, HEIGHT, ECCENTRICITY = (0.0, 15.0, 40.0), 8.0, 6.0, 1.5  # mm; HEIGHT of the half z ≥ 0
PRELOAD, LOAD = 5000.0, 3000.0  # N
_E = STEEL.youngs_modulus
_AREA, _MOMENT = 4 * HALF_WIDTH * HEIGHT, 2 * HEIGHT * (2 * HALF_WIDTH) ** 3 / 12
STIFFNESS = 0.2 * _E * _AREA / (ENDS[-1] - ENDS[0])
SHARE = 0.2 / 1.2

# A bolt M10 in a hole of 11 mm, 40 mm of grip; mm.
HOLE, SEAT, TUBE, HALF_GRIP = 11.0, 16.0, 24.0, 20.0

_EXACT = "the stress is linear, which the elements contain; only rounding errors remain"
_SIZE = 1e-6
BOLT = Goal("block: bolt force", "N", PRELOAD + SHARE * LOAD, _SIZE, _EXACT)
JOINT = Goal("block: force in the joint", "N", PRELOAD - (1 - SHARE) * LOAD, _SIZE, _EXACT)
OPENING = Goal("block: load that opens the joint", "N", PRELOAD / (1 - SHARE), _SIZE, _EXACT)
OPEN = Goal("block: bolt force, joint open", "N", 2 * PRELOAD, _SIZE, _EXACT)
EDGE = Goal(
    "block, eccentric load: load that opens the edge",
    "N",
    PRELOAD / (1 - SHARE + ECCENTRICITY * HALF_WIDTH * _AREA / _MOMENT),
    _SIZE,
    _EXACT,
)
DIAGRAM = Goal(
    "tube: bolt force / VDI 2230's joint diagram",
    "1",
    1.0,
    1e-4,
    "one mesh gives both compliances, and the joint stays closed; solving leaves rounding errors",
)


def block(size: float) -> AssembledBody:
    """The block with its bolt; the loads are a centric and an eccentric one of 1 N."""
    body = bars(ENDS, (-HALF_WIDTH, HALF_WIDTH), HEIGHT)
    mesh = apart(body, size, ENDS[1:-1], along_x, {(0, 1): SIDES})
    ends = (Surface.BOLT_HEAD, Surface.BOLT_THREAD)

    def loaded(eccentricity: float) -> Floats:
        def stress(places: Floats, normals: Floats) -> Floats:
            return normals * (1 / _AREA + eccentricity * places[..., 1:2] / _MOMENT)

        return np.asarray(sum(traction_forces(mesh, end, stress) for end in ends))

    loads = np.stack([loaded(0.0), loaded(ECCENTRICITY)], axis=-1)
    return AssembledBody(
        mesh, (STEEL, STEEL), [joint(mesh)], [pulled(mesh, STIFFNESS, share=0.5)], loads, preload=[PRELOAD]
    )


def joint(mesh: TetMesh, *, friction: bool = False) -> MatingFaces:
    """The joint between the first part and the second one, square to x."""
    return MatingFaces.of(mesh, SIDES, backwards, friction=friction)


def backwards(places: Floats) -> Floats:
    """Direction towards smaller x."""
    return np.broadcast_to([-1.0, 0.0, 0.0], places.shape)


def opening(body: AssembledBody, load: int, highest: float) -> float:
    """The load, below the `highest`, that leaves no pressure at one vertex of the joint."""
    unit = np.eye(2)[load]
    low, high = 0.0, highest
    while high - low > 1e-11 * highest:
        middle = (low + high) / 2
        closed = not body.step(middle * unit).guess.opened.any()
        low, high = (middle, high) if closed else (low, middle)
    return high


def _tube(first: float, last: float, seats: tuple[Surface | None, Surface | None]) -> Revolution:
    """Half of the tube, along z."""
    corners = [((HOLE / 2, first), seats[0] or Surface.FREE)]
    if seats[0]:
        corners.append(((SEAT / 2, first), Surface.FREE))
    corners += [((TUBE / 2, first), Surface.FREE), ((TUBE / 2, last), Surface.FREE)]
    if seats[1]:
        corners.append(((SEAT / 2, last), seats[1]))
    return Revolution(polygon(*corners, ((HOLE / 2, last), Surface.FREE)))


def tube(size: float) -> TetMesh:
    """A quarter of both halves of the tube, joined, along x."""
    halves = (
        _tube(-HALF_GRIP, 0.0, (Surface.BOLT_THREAD, None)),
        _tube(0.0, HALF_GRIP, (None, Surface.BOLT_HEAD)),
    )
    seats = {seat: Fine(0.6 * size) for seat in (Surface.BOLT_THREAD, Surface.BOLT_HEAD)}
    upright = mesh_body(SideBySide(halves), size, fine=seats)
    cuts = {Surface.SYMMETRY_X: Surface.SYMMETRY_Y, Surface.SYMMETRY_Y: Surface.SYMMETRY_Z}
    facets = {cuts.get(surface, surface): rows for surface, rows in upright.facets.items()}
    return parted(replace(upright, points=upright.points[:, [2, 0, 1]], facets=facets), [0.0], along_x)


def parts_compliance(mesh: TetMesh, bolt: BoltPull) -> float:
    """Mean approach of the seats of a bolt force of 1 N on the tube without a joint, mm/N."""
    forces, fixed = bolt.nodal_forces.reshape(-1, 3), held(mesh, {})
    fixed[np.abs(mesh.points[:, 0]).argmin(), 0] = True
    u = displacement(replace(mesh, part=None), STEEL, forces, fixed)[..., 0]
    return float((forces * u).sum() / bolt.share)


def _diagram(mesh: TetMesh, compliance: float) -> float:
    """Force of a bolt of four times the parts' compliance over that of the joint diagram."""
    halves = separated(mesh, {(0, 1): SIDES})[0]
    bolt = pulled(halves, 1 / (4 * compliance), share=0.25)
    apart_by = -bolt.nodal_forces.reshape(-1, 3, 1)
    body = AssembledBody(halves, (STEEL, STEEL), [joint(halves)], [bolt], apart_by, preload=[PRELOAD])
    tension = float(body.tension(body.step([LOAD]))[0])
    return tension / (PRELOAD + LOAD / 5)


def compute(size: float) -> Computed:
    """Solve block and tube with elements of `size`."""
    body = block(size)
    state = body.step([LOAD, 0.0])
    weights = body.problem.faces[0].pressing.weights
    whole = tube(size)
    compliance = parts_compliance(whole, pulled(whole, 1.0, share=0.25))
    found = {
        BOLT: body.tension(state)[0],
        JOINT: 2 * weights @ body.stresses(state)[0],
        OPENING: opening(body, 0, 2 * PRELOAD),
        OPEN: body.tension(body.step([2 * PRELOAD, 0.0]))[0],
        EDGE: opening(body, 1, 2 * PRELOAD),
        DIAGRAM: _diagram(whole, compliance),
    }
    return Computed({goal.quantity: float(value) for goal, value in found.items()}, whole.points.size)


BENCHMARK = Benchmark(
    title="Bolted joints: block and tube",
    source="VDI 2230-1:2015, section 3.2 and 5.1; strength of materials",
    goals=(BOLT, JOINT, OPENING, OPEN, EDGE, DIAGRAM),
    compute=compute,
    size=3.0,
    converges=False,
)
