"""Columba 2022: dynamic forces of the Suzuki Forsa 1 (G10), ESPE Latacunga.

The worksheet solves the 8×8 Newton–Euler system with a gas force of the wrong sign, friction of a fixed
sign and a wrong moment of inertia; the corrected figures come from the closed form. The driving torque T12 is
the negative of the torque on the crank.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from fea.base.units import DEG, KG, KG_M2, M_S, M_S2, N_M, RPM, M
from fea.verify.reproduce.printed import Quantity, Slip, Table, cell, column, records
from geometry.arrays import Floats
from geometry.mass import MassProperties
from loads.dynamics import center_acceleration, cycle
from loads.engine import Engine
from loads.gas import Boyle, GasModel, NoGas
from loads.slider_crank import Kinematics, kinematics


@dataclass(frozen=True)
class Reactions:
    """The eight unknowns in the engine frame, N and N·mm; arrays over the crank angle.

    Crank (2), rod (3) and slider (4) on the frame (1); F_ij is the force of body i on body j and T12 the
    torque that drives the crank (Norton, Design of Machinery, §11.4; Columba 2022). The rows of `solve`:

        crank   F12 + F32 = 0,   T12 + R_crankpin × F32 = 0              (balanced, constant speed)
        rod     F43 − F32 = m₃ a_G,   R_B/G × F43 − R_A/G × F32 = I α
        slider  F14 − F43 + (F_p, 0) = (m₄ ẍ, 0),   F14x = s F14y
    """

    F12x: Floats
    F12y: Floats
    F32x: Floats
    F32y: Floats
    F43x: Floats
    F43y: Floats
    F14y: Floats
    T12: Floats


def solve(
    engine: Engine,
    rod: MassProperties,
    piston_force: npt.ArrayLike,
    friction_ratio: npt.ArrayLike,
    motion: tuple[Floats, float],
) -> Reactions:
    """Solve the system at crank angles (n,), rad, and a speed, rad/s (`motion`).

    `piston_force` is F_p on the slider along engine +x, N, and `friction_ratio` s = F14x/F14y with its sign.
    """
    theta, omega = motion
    k = kinematics(engine, theta, omega)
    r, l = engine.crank_radius, engine.rod_length
    along = np.array([np.cos(k.rod_angle), -np.sin(k.rod_angle)])
    across = np.array([-along[1], along[0]])
    crank_pin = r * np.array([np.cos(theta), np.sin(theta)])
    to_center = rod.center[0] * along + rod.center[1] * across
    a, b = -to_center, l * along - to_center  # crank pin and piston pin from the centre of gravity
    turn, rate = -k.rod_acceleration, k.rod_rate
    a_center = -(omega**2) * crank_pin + turn * np.array([-to_center[1], to_center[0]]) - rate**2 * to_center
    matrix, right = np.zeros((theta.size, 8, 8)), np.zeros((theta.size, 8))
    matrix[:, 0, [0, 2]] = matrix[:, 1, [1, 3]] = 1
    matrix[:, 2, 2], matrix[:, 2, 3], matrix[:, 2, 7] = -crank_pin[1], crank_pin[0], 1
    matrix[:, 3, 4], matrix[:, 3, 2] = 1, -1
    matrix[:, 4, 5], matrix[:, 4, 3] = 1, -1
    matrix[:, 5, 4], matrix[:, 5, 5] = -b[1], b[0]
    matrix[:, 5, 2], matrix[:, 5, 3] = a[1], -a[0]
    matrix[:, 6, 6], matrix[:, 6, 4] = friction_ratio, -1
    matrix[:, 7, 6], matrix[:, 7, 5] = 1, -1
    right[:, 3], right[:, 4] = rod.mass * a_center
    right[:, 5] = rod.inertia_z * turn
    right[:, 6] = engine.piston_mass * k.piston_acceleration - np.asarray(piston_force)
    return Reactions(*np.linalg.solve(matrix, right[..., None])[..., 0].T)


SOURCE = "columba-2022"
SPEEDS = (800, 3200, 5100)

R, L = 38.5, 120.0  # mm
PISTON_AREA = 4254.47  # mm²
PISTON = 0.208  # kg
FRICTION = 0.15
ATMOSPHERE = 0.0739  # MPa, Quito
CLEARANCE = 204.757 - 28.0 - L - R  # mm of cylinder above the piston at TDC
COMPRESSION_RATIO = 1 + 2 * R / CLEARANCE
INERTIA_PRINTED = 0.001308541  # kg·m²
INERTIA = 939740.05e-9  # kg·m², Izz

_CAUSE = (
    "gas force with the wrong sign; friction of a fixed sign; "
    "I = √(Ixx² + Iyy² + Izz²), with transposed digits, instead of Izz = 9.3974e-4 kg·m²"
)
_CAUSE_NO_GAS = _CAUSE.partition("; ")[2]
_AT = "3200 rpm"

_table = partial(Table.of, SOURCE)


def engine(friction: float = FRICTION) -> Engine:
    """Return the printed engine: three cylinders at 240°."""
    bore = math.sqrt(4 * PISTON_AREA / math.pi)
    return Engine(
        crank_radius=R,
        rod_length=L,
        bore=bore,
        piston_mass=PISTON * KG,
        friction=friction,
        cylinders=3,
        phase=240 * DEG,
    )


def rod(inertia: float = INERTIA) -> MassProperties:
    """Return the printed rod with a moment of inertia, kg·m²."""
    zero = (0.0, 0.0, 0.0)
    return MassProperties(0.384 * KG, (31.77, 0.0, 0.0), (zero, zero, (0.0, 0.0, inertia * KG_M2)))


def boyle() -> Boyle:
    """Isothermal compression from the atmosphere of Quito."""
    return Boyle(engine(), COMPRESSION_RATIO, ATMOSPHERE)


def as_published(rpm: float, crank_degrees: Floats, *, gas: bool = True) -> Reactions:
    """Solve the worksheet's system: gas pulls the piston towards the head, F14x = +μ F14y throughout."""
    theta = crank_degrees * DEG
    force = boyle().pressure(theta, np.array(0.0)) * PISTON_AREA if gas else np.zeros_like(theta)
    return solve(engine(), rod(INERTIA_PRINTED), force, np.full_like(theta, FRICTION), (theta, rpm * RPM))


def corrected(rpm: float, crank_degrees: Floats, *, gas: bool = True) -> Mapping[str, Floats]:
    """Return the same quantities from correct mechanics, N and N·m."""
    model: GasModel = boyle() if gas else NoGas()
    c = cycle(engine(), rod(), model, rpm * RPM, crank_degrees * DEG)
    pin, crank = c.in_engine_axes(c.pin), c.in_engine_axes(c.crank)
    return {
        "F12x": crank.x,
        "F12y": crank.y,
        "F32x": -crank.x,
        "F32y": -crank.y,
        "F43x": pin.x,
        "F43y": pin.y,
        "F14y": c.wall,
        "T12": -c.torque / N_M,
    }


def tables() -> list[Table]:
    """All tables."""
    shaking = "columba2022_shaking_3200rpm"
    return [
        _motion(),
        _force_vector(),
        _table(
            "forces",
            "bearing and pin forces at 3200 rpm",
            [_force("columba2022_forces_3200rpm", name) for name in ("F12x", "F12y", "F43x")],
            "At 0° the worksheet adds gas and inertia force, 1326 + 1188 N, although they oppose each other.",
        ),
        _table(
            "shaking",
            "shaking forces at 3200 rpm",
            [
                *(_force(shaking, component, gas=False) for component in ("F12x", "F12y", "F14y")),
                _force(shaking, "F43y", suffix="_with_gas_N"),
            ],
        ),
        _torque(),
        _working_model(),
    ]


_MOTION: dict[str, tuple[str, str, Callable[[Kinematics], Floats]]] = {
    "rod_deg": ("rod angle", "°", lambda k: -k.rod_angle / DEG),
    "piston_position_m": ("piston position", "m", lambda k: k.piston_position / M),
    "piston_velocity_m_s": ("piston velocity", "m/s", lambda k: k.piston_velocity / M_S),
    "rod_angular_velocity_rad_s": ("rod angular velocity", "rad/s", lambda k: -k.rod_rate),
    "piston_acceleration_m_s2": ("piston acceleration", "m/s²", lambda k: k.piston_acceleration / M_S2),
    "rod_angular_acceleration_rad_s2": ("rod angular acceleration", "rad/s²", lambda k: -k.rod_acceleration),
    "gas_force_N": ("gas force", "N", lambda k: boyle().pressure(k.crank_angle, np.array(0.0)) * PISTON_AREA),
    "rod_cg_acceleration_m_s2": (
        "acceleration of the rod's centre of gravity",
        "m/s²",
        lambda k: np.hypot(*center_acceleration(engine(), rod(), k)) / M_S2,
    ),
}


def _motion() -> Table:
    quantities = []
    for title, (name, unit, figure) in _MOTION.items():
        cells = column("columba2022_kinematics_3200rpm", title)
        exact = figure(kinematics(engine(), cells.theta, 3200 * RPM))
        quantities.append(Quantity(name, unit, cells, exact, exact, where=_AT))
    return _table(
        "kinematics",
        "motion and gas force at 3200 rpm",
        quantities,
        "The figures are exact and free of misprints; the rod angle has the opposite sign to ours.",
        "Table 6 of the thesis omits the sign of the speed; table 7 labels accelerations °/s and rad/s.",
        "The gas force is Boyle's law in every revolution: no combustion, repeated every 360°.",
        f"A chamber height of {CLEARANCE:.3f} mm means a compression ratio of {COMPRESSION_RATIO:.1f}.",
    )


def _force_vector() -> Table:
    """The eight unknowns at 30° and 3200 rpm."""
    at, quantities = np.array([30.0]), []
    published, right = as_published(3200, at), corrected(3200, at)
    for record in records("columba2022_forces_30deg_3200rpm"):
        name, _, unit = record["component"].partition("_")
        figure = getattr(published, name) / (N_M if name == "T12" else 1.0)
        shown = {"Nm": "N·m"}.get(unit, unit)
        quantities.append(
            Quantity(name, shown, cell(record["value"], "30"), figure, right[name], _CAUSE, _AT)
        )
    return _table("vector at 30°", "the eight unknowns at 3200 rpm", quantities)


def _force(table: str, component: str, *, gas: bool = True, suffix: str = "_N") -> Quantity:
    cells = column(table, component + suffix)
    published = getattr(as_published(3200, cells.degrees, gas=gas), component)
    right = corrected(3200, cells.degrees, gas=gas)[component]
    name = component if gas else f"{component} without gas"
    return Quantity(name, "N", cells, published, right, _CAUSE if gas else _CAUSE_NO_GAS, _AT)


def _torque() -> Table:
    quantities = []
    for rpm in SPEEDS:
        cells = column("columba2022_torque", f"T12_{rpm}rpm_Nm")
        at = cells.degrees
        published, right = as_published(rpm, at).T12 / N_M, corrected(rpm, at)["T12"]
        late = {
            f"{at[i]:g}": Slip(f"the figure of {at[i - 1]:g}° (one row too low)", float(published[i - 1]))
            for i in (4, 5, 6, 7)
            if rpm == 3200
        }
        quantities.append(
            Quantity("driving torque", "N·m", cells, published, right, _CAUSE, f"{rpm} rpm", late)
        )
    return _table(
        "torque",
        "driving torque",
        quantities,
        "At 3200 rpm the figure of 120° is printed again at 160°, so that 200°–280° are one row too low.",
    )


def _working_model() -> Table:
    angle, position = (column("columba2022_working_model", title) for title in ("rod_deg", "piston_x_mm"))
    exact = kinematics(engine(), angle.theta, 0.0)
    beta, x = -exact.rod_angle / DEG, exact.piston_position
    return _table(
        "Working Model",
        "rod angle and piston position of independent software",
        [Quantity("rod angle", "°", angle, beta, beta), Quantity("piston position", "mm", position, x, x)],
        f"Largest difference {np.abs(position.values - x).max():.1e} mm.",
    )
