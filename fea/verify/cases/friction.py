"""Parts in friction: a joint's patch test, a strip between plates, a pin in a sheet."""

import math

import numpy as np

from fea.base.material import Material
from fea.contact.interfaces import MatingFaces, radial
from fea.solid.stress import matrices
from fea.solid.traction import traction_forces
from fea.verify.assembled_body import AssembledBody, along_x, apart, radius
from fea.verify.benchmark import Quantities, Quantity, benchmark
from fea.verify.body import STEEL, furthest, hoop_stress, nodes_of, pressure, rectangle, uniform
from fea.verify.cases.assemblies import SIDES, joint
from fea.verify.cases.contact import ALUMINIUM
from fea.verify.cases.elasticity import ROUNDING
from geometry.bodies import Prism, Side, SideBySide
from geometry.segments import Arc, Line
from geometry.surfaces import Surface

_FREE = Surface.FREE


@benchmark("Taylor & Papadopoulos 1991, On a patch test for contact problems in two dimensions", size=0.2)
def joint_patch(size: float) -> Quantities:
    """Patch test of a joint with friction on an irregular mesh.

    A constant stress, with shear in the joint, passes from one block to the other.
    The shear in the joint is half of its pressure.
    """
    middle, end, width, height = 0.4, 1.0, 0.6, 0.5
    stress = np.array([-100.0, 60.0, 35.0, 40.0, -25.0, 30.0])  # XX YY ZZ XY YZ XZ, MPa
    tensor = matrices(stress)
    for order in (1, 2):
        blocks = tuple(
            Prism(rectangle(x, (0, width), (_FREE,) * 4), (0.0, height), bottom=_FREE)
            for x in ((0.0, middle), (middle, end))
        )
        mesh = apart(SideBySide(blocks), size, [middle], along_x, {(0, 1): SIDES}, order=order)
        loads = traction_forces(mesh, _FREE, lambda _, normals: np.asarray(normals @ tensor))[..., None]
        body = AssembledBody(mesh, (STEEL, STEEL), [joint(mesh, friction=True)], [], loads, friction=0.8)
        state = body.step([1.0])
        on_joint, along, around = body.stresses(state)
        fields = {
            "pressure of the joint": on_joint / -stress[0],
            "shear stress of the joint": np.hypot(along, around) / np.hypot(stress[3], stress[5]),
            "stress": body.gauss_stress(body.displacement(state, [1.0])) / stress,
        }
        for what, values in fields.items():
            name, worst = f"P{order} {what} / exact, worst place", furthest(values.ravel(), 1.0)
            yield Quantity(name, "1", 1.0, worst, 1e-8, ROUNDING)
    return mesh.points.size


# Half the thickness of the strip, and that of a plate, its length, mm; pressure, MPa.
_HALF, _LENGTH, _PRESSURE, _FRICTION = 0.25, 20.0, 50.0, 0.2
_LOWER = Surface.JOINT, Surface.JOINT_CAP
_UPPER = Surface.SHELL_SEAT, Surface.SHELL_BACK
_STRIP, _PLATE = Material(70e3, 0.0, 2.7e-9, 400.0), Material(70e7, 0.0, 2.7e-9, 400.0)
_STEPS = 10  # from no force to F₁


def _exact_strip(width: float) -> tuple[float, float]:
    """Force F₁ under which half of the strip slips, N, and the movement of its end, mm, at a width, mm."""
    friction = 2 * _FRICTION * _PRESSURE * width
    force = friction * _LENGTH / 2
    return force, force**2 / (2 * _STRIP.youngs_modulus * 2 * _HALF * width * friction)


class _Strip:
    """A slice, `size` thick, of a strip between two plates, pulled step by step."""

    def __init__(self, size: float) -> None:
        outer, held = Surface.OUTER, Surface.CLAMPED

        def bar(y: tuple[float, float], *names: Surface) -> Prism:
            below, end, above, start = names
            return Prism(rectangle((0.0, _LENGTH), y, (below, end, above, start)), (0.0, size))

        lower = bar((-2 * _HALF, -_HALF), outer, _FREE, _FREE, held)
        strip = bar((-_HALF, _HALF), _FREE, Surface.LOADED, _FREE, _FREE)
        upper = bar((_HALF, 2 * _HALF), _FREE, _FREE, outer, held)
        interfaces = {(0, 1): _LOWER, (1, 2): _UPPER}
        stack, up = SideBySide((lower, strip, upper)), lambda places: places[..., 1]
        mesh = apart(stack, size, [-_HALF, _HALF], up, interfaces)
        press = traction_forces(mesh, outer, pressure(_PRESSURE))
        ends = (Surface.LOADED, Surface.CLAMPED)
        self._pull = sum(traction_forces(mesh, end, pressure(-1 / (4 * _HALF * size))) for end in ends)
        faces = [MatingFaces.of(mesh, sides, uniform(0.0, -1.0, 0.0)) for sides in (_LOWER, _UPPER)]
        loads = np.stack([press, np.asarray(self._pull)], axis=-1)
        self.body = AssembledBody(mesh, (_PLATE, _STRIP, _PLATE), faces, [], loads, friction=_FRICTION)
        self.force = _exact_strip(2 * size)[0]
        self.state, self.pulled = self.body.step([1.0, 0.0]), 0.0

    def go(self, force: float) -> list[tuple[float, float]]:
        """Change the force, relative to F₁, in steps; forces, N, and movements, mm, at their ends."""
        path = []
        for share in np.linspace(self.pulled, force, round(_STEPS * abs(force - self.pulled)) + 1)[1:]:
            self.state = self.body.step([1.0, share * self.force], self.state)
            u = self.body.displacement(self.state, [1.0, share * self.force])
            path.append((share * self.force, 2 * float((self._pull * u).sum())))  # by the work of the forces
        self.pulled = force
        return path

    def slipping(self) -> float:
        """Length from the end over which all friction is used up, mm."""
        pressures, along, around = self.body.stresses(self.state)
        sticks = np.hypot(along, around) < _FRICTION * pressures * (1 - 1e-6)
        nodes = self.body.problem.faces[0].pressing.nodes
        return _LENGTH - float(self.body.mesh.points[nodes[sticks], 0].max(initial=0.0))


@benchmark("Goodman & Klumpp 1956; Masing 1926", size=0.25)
def friction_strip(size: float) -> Quantities:
    """Strip in friction: stick and slip in a cycle.

    Stick and slip under a force that grows, turns round and comes back.
    A strip of stiffness E A between two rigid plates that press on it holds a force at its end by friction:
    it slips over the length l = F / q, where q is the friction per length, and its end moves by F² / (2 E A
    q). When the force turns round at F₁, the strip slips back from its end with twice the friction: the end
    moves by (F₁ − F)² / (4 E A q), so that a closed cycle between ±F₁ costs the energy 2 F₁³ / (3 E A q)
    (Goodman & Klumpp 1956; Masing 1926). With ν = 0 the slipping part is an exact solution of plane
    elasticity; where slip ends the strip is sheared over about its thickness, which beam theory leaves out.
    """
    strip, u = _Strip(size), _exact_strip(1.0)[1]
    first = strip.go(1.0)
    slipped = strip.slipping()
    cycle = [first[-1], *strip.go(0.0), *strip.go(-1.0), *strip.go(0.0), *strip.go(1.0)]
    again = [*strip.go(0.0), *strip.go(-1.0)]
    force, moved = np.array(cycle).T
    lost = -float(np.trapezoid(moved, force)) / (first[-1][0] * first[-1][1])
    pushed = cycle[2 * _STEPS][1]
    beam = "the strip is sheared over about its thickness where slip ends, a fortieth of the slipping length"
    vertices = "the distance of two vertices, 0.25 mm"
    repeats = "a cycle of friction repeats itself; only rounding errors remain"
    steps = f"{beam}; steps of a tenth of F₁"
    yield Quantity("movement of the end, F₁", "mm", u, first[-1][1], 1.0, beam)
    yield Quantity("length that slips, F₁", "mm", _LENGTH / 2, slipped, 3.0, vertices)
    yield Quantity("movement left after F₁", "mm", u / 2, cycle[_STEPS][1], 1.0, beam)
    yield Quantity("movement of the end, −F₁", "mm", -u, pushed, 1.0, beam)
    yield Quantity("energy of a cycle / (F₁ u₁)", "1", 4 / 3, lost, 1.5, steps)
    second = "movement of the end, second cycle over the first"
    yield Quantity(second, "1", 1.0, again[-1][1] / pushed, 1e-6, repeats)
    return strip.body.mesh.points.size


# Radii of pin and sheet, length of the sheet from the pin's axis; half of the sheet's thickness, mm; N.
_PIN, _OUTSIDE, _SHEET, _SHEET_HALF, FORCE = 50.0, 100.0, 200.0, 5.0, 100e3
FRICTION = 0.1
_HOLE = Surface.SHELL_SEAT, Surface.SHELL_BACK


def pin_in_sheet(size: float, friction: float = FRICTION) -> AssembledBody:
    """A quarter of pin and sheet; the load is 1 N on the ends of the pin and at the end of the sheet."""
    arc, cut = Arc((0.0, 0.0), _PIN, math.pi, -math.pi), Surface.SYMMETRY_Y
    pin = (Side(arc, _FREE), Side(Line((_PIN, 0.0), (-_PIN, 0.0)), cut))
    sheet = (
        Side(arc, _FREE),
        Side(Line((_PIN, 0.0), (_OUTSIDE, 0.0)), cut),
        Side(Arc((0.0, 0.0), _OUTSIDE, 0.0, math.pi / 2), _FREE),
        Side(Line((0.0, _OUTSIDE), (-_SHEET, _OUTSIDE)), _FREE),
        Side(Line((-_SHEET, _OUTSIDE), (-_SHEET, 0.0)), Surface.CLAMPED),
        Side(Line((-_SHEET, 0.0), (-_PIN, 0.0)), cut),
    )
    longer = Prism(pin, (0.0, _SHEET_HALF, 2 * _SHEET_HALF), top=Surface.LOADED)
    both = SideBySide((longer, Prism(sheet, (0.0, _SHEET_HALF))))
    mesh = apart(both, size, [_PIN], radius, {(1, 0): _HOLE})
    areas = {Surface.LOADED: 2 * math.pi * _PIN**2, Surface.CLAMPED: -4 * _OUTSIDE * _SHEET_HALF}
    pull = sum(traction_forces(mesh, end, uniform(1 / area, 0.0, 0.0)) for end, area in areas.items())
    face = MatingFaces.of(mesh, _HOLE, radial(0.0), friction=friction > 0)
    return AssembledBody(mesh, (STEEL, ALUMINIUM), [face], [], np.asarray(pull)[..., None], friction=friction)


@benchmark(
    "Konter 2006 (NAFEMS R0094), benchmark 4, for the problem; CalculiX 2.20 for the targets", size=5.0
)
def loaded_pin(size: float) -> Quantities:
    """NAFEMS R0094-4: loaded pin with friction.

    A steel pin in friction in the hole of an aluminium sheet, pulled along it.
    The pin fits without clearance, so that the stress grows in proportion to the force, and one step of it is
    exact. The benchmark publishes only curves: the targets are those of CalculiX 2.20 on the same mesh, with
    its penalty contact between faces of 10⁷ MPa/mm and a tenth of it for friction; its displacements go
    through the same recovery of stress. The forces on the pin's ends are spread over them.
    """
    body = pin_in_sheet(size)
    state, mesh = body.step([FORCE]), body.mesh
    u = body.displacement(state, [FORCE])[:, 0]
    pin, sheet = (u[nodes_of(mesh, surface)].mean() for surface in (Surface.LOADED, Surface.CLAMPED))
    nodes = nodes_of(mesh, _HOLE[0], Surface.SYMMETRY_Z)  # in the middle of the sheet
    angle = np.arctan2(mesh.points[nodes, 1], mesh.points[nodes, 0])
    order = np.argsort(angle)
    hoop = hoop_stress(mesh.points[nodes], body.stress(state, [FORCE])[1][nodes])[order]
    soft = "the target's contact is soft; where slip turns round near the force, stresses differ by 2 %"
    name = "movement of the pin's ends from the sheet's end"
    yield Quantity(name, "mm", 0.397671, float(pin - sheet), 0.5, soft)
    yield Quantity("largest hoop stress of the hole", "MPa", 271.173, float(hoop.max()), 1.0, soft)
    for degrees, target in ((30.0, 89.990), (60.0, 129.986), (120.0, 162.133), (180.0, -54.351)):
        stress = float(np.interp(math.radians(degrees), angle[order], hoop))
        yield Quantity(f"hoop stress of the hole at {degrees:g}°", "MPa", target, stress, 1.0, soft)
    return mesh.points.size
