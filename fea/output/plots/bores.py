"""Polar plots of the contact pressure on the bores and of how their diameters change."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fea.assess.bore_shape import bore_shape
from fea.assess.case_result import CaseResult
from fea.output.plots.saving import save
from geometry.arrays import Floats
from geometry.surfaces import Surface

# Directions and places along a bore at which pressures are looked up.
_DIRECTIONS, _ALONG = 181, 25
_BORES = ((Surface.SMALL_END_BORE, "small end"), (Surface.BIG_END_BORE, "big end"))


def plot_bores(path: Path, cases: Mapping[str, CaseResult], rod_length: float, title: str) -> None:
    """Draw pressure, its mean and its largest along the bore, and change of diameter for every case.

    Raises
    ------
    PictureError
        The file could not be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - only a plot needs it
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(10, 10), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, 2, subplot_kw={"projection": "polar"})
    touched = {case: found for case, found in cases.items() if found.touch}
    for column, (surface, name) in enumerate(_BORES):
        x = rod_length if surface is Surface.SMALL_END_BORE else 0.0
        above, below = panels[:, column]
        angle, pressures = _around(surface, x, touched.values())
        for number, (case, found) in enumerate(touched.items()):
            colour, pressure = f"C{number}", pressures[..., number]
            above.plot(angle, pressure.mean(axis=1), color=colour, label=case, lw=1.4)
            above.plot(angle, pressure.max(axis=1), color=colour, lw=0.7, ls=":")
            shape = bore_shape(found.mesh, surface, x, found.distortion)
            turned = np.concatenate([shape.direction, shape.direction[1:] + np.pi])
            change = 1e3 * np.concatenate([shape.change, shape.change[1:]])
            below.plot(turned, change, color=colour, lw=1.4)
        _decorate(above, f"{name}: contact pressure, MPa (dotted: largest along the bore)")
        _decorate(below, f"{name}: change of diameter, µm")
        above.set_ylim(0)
    panels[0, 0].legend(loc="lower left", bbox_to_anchor=(-0.15, -0.12), frameon=False, fontsize=8)
    figure.suptitle(f"{title}. 0°: along the rod, from the crank pin to the piston pin", fontsize=11)
    save(figure, path, 100)


def _around(surface: Surface, x: float, cases: Collection[CaseResult]) -> tuple[Floats, Floats]:
    """Angles all the way round, and pressures (n, n_z, n_cases) there at places along the bore."""
    from scipy.interpolate import LinearNDInterpolator  # noqa: PLC0415 - only this plot needs it

    mesh = next(iter(cases)).mesh
    nodes = np.unique(mesh.facets[surface])
    pressure = np.stack([case.contact_pressure[nodes] for case in cases], axis=1)  # type: ignore[index]
    own = mesh.points[nodes] - [x, 0.0, 0.0]
    angle, z = np.arctan2(own[:, 1], own[:, 0]), own[:, 2] / np.hypot(own[:, 0], own[:, 1]).mean()
    unrolled = np.concatenate([np.stack([angle + turn, z], axis=1) for turn in (-2 * np.pi, 0, 2 * np.pi)])
    field = LinearNDInterpolator(unrolled, np.tile(pressure, (3, 1)), fill_value=0.0)
    places, along = np.linspace(-np.pi, np.pi, _DIRECTIONS), np.linspace(z.min(), z.max(), _ALONG)
    return places, np.asarray(field(*np.meshgrid(places, along, indexing="ij")))


def _decorate(panel: Any, heading: str) -> None:
    panel.set_title(heading, fontsize=10)
    panel.tick_params(labelsize=8)
    panel.grid(alpha=0.4)
