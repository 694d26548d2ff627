"""Press fits of a bushing and of a bearing shell: Lamé's pressure, its change with temperature, and lift-off.

Both rings are in plane stress: the fields of a fit alone do not vary along the axis. With the interference
δ of the radii at b, between the radii a and c,

    p = δ / {b/E_o [(c² + b²)/(c² − b²) + ν_o] + b/E_i [(b² + a²)/(b² − a²) − ν_i]}.

A change of temperature adds b Δα ΔT to δ. A pressure q cos nφ in the bore adds one of the same order to the
fit: for n = 1 that is q a / b cos φ by statics, however stiff the rings are, and the fit lifts off where the
sum first vanishes; for n = 2, which bends the rings, the stress functions of Michell (1899) give it.
"""

from collections.abc import Callable

import numpy as np

from fea.base.material import Material
from fea.contact.assembled import Warming
from fea.contact.interfaces import MatingFaces
from fea.solid.traction import traction_forces
from fea.verify.assembled_body import AssembledBody
from fea.verify.benchmark import Benchmark, Computed, Goal
from fea.verify.body import furthest, nodes_of
from fea.verify.fits import Fit, michell_share
from fea.verify.parted import apart, radius, rings
from geometry.arrays import Floats
from geometry.surfaces import Surface
from mesh.tetmesh import TetMesh

_STEEL, _BRONZE = Material(207e3, 0.3, 7.85e-9, 500.0), Material(110e3, 0.34, 8.8e-9, 200.0)
BUSHING = Fit((11.0, 12.5, 17.5), (_BRONZE, _STEEL), 0.02)
SHELL = Fit((24.0, 25.5, 33.0), (_STEEL, _STEEL), 0.03)
# Of bronze and of steel, 1/K; K.
EXPANSIONS, WARMER = (18e-6, 11.5e-6), 100.0
HEIGHT = 1.0

_SIDES = {
    "bushing": (Surface.BUSHING_SEAT, Surface.BUSHING_BACK),
    "shell": (Surface.SHELL_SEAT, Surface.SHELL_BACK),
}
_MESH = "the mesh; at the worst node, as rings of flat-sided elements are not quite even"


def _goals(name: str, fit: Fit) -> tuple[Goal, ...]:
    a, b, c = fit.radii
    p = fit.pressure(fit.interference)
    stresses = {
        "pressure of the fit": p,
        "hoop stress of its seat": p * (c * c + b * b) / (c * c - b * b),
        "hoop stress of its back": -p * (b * b + a * a) / (b * b - a * a),
        "hoop stress of its bore": -2 * p * b * b / (b * b - a * a),
    }
    return tuple(Goal(f"{name}: {what}", "MPa", value, 0.5, _MESH) for what, value in stresses.items())


_GOALS = {"bushing": _goals("bushing", BUSHING), "shell": _goals("shell", SHELL)}
_GROWTH = BUSHING.radii[1] * (EXPANSIONS[0] - EXPANSIONS[1]) * WARMER
THERMAL = Goal(
    "bushing: change of the mean pressure, 100 K warmer", "MPa", BUSHING.pressure(_GROWTH), 0.1, "the mesh"
)
LIFTED = Goal(
    "bushing: pressure q cos φ in its bore that lifts it off",
    "MPa",
    BUSHING.pressure(BUSHING.interference) * BUSHING.radii[1] / BUSHING.radii[0],
    1.0,
    "the mesh; the least even place lifts off first",
)
OVAL = Goal(
    "bushing: amplitude of the fit's pressure / q, under q cos 2φ in its bore",
    "1",
    michell_share(BUSHING),
    0.5,
    "the rings bend out of their plane, too, which plane stress leaves out",
)


def fitted(
    name: str, fit: Fit, size: float, *, warmer: float = 0.0, loads: Callable[[TetMesh], Floats] | None = None
) -> AssembledBody:
    """A ring pressed into another one."""
    sides = _SIDES[name]
    mesh = apart(rings(fit.radii, HEIGHT), size, fit.radii[1:2], radius, {(1, 0): sides})
    face = MatingFaces.of(mesh, sides, outwards, interference=fit.interference, friction=False)
    applied = np.zeros((*mesh.points.shape, 0)) if loads is None else loads(mesh)
    warming = None
    if warmer:
        growth = np.zeros(len(mesh.points))
        for part, expansion in enumerate(EXPANSIONS):
            growth[np.unique(mesh.tets[mesh.part == part])] = expansion * warmer
        warming = Warming((growth[:, None] * mesh.points).ravel(), np.zeros(0), ())
    return AssembledBody(mesh, fit.materials, [face], [], applied, warming=warming)


def outwards(places: Floats) -> Floats:
    """Direction away from the axis z."""
    away = places * [1.0, 1.0, 0.0]
    return np.asarray(away / np.linalg.norm(away, axis=-1, keepdims=True))


def waves(mesh: TetMesh) -> Floats:
    """Nodal forces (n_nodes, 3, 2) of 1 MPa times cos φ, which the outside reacts, and times cos 2φ."""
    a, _, c = BUSHING.radii

    def pressing(order: int, size: float) -> Callable[[Floats, Floats], Floats]:
        def stress(places: Floats, normals: Floats) -> Floats:
            angle = np.arctan2(places[..., 1:2], places[..., :1])
            return np.asarray(-size * np.cos(order * angle) * normals)

        return stress

    inside = [traction_forces(mesh, Surface.INNER, pressing(order, 1.0)) for order in (1, 2)]
    outside = traction_forces(mesh, Surface.OUTER, pressing(1, a / c))
    return np.stack([inside[0] + outside, inside[1]], axis=-1)


def _figures(name: str, body: AssembledBody) -> dict[str, float]:
    pressure, hoop, back, bore = _GOALS[name]
    inner, outer = body.stress(body.start)
    seat, behind = _SIDES[name]
    around = {
        hoop: _hoop(body.mesh, outer, seat),
        back: _hoop(body.mesh, inner, behind),
        bore: _hoop(body.mesh, inner, Surface.INNER),
    }
    found = {goal.quantity: furthest(values, goal.target) for goal, values in around.items()}
    return found | {pressure.quantity: furthest(body.stresses(body.start)[0], pressure.target)}


def _hoop(mesh: TetMesh, stress: Floats, surface: Surface) -> Floats:
    nodes = nodes_of(mesh, surface, Surface.SYMMETRY_Z)
    angle = np.arctan2(mesh.points[nodes, 1], mesh.points[nodes, 0])
    xx, yy, _, xy, _, _ = stress[nodes].T
    return np.asarray(xx * np.sin(angle) ** 2 + yy * np.cos(angle) ** 2 - xy * np.sin(2 * angle))


def _mean(body: AssembledBody) -> float:
    return float(np.average(body.stresses(body.start)[0], weights=body.problem.faces[0].pressing.weights))


def _lift_off(body: AssembledBody, highest: float) -> float:
    """The pressure q, below the `highest`, under which the first place of the fit opens."""
    low, high = 0.0, highest
    while high - low > 1e-5 * highest:
        middle = (low + high) / 2
        opened = body.step([middle, 0.0]).guess.opened.any()
        low, high = (low, middle) if opened else (middle, high)
    return high


def _amplitude(body: AssembledBody) -> float:
    """Amplitude of cos 2φ in the pressure of the fit under 1 MPa of it in the bore."""
    added = body.stresses(body.step([0.0, 1.0]))[0] - body.stresses(body.start)[0]
    pressing = body.problem.faces[0].pressing
    x, y, _ = body.mesh.points[pressing.nodes].T
    wave = np.cos(2 * np.arctan2(y, x))
    return float((pressing.weights * wave) @ added / ((pressing.weights * wave) @ wave))


def compute(size: float) -> Computed:
    """Solve with elements of `size` on the bushing; those of the shell are larger."""
    bushing, shell = fitted("bushing", BUSHING, size, loads=waves), fitted("shell", SHELL, 1.6 * size)
    found = _figures("bushing", bushing) | _figures("shell", shell)
    warm = fitted("bushing", BUSHING, size, warmer=WARMER)
    found[THERMAL.quantity] = _mean(warm) - _mean(bushing)
    found[LIFTED.quantity] = _lift_off(bushing, 2 * LIFTED.target)
    found[OVAL.quantity] = _amplitude(bushing)
    return Computed(found, max(bushing.mesh.points.size, shell.mesh.points.size))


BENCHMARK = Benchmark(
    title="Lamé: press fits of a bushing and of a bearing shell",
    source="Lamé 1852; Michell 1899; Timoshenko & Goodier 1970, articles 28 and 43",
    goals=(*_GOALS["bushing"], *_GOALS["shell"], THERMAL, LIFTED, OVAL),
    compute=compute,
    size=0.6,
    converges=False,
)
