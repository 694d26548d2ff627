"""A picture of an oil film: thickness and pressure over the cycle, the journal's orbit, and the pressure."""

from pathlib import Path
from typing import Any

import numpy as np

from fea.analysis.film import FilmResult
from fea.base.units import DEG
from fea.output.plots.figure import label_axes, new_figure, save
from geometry.arrays import Floats

_FILM, _PRESSURE = "#0072b2", "#d55e00"  # distinguished by people with colour blindness (Wong 2011)
_EVERY = 90  # degrees, at which the orbit is marked


def plot_film(path: Path, film: FilmResult, title: str) -> None:
    """Draw the film of the big end. Raises `PictureError`: the file could not be written."""
    found, columns = film.figures, {name: np.asarray(values) for name, values in film.columns.items()}
    degrees = columns["crank_deg"]
    figure = new_figure(12, 7.5)
    panels = figure.subplot_mosaic([["film", "orbit"], ["pressure", "map"]], width_ratios=[1.6, 1])
    for name, heading, column, colour, at in (
        ("film", "smallest film, µm", "h_min_um", _FILM, found.h_min_deg),
        ("pressure", "highest pressure, MPa", "p_max_MPa", _PRESSURE, found.p_max_deg),
    ):
        axes = panels[name]
        axes.plot(degrees, columns[column], color=colour)
        axes.axvline(at, color="0.6", linestyle=":")
        axes.set(xlim=(0, 720), xticks=range(0, 721, _EVERY), ylim=(0, None))
        axes.grid(color="0.9")
        label_axes(axes, "crank angle, ° (firing TDC at 360°)", heading)
    roughness = film.lubrication.asperities and 1e3 * film.lubrication.asperities.roughness
    if roughness:
        panels["film"].axhline(roughness, color="0.4", linestyle="--", linewidth=1)
        panels["film"].text(715, roughness, "roughness", ha="right", va="bottom", fontsize=8, color="0.4")
    _draw_orbit(panels["orbit"], columns["eccentricity_x"], columns["eccentricity_y"], degrees)
    state = film.cycle.states[int(film.cycle.highest.argmax())]
    grid = film.cycle.bearing.reynolds.grid
    whole = (
        np.concatenate([state.pressure[:, ::-1], state.pressure], axis=1) if grid.halved else state.pressure
    )
    turned = np.roll(whole, grid.n_angle // 2, axis=0)
    drawn = panels["map"].imshow(
        turned.T, extent=(-180, 180, -grid.width / 2, grid.width / 2), aspect="auto", cmap="viridis"
    )
    panels["map"].set(xticks=range(-180, 181, 90), title=f"pressure at {found.p_max_deg:.0f}°")
    label_axes(panels["map"], "angle in the bore from the rod's axis, °", "along the pin, mm")
    figure.colorbar(drawn, ax=panels["map"], label="MPa")
    figure.suptitle(f"{title}: oil film of the big end, {found.verdict}", fontsize=11)
    save(figure, path, 100)


def _draw_orbit(axes: Any, x: Floats, y: Floats, degrees: Floats) -> None:
    """Draw the journal's centre in the bore, in clearances: the rigid bore ends at the circle."""
    around = np.linspace(0.0, 360 * DEG, 181)
    axes.plot(np.cos(around), np.sin(around), color="0.6", linewidth=1)
    axes.plot(np.append(x, x[0]), np.append(y, y[0]), color=_FILM)
    for angle in range(0, 720, _EVERY):
        number = int(np.abs(degrees - angle).argmin())
        axes.plot(x[number], y[number], "o", color=_FILM, markersize=3)
        axes.annotate(
            f"{angle}°", (x[number], y[number]), fontsize=7, xytext=(3, 3), textcoords="offset points"
        )
    axes.set(aspect="equal", title="centre of the crank pin in the bore, in clearances")
    label_axes(axes, "along the rod", "across the rod")
