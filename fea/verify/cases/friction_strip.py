"""A strip in friction: stick and slip under a force that grows, turns round and comes back.

A strip of stiffness E A between two rigid plates that press on it holds a force at its end by friction: it
slips over the length l = F / q, where q is the friction per length, and its end moves by F² / (2 E A q). When
the force turns round at F₁, the strip slips back from its end with twice the friction: the end moves by
(F₁ − F)² / (4 E A q), so that a closed cycle between ±F₁ costs the energy 2 F₁³ / (3 E A q) (Goodman & Klumpp
1956; Masing 1926). With ν = 0 the slipping part is an exact solution of plane elasticity; where slip ends the
strip is sheared over about its thickness, which beam theory leaves out.
"""

import numpy as np

from fea.base.material import Material
from fea.contact.friction_system import ContactState
from fea.contact.interfaces import MatingFaces
from fea.solid.traction import traction_forces
from fea.verify.assembled_body import AssembledBody
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.parted import apart
from geometry.arrays import Floats
from geometry.bodies import Prism, SideBySide, polygon
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

# Half the thickness of the strip, and that of a plate, its length, mm; pressure, MPa.
HALF, LENGTH, PRESSURE, FRICTION = 0.25, 20.0, 50.0, 0.2
LOWER = Surface.JOINT, Surface.JOINT_CAP
UPPER = Surface.SHELL_SEAT, Surface.SHELL_BACK
STRIP, PLATE = Material(70e3, 0.0, 2.7e-9, 400.0), Material(70e7, 0.0, 2.7e-9, 400.0)
# Steps from no force to F₁.
STEPS = 10

_BEAM = "the strip is sheared over about its thickness where slip ends, a fortieth of the slipping length"


def exact(width: float) -> tuple[float, float]:
    """Force F₁ under which half of the strip slips, N, and the movement of its end, mm, at a width, mm."""
    friction = 2 * FRICTION * PRESSURE * width
    force = friction * LENGTH / 2
    return force, force**2 / (2 * STRIP.youngs_modulus * 2 * HALF * width * friction)


_MOVED = exact(1.0)[1]
PULLED = Goal("movement of the end, F₁", "mm", _MOVED, 1.0, _BEAM)
SLIPPED = Goal("length that slips, F₁", "mm", LENGTH / 2, 3.0, "the distance of two vertices, 0.25 mm")
RELEASED = Goal("movement left after F₁", "mm", _MOVED / 2, 1.0, _BEAM)
PUSHED = Goal("movement of the end, −F₁", "mm", -_MOVED, 1.0, _BEAM)
LOST = Goal("energy of a cycle / (F₁ u₁)", "1", 4 / 3, 1.5, f"{_BEAM}; steps of a tenth of F₁")
AGAIN = Goal(
    "movement of the end, second cycle over the first",
    "1",
    1.0,
    1e-6,
    "a cycle of friction repeats itself; only rounding errors remain",
)


def drawn(size: float) -> TetMesh:
    """A plate, the strip on it and the other plate: a slice that is `size` thick."""

    def bar(low: float, high: float, below: Surface, above: Surface, ends: tuple[Surface, Surface]) -> Prism:
        start, end = ends
        corners = (((0.0, low), below), ((LENGTH, low), end), ((LENGTH, high), above), ((0.0, high), start))
        return Prism(polygon(*corners), (0.0, size))

    free, held = Surface.FREE, (Surface.CLAMPED, Surface.FREE)
    lower = bar(-2 * HALF, -HALF, Surface.OUTER, free, held)
    strip = bar(-HALF, HALF, free, free, (free, Surface.LOADED))
    upper = bar(HALF, 2 * HALF, free, Surface.OUTER, held)
    interfaces = {(0, 1): LOWER, (1, 2): UPPER}
    return apart(SideBySide((lower, strip, upper)), size, [-HALF, HALF], along_y, interfaces)


def along_y(places: Floats) -> Floats:
    """Measure of parts that lie on top of each other."""
    return places[..., 1]


def downwards(places: Floats) -> Floats:
    """Direction towards smaller y."""
    return np.broadcast_to([0.0, -1.0, 0.0], places.shape)


class Strip:
    """The strip between its plates, pulled step by step."""

    def __init__(self, size: float) -> None:
        mesh = drawn(size)
        area = 4 * HALF * size  # of the whole strip, and of both plates
        press = traction_forces(mesh, Surface.OUTER, lambda _, normals: -PRESSURE * normals)
        pull = sum(
            traction_forces(mesh, end, lambda _, normals: normals / area)
            for end in (Surface.LOADED, Surface.CLAMPED)
        )
        faces = [MatingFaces.of(mesh, sides, downwards) for sides in (LOWER, UPPER)]
        loads = np.stack([press, np.asarray(pull)], axis=-1)
        self.body = AssembledBody(mesh, (PLATE, STRIP, PLATE), faces, [], loads, friction=FRICTION)
        self._pull, self.force = np.asarray(pull), exact(2 * size)[0]
        self.state, self.pulled = self.body.step([1.0, 0.0]), 0.0

    def go(self, force: float) -> list[tuple[float, float]]:
        """Change the force, relative to F₁, in steps; forces, N, and movements, mm, at their ends."""
        found = []
        for share in np.linspace(self.pulled, force, round(STEPS * abs(force - self.pulled)) + 1)[1:]:
            self.state = self.body.step([1.0, share * self.force], self.state)
            found.append((share * self.force, self._moved(self.state, share * self.force)))
        self.pulled = force
        return found

    def _moved(self, state: ContactState, force: float) -> float:
        """Movement of the strip's end relative to the plates, from the work of the forces."""
        return 2 * float((self._pull * self.body.displacement(state, [1.0, force])).sum())

    def slipping(self) -> float:
        """Length from the end over which all friction is used up, mm."""
        pressure, along, around = self.body.stresses(self.state)
        sticks = np.hypot(along, around) < FRICTION * pressure * (1 - 1e-6)
        nodes = self.body.problem.faces[0].pressing.nodes
        return LENGTH - float(self.body.mesh.points[nodes[sticks], 0].max(initial=0.0))


def compute(size: float) -> Computed:
    """Pull, push and pull again with elements of `size`."""
    strip = Strip(size)
    first = strip.go(1.0)
    found = {PULLED: first[-1][1], SLIPPED: strip.slipping()}
    cycle = [first[-1], *strip.go(0.0), *strip.go(-1.0), *strip.go(0.0), *strip.go(1.0)]
    found |= {RELEASED: cycle[STEPS][1], PUSHED: cycle[2 * STEPS][1]}
    again = [*strip.go(0.0), *strip.go(-1.0)]
    force, moved = np.array(cycle).T
    found[LOST] = -float(np.trapezoid(moved, force)) / (first[-1][0] * first[-1][1])
    found[AGAIN] = again[-1][1] / cycle[2 * STEPS][1]
    return Computed({goal.quantity: value for goal, value in found.items()}, strip.body.mesh.points.size)


BENCHMARK = Benchmark(
    title="Strip in friction: stick and slip in a cycle",
    source="Goodman & Klumpp 1956; Masing 1926",
    goals=(PULLED, SLIPPED, RELEASED, PUSHED, LOST, AGAIN),
    compute=compute,
    size=0.25,
    converges=False,
)
