"""Press fits and bolted joints: Lamé's fits, prismatic blocks, a clamped tube."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fea.base.material import Material
from fea.contact.assembled import TemperatureChange
from fea.contact.assembly_state import BoltBeam
from fea.contact.bolts import BoltBending, BoltEnds, BoltPull
from fea.contact.friction_system import ContactState
from fea.contact.interfaces import MatingFaces, radial
from fea.solid.traction import Traction, traction_forces
from fea.solvers.static import displacement
from fea.verify.assembled_body import AssembledBody, along_x, apart, bars, parted, pulled, radius
from fea.verify.benchmark import Quantities, Quantity, benchmark
from fea.verify.body import STEEL, furthest, half_ring, held, hoop_stress, nodes_of, uniform
from fea.verify.michell import displacement as wave_displacement
from fea.verify.michell import stresses
from geometry.arrays import Floats
from geometry.bodies import Prism, Revolution, SideBySide, polygon
from geometry.surfaces import Surface
from mesh.generate import LocalSize, mesh_body
from mesh.tetmesh import TetMesh, separated


@dataclass(frozen=True)
class _Fit:
    """A ring pressed into another one, in plane stress, without friction."""

    radii: tuple[float, float, float]  #: of the bore, the fit and the outside, mm
    materials: tuple[Material, Material]  #: of the inner and of the outer ring
    interference: float  #: of the radii, mm
    sides: tuple[Surface, Surface]  #: surfaces of the outer and of the inner ring at the fit

    def pressure(self, interference: float) -> float:
        """Pressure of an interference (Lamé 1852), MPa."""
        (a, b, c), (inner, outer) = self.radii, self.materials
        around = (c * c + b * b) / (c * c - b * b) + outer.poissons_ratio
        within = (b * b + a * a) / (b * b - a * a) - inner.poissons_ratio
        return interference / (b / outer.youngs_modulus * around + b / inner.youngs_modulus * within)

    def michell_share(self) -> float:
        """Amplitude of the pressure of the fit over q, under a pressure q cos 2φ in the bore.

        The stress functions of both rings are solved for stresses that are given inside and outside, and for
        pressures and radial displacements that agree at the fit, without shear.
        """
        a, b, c = self.radii
        rows, side = np.zeros((8, 8)), np.zeros(8)
        inner, outer = slice(0, 4), slice(4, 8)
        radial, _, shear = stresses(np.array([a, b, b, c]), 2)
        for row, ring in enumerate((inner, inner, outer, outer)):
            rows[row, ring] = shear[row]
        rows[4, inner], side[4] = radial[0], -1.0
        rows[5, outer] = radial[3]
        rows[6, inner], rows[6, outer] = radial[1], -radial[1]
        rows[7, inner] = wave_displacement(self.materials[0], b, 2)
        rows[7, outer] = -wave_displacement(self.materials[1], b, 2)
        # The functions differ by powers of the radius.
        scale = np.abs(rows).max(axis=0)
        factors = np.linalg.solve(rows / scale, side) / scale
        return float(abs(radial[1] @ factors[inner]))


_STEEL, _BRONZE = Material(207e3, 0.3, 7.85e-9, 500.0), Material(110e3, 0.34, 8.8e-9, 200.0)
_SEATS = {
    "bushing": (Surface.BUSHING_SEAT, Surface.BUSHING_BACK),
    "shell": (Surface.SHELL_SEAT, Surface.SHELL_BACK),
}
_BUSHING = _Fit((11.0, 12.5, 17.5), (_BRONZE, _STEEL), 0.02, _SEATS["bushing"])
_SHELL = _Fit((24.0, 25.5, 33.0), (_STEEL, _STEEL), 0.03, _SEATS["shell"])
_EXPANSIONS, _WARMER = (18e-6, 11.5e-6), 100.0  # of bronze and of steel, 1/K; K


def _fitted(
    fit: _Fit, size: float, *, warmer: float = 0.0, loads: Callable[[TetMesh], Floats] | None = None
) -> AssembledBody:
    halves = [half_ring(*pair) for pair in pairwise(fit.radii)]
    rings = SideBySide(tuple(Prism((*sides[2:], *sides[:2]), (0.0, 1.0)) for sides in halves))
    mesh = apart(rings, size, fit.radii[1:2], radius, {(1, 0): fit.sides})
    face = MatingFaces.of(mesh, fit.sides, radial(0.0), interference=fit.interference, friction=False)
    applied = np.zeros((*mesh.points.shape, 0)) if loads is None else loads(mesh)
    warming = None
    if warmer:
        growth = np.zeros(len(mesh.points))
        for part, expansion in enumerate(_EXPANSIONS):
            growth[np.unique(mesh.tets[mesh.part == part])] = expansion * warmer
        warming = TemperatureChange((growth[:, None] * mesh.points).ravel(), np.zeros(0), ())
    return AssembledBody(mesh, fit.materials, [face], [], applied, warming=warming)


def _waves(mesh: TetMesh) -> Floats:
    """Nodal forces (n_nodes, 3, 2) of 1 MPa times cos φ, which the outside reacts, and times cos 2φ."""
    a, _, c = _BUSHING.radii

    def pressing(order: int, size: float) -> Callable[[Floats, Floats], Floats]:
        def stress(places: Floats, normals: Floats) -> Floats:
            angle = np.arctan2(places[..., 1:2], places[..., :1])
            return np.asarray(-size * np.cos(order * angle) * normals)

        return stress

    inside = [traction_forces(mesh, Surface.INNER, pressing(order, 1.0)) for order in (1, 2)]
    outside = traction_forces(mesh, Surface.OUTER, pressing(1, a / c))
    return np.stack([inside[0] + outside, inside[1]], axis=-1)


def _fit_stresses(name: str, fit: _Fit, body: AssembledBody) -> Iterator[Quantity]:
    """Pressure and hoop stresses of a fit, each at its worst node."""
    (a, b, c), p = fit.radii, fit.pressure(fit.interference)
    inner, outer = body.stress(body.start)

    def hoop(stress: Floats, surface: Surface) -> Floats:
        nodes = nodes_of(body.mesh, surface, Surface.SYMMETRY_Z)
        return hoop_stress(body.mesh.points[nodes], stress[nodes])

    within = p / (b * b - a * a)
    stresses = {
        "pressure of the fit": (p, body.stresses(body.start)[0]),
        "hoop stress of its seat": (p * (c * c + b * b) / (c * c - b * b), hoop(outer, fit.sides[0])),
        "hoop stress of its back": (-within * (b * b + a * a), hoop(inner, fit.sides[1])),
        "hoop stress of its bore": (-within * 2 * b * b, hoop(inner, Surface.INNER)),
    }
    why = "the mesh; at the worst node, as rings of flat-sided elements are not quite even"
    for what, (target, values) in stresses.items():
        yield Quantity(f"{name}: {what}", "MPa", target, furthest(values, target), 0.5, why)


def _mean_pressure(body: AssembledBody) -> float:
    return float(np.average(body.stresses(body.start)[0], weights=body.problem.faces[0].pressing.weights))


def _amplitude(body: AssembledBody) -> float:
    """Amplitude of cos 2φ in the pressure of the fit under 1 MPa of it in the bore."""
    added = body.stresses(body.step([0.0, 1.0]))[0] - body.stresses(body.start)[0]
    pressing = body.problem.faces[0].pressing
    x, y, _ = body.mesh.points[pressing.nodes].T
    wave = np.cos(2 * np.arctan2(y, x))
    return float((pressing.weights * wave) @ added / ((pressing.weights * wave) @ wave))


def _opening(body: AssembledBody, load: int, highest: float, accuracy: float) -> float:
    """The load, below the `highest`, under which the first vertex of an interface loses its pressure."""
    unit, low, high = np.eye(2)[load], 0.0, highest
    while high - low > accuracy * highest:
        middle = (low + high) / 2
        opened = body.step(middle * unit).guess.opened.any()
        low, high = (low, middle) if opened else (middle, high)
    return high


@benchmark("Lamé 1852; Michell 1899; Timoshenko & Goodier 1970, articles 28 and 43", size=0.6)
def lame_fit(size: float) -> Quantities:
    """Lamé: press fits of a bushing and of a bearing shell.

    Lamé's pressure of a bushing and of a larger bearing shell, its change with temperature, and lift-off.
    Both rings are in plane stress: the fields of a fit alone do not vary along the axis. With the
    interference δ of the radii at b, between the radii a and c,

        p = δ / {b/E_o [(c² + b²)/(c² − b²) + ν_o] + b/E_i [(b² + a²)/(b² − a²) − ν_i]}.

    A change of temperature adds b Δα ΔT to δ. A pressure q cos nφ in the bore adds one of the same order to
    the fit: for n = 1 that is q a / b cos φ by statics, however stiff the rings are, and the fit lifts off
    where the sum first vanishes; for n = 2, which bends the rings, the stress functions of Michell (1899)
    give it.
    """
    bushing, shell = _fitted(_BUSHING, size, loads=_waves), _fitted(_SHELL, 1.6 * size)
    warmed = _mean_pressure(_fitted(_BUSHING, size, warmer=_WARMER)) - _mean_pressure(bushing)
    a, b, _ = _BUSHING.radii
    lift = _BUSHING.pressure(_BUSHING.interference) * b / a
    warm = _BUSHING.pressure(b * (_EXPANSIONS[0] - _EXPANSIONS[1]) * _WARMER)
    first = "the mesh; the least even place lifts off first"
    out_of_plane = "the rings bend out of their plane, too, which plane stress leaves out"
    lifted = _opening(bushing, 0, 2 * lift, 1e-5)
    name, amplitude = "amplitude of the fit's pressure / q, under q cos 2φ in its bore", _amplitude(bushing)
    yield from _fit_stresses("bushing", _BUSHING, bushing)
    yield from _fit_stresses("shell", _SHELL, shell)
    yield Quantity("bushing: change of the mean pressure, 100 K warmer", "MPa", warm, warmed, 0.1, "the mesh")
    yield Quantity("bushing: pressure q cos φ in its bore that lifts it off", "MPa", lift, lifted, 1.0, first)
    yield Quantity(f"bushing: {name}", "1", _BUSHING.michell_share(), amplitude, 0.5, out_of_plane)
    return max(bushing.mesh.points.size, shell.mesh.points.size)


SIDES = (Surface.JOINT, Surface.JOINT_CAP)
# The prismatic block: ends, half of its width, height of the half z ≥ 0, mm; preload and load, N.
_ENDS, HALF_WIDTH, _HEIGHT, _ECCENTRICITY = (0.0, 15.0, 40.0), 8.0, 6.0, 1.5
PRELOAD, _LOAD = 5000.0, 3000.0
_AREA, _MOMENT = 4 * HALF_WIDTH * _HEIGHT, 2 * _HEIGHT * (2 * HALF_WIDTH) ** 3 / 12
STIFFNESS, _SHARE = 0.2 * STEEL.youngs_modulus * _AREA / (_ENDS[-1] - _ENDS[0]), 0.2 / 1.2
# The eccentric load that opens the edge, N.
EDGE = PRELOAD / (1 - _SHARE + _ECCENTRICITY * HALF_WIDTH * _AREA / _MOMENT)


def joint(mesh: TetMesh, *, friction: bool = False) -> MatingFaces:
    """The joint between the first part and the second one, square to x."""
    return MatingFaces.of(mesh, SIDES, uniform(-1.0, 0.0, 0.0), friction=friction)


def _loaded_block(size: float, *stresses: Traction) -> tuple[TetMesh, Floats]:
    """The block, and nodal forces (n_nodes, 3, n) of stresses on both of its ends."""
    body, ends = bars(_ENDS, (-HALF_WIDTH, HALF_WIDTH), _HEIGHT), (Surface.BOLT_HEAD, Surface.BOLT_THREAD)
    mesh = apart(body, size, _ENDS[1:-1], along_x, {(0, 1): SIDES})
    loads = [sum(traction_forces(mesh, end, stress) for end in ends) for stress in stresses]
    return mesh, np.stack(loads, axis=-1)


def _pulling(eccentricity: float) -> Traction:
    """The stress of 1 N that pulls beside the axis."""
    return lambda places, normals: normals * (1 / _AREA + eccentricity * places[..., 1:2] / _MOMENT)


def bolted_block(size: float) -> AssembledBody:
    """The block with its bolt; the loads are a centric and an eccentric one of 1 N."""
    mesh, loads = _loaded_block(size, _pulling(0.0), _pulling(_ECCENTRICITY))
    bolt = pulled(mesh, STIFFNESS, share=0.5)
    return AssembledBody(mesh, (STEEL, STEEL), [joint(mesh)], [bolt], loads, preload=[PRELOAD])


def _tube(size: float) -> TetMesh:
    """A quarter of both halves of a tube, joined, along x: for a bolt M10 with a grip of 40 mm."""
    hole, seat, outside, half_grip = 11.0, 16.0, 24.0, 20.0

    def half(first: float, last: float, seats: tuple[Surface | None, Surface | None]) -> Revolution:
        corners = [((hole / 2, first), seats[0] or Surface.FREE)]
        if seats[0]:
            corners.append(((seat / 2, first), Surface.FREE))
        corners += [((outside / 2, first), Surface.FREE), ((outside / 2, last), Surface.FREE)]
        if seats[1]:
            corners.append(((seat / 2, last), seats[1]))
        return Revolution(polygon(*corners, ((hole / 2, last), Surface.FREE)))

    halves = (
        half(-half_grip, 0.0, (Surface.BOLT_THREAD, None)),
        half(0.0, half_grip, (None, Surface.BOLT_HEAD)),
    )
    fine = {end: LocalSize(0.6 * size) for end in (Surface.BOLT_THREAD, Surface.BOLT_HEAD)}
    upright = mesh_body(SideBySide(halves), size, fine=fine)
    cuts = {Surface.SYMMETRY_X: Surface.SYMMETRY_Y, Surface.SYMMETRY_Y: Surface.SYMMETRY_Z}
    facets = {cuts.get(surface, surface): rows for surface, rows in upright.facets.items()}
    return parted(replace(upright, points=upright.points[:, [2, 0, 1]], facets=facets), [0.0], along_x)


def _parts_compliance(mesh: TetMesh, bolt: BoltPull) -> float:
    """Mean approach of the seats of a bolt force of 1 N on the tube without a joint, mm/N."""
    forces, fixed = bolt.nodal_forces.reshape(-1, 3), held(mesh, {})
    fixed[np.abs(mesh.points[:, 0]).argmin(), 0] = True
    u = displacement(replace(mesh, part=None), STEEL, forces, fixed)[..., 0]
    return float((forces * u).sum() / bolt.share)


@benchmark("VDI 2230-1:2015, section 3.2 and 5.1; strength of materials", size=3.0)
def bolted_joint(size: float) -> Quantities:
    """Bolted joints: block and tube.

    Prismatic blocks, centric and eccentric, and the joint diagram of a clamped tube.
    Of a prismatic block that a bolt compresses evenly, the load acting where the bolt does, the stress is
    linear over the section. With the stiffness k_B of the bolt and k_P = E A / l of the block, Φ = k_B / (k_B
    + k_P): the bolt carries F_V + Φ F and the joint F_V − (1 − Φ) F, until at an eccentricity e the edge at c
    opens where F_V = F (1 − Φ + e c A / I). Of a tube between the head and the nut of a bolt, the compliance
    is found on the same mesh without a joint, from the mean approach of its seats: VDI 2230's joint diagram,
    in which bolt and parts are measured alike.
    """
    block, tube = bolted_block(size), _tube(size)
    state = block.step([_LOAD, 0.0])
    on_joint = 2 * block.problem.faces[0].pressing.weights @ block.stresses(state)[0]
    open_state = block.step([2 * PRELOAD, 0.0])
    centric, eccentric = (_opening(block, load, 2 * PRELOAD, 1e-11) for load in (0, 1))
    exact = "the stress is linear, which the elements contain; only rounding errors remain"
    forces = {
        "block: bolt force": (PRELOAD + _SHARE * _LOAD, block.tension(state)[0]),
        "block: force in the joint": (PRELOAD - (1 - _SHARE) * _LOAD, on_joint),
        "block: load that opens the joint": (PRELOAD / (1 - _SHARE), centric),
        "block: bolt force, joint open": (2 * PRELOAD, block.tension(open_state)[0]),
        "block, eccentric load: load that opens the edge": (EDGE, eccentric),
    }
    compliance = _parts_compliance(tube, pulled(tube, 1.0, share=0.25))
    halves = separated(tube, {(0, 1): SIDES})[0]
    bolt = pulled(halves, 1 / (4 * compliance), share=0.25)
    loads = -bolt.nodal_forces.reshape(-1, 3, 1)
    body = AssembledBody(halves, (STEEL, STEEL), [joint(halves)], [bolt], loads, preload=[PRELOAD])
    ratio = float(body.tension(body.step([_LOAD]))[0]) / (PRELOAD + _LOAD / 5)
    name = "tube: bolt force / VDI 2230's joint diagram"
    why = "one mesh gives both compliances, and the joint stays closed; solving leaves rounding errors"
    for what, (target, force) in forces.items():
        yield Quantity(what, "N", target, float(force), 1e-6, exact)
    yield Quantity(name, "1", 1.0, ratio, 1e-4, why)
    return tube.points.size


# Of the bolt beside the block's axis: diameter, distance, that of the load, mm; this load and one across, N.
_DIAMETER, _BESIDE, _LOAD_AT, _PULL, _ACROSS = 6.0, 1.5, -1.5, 1000.0, 400.0
_LENGTH = _ENDS[-1] - _ENDS[0]


def _bent_bolt() -> tuple[BoltBeam, float, float]:
    """A round bar as bolt, with L/(E I) and its section modulus."""
    moment, modulus = math.pi / 64 * _DIAMETER**4, math.pi / 32 * _DIAMETER**3
    turn, area = _LENGTH / (STEEL.youngs_modulus * moment), math.pi / 4 * _DIAMETER**2
    flexibility = turn / 6 * np.array([[2.0, -1.0], [-1.0, 2.0]])
    ends = np.array([0.0, 1.0])
    return BoltBeam(flexibility, ends, np.full(2, area), np.full(2, modulus)), turn, modulus


def _eccentric_block(size: float) -> tuple[AssembledBody, BoltBending]:
    """The block with a bolt beside its axis; loads of 1 N pull beside it, too, and across its ends."""

    def shearing(places: Floats, normals: Floats) -> Floats:
        off, y = places[..., :1] - _LENGTH / 2, places[..., 1:2]
        shear = -(HALF_WIDTH**2 - y**2) / (2 * _MOMENT)
        along, none = normals[..., :1], np.zeros_like(y)
        return np.concatenate([-off * y / _MOMENT * along, shear * along, none], axis=-1)

    mesh, loads = _loaded_block(size, _pulling(_LOAD_AT), shearing)
    seats = {side: np.arange(len(mesh.facets[side])) for side in (Surface.BOLT_HEAD, Surface.BOLT_THREAD)}
    at, axis = np.array([0.0, _BESIDE, 0.0]), np.array([1.0, 0.0, 0.0])
    bolt = BoltPull.of(mesh, seats, axis, STIFFNESS, share=0.5, point=at)
    sticking = joint(mesh, friction=True)
    assembled = AssembledBody(
        mesh, (STEEL, STEEL), [sticking], [bolt], loads, friction=0.9, preload=[PRELOAD]
    )
    seated = BoltEnds(seats, at + _LENGTH * axis, at, 0.5)
    return assembled, BoltBending(assembled.model, assembled.assembled, [seated], _bent_bolt()[0])


def _bent_joint() -> tuple[float, float, float]:
    """Force, and bending moment before and under load, of the bolt that pulls and bends the block."""
    E, e, a = STEEL.youngs_modulus, _BESIDE, _LOAD_AT
    along, turn, bolt_turn = _LENGTH / (E * _AREA), _LENGTH / (E * _MOMENT), _bent_bolt()[1]
    first = PRELOAD * e * turn / (bolt_turn + turn)
    # Of the force gained and the moment: length of the bolt and of the block along its axis, and their turns.
    matrix = [[1 / STIFFNESS + along + e * e * turn, -e * turn], [-e * turn, bolt_turn + turn]]
    gained, moment = np.linalg.solve(
        matrix, [_PULL * (along + a * e * turn) - e * turn * first, (PRELOAD * e - _PULL * a) * turn]
    )
    return PRELOAD + float(gained), first, float(moment)


def _sheared_bolt() -> float:
    """Moment on either end of the bolt beside a block that is sheared (Timoshenko's beam, Cowper's κ)."""
    E, nu = STEEL.youngs_modulus, STEEL.poissons_ratio
    shear_area = 10 * (1 + nu) / (12 + 11 * nu) * _AREA
    turn = _LENGTH**2 / (12 * E * _MOMENT) + 2 * (1 + nu) / (E * shear_area)
    return _ACROSS * turn / (_bent_bolt()[1] / 6 + 2 / _LENGTH * turn)


@benchmark("VDI 2230-1:2015, sections 3.2 and 5.3; Timoshenko 1921; Cowper 1966", size=3.0)
def bent_bolt(size: float) -> Quantities:
    """Bolts that bend: an eccentric bolt and one in a sheared block.

    A round bolt in a slot of a prismatic block, beside its axis, whose ends follow those of the block.
    At the distance e of the axes the force F and a load P at a turn the ends of the block by (F e − P a − M)
    L / (E I); they bend the bolt, whose constant moment M turns them back: M = (F e − P a) β_P / (β_S + β_P)
    with β = L / (E I). In the closed form M changes F, too, which is left out here. Transverse loads Q on
    the ends that bend the block into an S turn both ends by Q L² / (12 E I) + Q / (κ G A) against the line
    between them, and the bolt likewise.
    """
    body, bending = _eccentric_block(size)
    force, first, moment = _bent_joint()
    modulus = _bent_bolt()[2]

    def in_bolt(state: ContactState) -> Floats:
        return bending.beam.bending(bending.moments(state)[0])[:, 0]

    before, loaded = body.start, body.step([_PULL, 0.0])
    across = in_bolt(body.step([0.0, _ACROSS])) - in_bolt(before)
    little = "what bending does to the force is left out, and the average over the seats is that of the mesh"
    kappa = "Timoshenko's beam has plane sections, and the traction on the ends is that of a thin block"
    rows = {
        "eccentric bolt: bending stress": (first / modulus, np.abs(in_bolt(before)).max(), little),
        "eccentric bolt and load: bending stress": (moment / modulus, np.abs(in_bolt(loaded)).max(), little),
        "sheared block: bending stress": (_sheared_bolt() / modulus, np.abs(across).max(), kappa),
    }
    for name, (target, computed, why) in rows.items():
        yield Quantity(name, "MPa", target, float(computed), 1.0, why)
    yield Quantity("eccentric bolt and load: bolt force", "N", force, body.tension(loaded)[0], 1.0, little)
    return body.mesh.points.size
