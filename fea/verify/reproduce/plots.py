"""Plots of the reproduction report: published and corrected figures."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fea.output.plots.figure import new_figure
from fea.verify.reproduce import columba, leon, molina
from fea.verify.reproduce.printed import column
from geometry.arrays import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Exact = Callable[[Floats], Floats]

_PRINTED = {"marker": "o", "markersize": 3.5, "linestyle": "none", "color": "#c0392b"}
_CORRECT = {"color": "#1f4e79", "linewidth": 1.6}


def draw(source: str, report: Path) -> tuple[Path, str]:
    """Draw the plots of a study next to a report as ``<report>-<study>.png``; return it with its caption."""
    make, caption = _DRAWINGS[source]
    path = report.with_name(f"{report.stem}-{source}.png")
    make().savefig(path, dpi=110)
    return path, caption


def _label(axes: "Axes", title: str, quantity: str, last: int) -> None:
    axes.set_title(title, fontsize=10)
    axes.set_xlabel("crank angle, °")
    axes.set_ylabel(quantity)
    axes.set_xlim(0, last)
    axes.set_xticks(range(0, last + 1, last // 4))
    axes.axhline(0, color="0.6", linewidth=0.7)
    axes.grid(alpha=0.3)


def _against(axes: "Axes", name: str, title: str, exact: Exact, scale: float = 1.0) -> None:
    """Draw printed cells as dots over the exact curve."""
    cells = column(name, title)
    last = 720 if cells.degrees.max() > 360 else 360
    fine = np.linspace(0, last, 721)
    axes.plot(fine, exact(fine) * scale, label="corrected", **_CORRECT)  # type: ignore[arg-type]
    axes.plot(cells.degrees, cells.values * scale, label="published", **_PRINTED)  # type: ignore[arg-type]
    axes.set_xlim(0, last)


def _leon_curves() -> dict[tuple[str, str], tuple[str, str, Exact, float]]:
    """By table and column: heading, unit, exact curve at 6000 rpm and its factor."""
    motion, forces = partial(leon.exact_motion, 6000), partial(leon.exact_forces, 6000)
    top, table_13 = 1e3 * (leon.L + leon.R), "leon2001_table13_forces_6000rpm"
    position = ("Table 1: piston position from TDC", "cm")
    velocity = ("Table 3: piston velocity", "m/s")
    acceleration = ("Table 4: piston acceleration", "km/s²")
    resultant = ("Table 13: resultant on the pin", "kN")
    rod = ("Table 13: rod force (compression positive; printed unsigned)", "kN")
    return {
        ("leon2001_table1_piston_position", "position_cm"): (
            *position,
            lambda x: (top - motion(x).piston_position) / 10,
            1.0,
        ),
        ("leon2001_table3_piston_velocity_6000rpm", "velocity_m_s"): (
            *velocity,
            lambda x: -motion(x).piston_velocity / 1e3,
            1.0,
        ),
        ("leon2001_table4_piston_acceleration_6000rpm", "acceleration_m_s2"): (
            *acceleration,
            lambda x: -motion(x).piston_acceleration / 1e3,
            1e-3,
        ),
        (table_13, "F_resultant_N"): (*resultant, lambda x: -leon.along_cylinder(forces(x)), 1e-3),
        (table_13, "F_normal_N"): ("Table 13: normal force", "kN", lambda x: forces(x).wall, 1e-3),
        (table_13, "F_rod_N"): (*rod, lambda x: -forces(x).pin_axial, 1e-3),
    }


def _leon() -> "Figure":
    figure = new_figure(10, 10)
    axes, curves = figure.subplots(3, 2).ravel(), _leon_curves().items()
    for panel, ((table, title), (heading, unit, exact, scale)) in zip(axes, curves, strict=True):
        _against(panel, table, title, exact, scale)
        _label(panel, heading, unit, int(panel.get_xlim()[1]))
    axes[0].legend(frameon=False)
    figure.suptitle("León 2001, 6000 rpm, bore 76 mm: published and corrected figures")
    return figure


def _columba() -> "Figure":
    figure = new_figure(12, 3.8)
    axes = figure.subplots(1, 3)
    for panel, rpm in zip(axes, columba.SPEEDS, strict=True):

        def torque(x: Floats, rpm: int = rpm) -> Floats:
            return columba.corrected(rpm, x)["T12"]

        _against(panel, "columba2022_torque", f"T12_{rpm}rpm_Nm", torque)
        fine = np.linspace(0, 360, 361)
        worksheet = columba.as_published(rpm, fine).T12 / 1e3
        panel.plot(fine, worksheet, color="#c0392b", linewidth=0.8, label="as published")
        _label(panel, f"{rpm} rpm", "driving torque T12, N·m", 360)
    axes[0].legend(frameon=False, fontsize=8)
    figure.suptitle("Columba 2022: gas sign, friction and moment of inertia corrected")
    return figure


def _molina() -> "Figure":
    figure = new_figure(11, 3.8)
    left, right = figure.subplots(1, 2)
    fine = np.linspace(0, 720, 1441)
    left.plot(fine, -molina.motion(780, fine).piston_acceleration / 1e3, label="exact", **_CORRECT)
    left.plot([0, 180], [380, -380], label="published", **_PRINTED)
    left.plot(fine, molina.two_term_acceleration(780, fine) / 1e3, color="0.4", ls="--", label="two terms")
    _label(left, "piston acceleration at 780 rpm", "m/s²", 720)
    left.legend(frameon=False, fontsize=8)
    samples = np.arange(0.0, 721.0, 10.0)
    (a, b), quality = molina.fit(samples, np.round(molina.travel(samples), 2))
    right.plot(samples, molina.travel(samples), label="displacement", **_CORRECT)
    right.plot(fine, a + b * fine**2, color="#c0392b", label=f"published regression, R² = {quality:.4f}")
    _label(right, "displacement and its regression on θ²", "mm", 720)
    right.set_ylim(top=1.2 * right.get_ylim()[1])
    right.legend(frameon=False, fontsize=8, ncols=2, loc="upper center")
    return figure


_DRAWINGS: dict[str, tuple[Callable[[], "Figure"], str]] = {
    leon.SOURCE: (_leon, "León 2001 at 6000 rpm: tables 1, 3, 4 and 13"),
    columba.SOURCE: (_columba, "Columba 2022: driving torque of one cylinder at three speeds"),
    molina.SOURCE: (_molina, "Molina 2024: acceleration at 780 rpm; displacement and its regression"),
}
