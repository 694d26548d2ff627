"""Plots of the reproduction report: published and corrected figures."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fea.verify.reproduce import columba, leon_engine, molina
from fea.verify.reproduce.printed import column, degrees, values
from fea.verify.reproduce.table import Table
from geometry.arrays import Floats

Exact = Callable[[Floats], Floats]

_PRINTED = {"marker": "o", "markersize": 3.5, "linestyle": "none", "color": "#c0392b"}
_CORRECT = {"color": "#1f4e79", "linewidth": 1.6}


def draw(tables: Sequence[Table], folder: Path, stem: str) -> dict[str, tuple[Path, str]]:
    """Draw the plots of the studies among `tables` as ``<stem>-<study>-….png``.

    Returns
    -------
    dict
        By study: the file and its caption.
    """
    sources = dict.fromkeys(table.source for table in tables)
    drawings: dict[str, tuple[Callable[[], Any], str]] = {
        leon_engine.SOURCE: (_leon, "León 2001 at 6000 rpm: tables 1, 3, 4 and 13"),
        columba.SOURCE: (_columba, "Columba 2022: driving torque of one cylinder at three speeds"),
        molina.SOURCE: (_molina, "Molina 2024: acceleration at 780 rpm; displacement and its regression"),
    }
    drawn = {}
    for source in sources:
        make, caption = drawings[source]
        path = folder / f"{stem}-{source}.png"
        figure = make()
        figure.savefig(path, dpi=110)
        drawn[source] = (path, caption)
    return drawn


def _axes(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, list[Any]]:
    """Create a figure without a display, and return its axes row by row."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - only a report draws
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, list(np.ravel(figure.subplots(rows, columns)))


def _label(axes: Any, title: str, quantity: str, last: int) -> None:
    axes.set_title(title, fontsize=10)
    axes.set_xlabel("crank angle, °")
    axes.set_ylabel(quantity)
    axes.set_xlim(0, last)
    axes.set_xticks(range(0, last + 1, last // 4))
    axes.axhline(0, color="0.6", linewidth=0.7)
    axes.grid(alpha=0.3)


def _against(axes: Any, name: str, title: str, exact: Exact, scale: float = 1.0) -> None:
    """Draw printed cells as dots over the exact curve."""
    cells = column(name, title)
    last = 720 if degrees(cells).max() > 360 else 360
    fine = np.linspace(0, last, 721)
    axes.plot(fine, exact(fine) * scale, label="corrected", **_CORRECT)
    axes.plot(degrees(cells), values(cells) * scale, label="published", **_PRINTED)
    axes.set_xlim(0, last)


def _leon() -> Any:
    figure, axes = _axes(3, 2, (10, 10))
    rpm = 6000
    top = 1e3 * (leon_engine.L + leon_engine.R)
    panels: list[tuple[str, str, str, str, Exact, float]] = [
        (
            "leon2001_table1_piston_position",
            "position_cm",
            "Table 1: piston position from TDC",
            "cm",
            lambda x: (top - leon_engine.exact_motion(rpm, x).piston_position) / 10,
            1.0,
        ),
        (
            "leon2001_table3_piston_velocity_6000rpm",
            "velocity_m_s",
            "Table 3: piston velocity",
            "m/s",
            lambda x: -leon_engine.exact_motion(rpm, x).piston_velocity / 1e3,
            1.0,
        ),
        (
            "leon2001_table4_piston_acceleration_6000rpm",
            "acceleration_m_s2",
            "Table 4: piston acceleration",
            "km/s²",
            lambda x: -leon_engine.exact_motion(rpm, x).piston_acceleration / 1e3,
            1e-3,
        ),
        (
            "leon2001_table13_forces_6000rpm",
            "F_resultant_N",
            "Table 13: resultant on the pin",
            "kN",
            lambda x: -leon_engine.along_cylinder(leon_engine.exact_forces(rpm, x)),
            1e-3,
        ),
        (
            "leon2001_table13_forces_6000rpm",
            "F_normal_N",
            "Table 13: normal force",
            "kN",
            lambda x: leon_engine.exact_forces(rpm, x).wall,
            1e-3,
        ),
        (
            "leon2001_table13_forces_6000rpm",
            "F_rod_N",
            "Table 13: rod force (compression positive; printed unsigned)",
            "kN",
            lambda x: -leon_engine.exact_forces(rpm, x).pin_axial,
            1e-3,
        ),
    ]
    for panel, (name, title, heading, unit, exact, scale) in zip(axes, panels, strict=True):
        _against(panel, name, title, exact, scale)
        _label(panel, heading, unit, int(panel.get_xlim()[1]))
    axes[0].legend(frameon=False)
    figure.suptitle("León 2001, 6000 rpm, bore 76 mm: published and corrected figures")
    return figure


def _columba() -> Any:
    figure, axes = _axes(1, 3, (12, 3.8))
    for panel, rpm in zip(axes, columba.SPEEDS, strict=True):
        _against(
            panel,
            "columba2022_torque",
            f"T12_{rpm}rpm_Nm",
            lambda x, rpm=rpm: columba.corrected(rpm, x)["T12"],  # type: ignore[misc]
        )
        fine = np.linspace(0, 360, 361)
        worksheet = columba.as_published(rpm, fine).T12 / 1e3
        panel.plot(fine, worksheet, color="#c0392b", linewidth=0.8, label="as published")
        _label(panel, f"{rpm} rpm", "driving torque T12, N·m", 360)
    axes[0].legend(frameon=False, fontsize=8)
    figure.suptitle("Columba 2022: gas sign, friction and moment of inertia corrected")
    return figure


def _molina() -> Any:
    figure, (left, right) = _axes(1, 2, (11, 3.8))
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
