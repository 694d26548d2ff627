"""Pictures of the bearings: the joint with its opening and bolts, the bores in contact, the oil film."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from fea.analysis.cycle.superposition import CycleResult
from fea.analysis.film import FilmResult
from fea.base.units import DEG, KN, UM
from fea.contact.assembly_state import AssemblyState, bolt_forces
from fea.judge.case_result import CaseResult
from fea.output.plots.figure import crank_angle, label_axes, new_figure, save
from fea.output.units import heading, quantity, scale, unit
from fea.solid.bore import bore_shape
from geometry.arrays import Floats, Ints
from geometry.surfaces import Surface
from loads.instants import ASSEMBLY
from mesh.tetmesh import FACET_EDGES, TetMesh

# Share of the big end's size as which the largest gap is drawn, and the most by which it is exaggerated.
_SHOWN, _MOST = 0.05, 500.0
# Facets whose normal deviates from the view by less (cosine) are drawn.
_FACING = 0.02
# Share of the largest gap from which the joint is drawn as open.
_OPEN = 0.01
# Half of what is drawn, over the largest distance of the joint from the bore's axis.
_AROUND = 1.45


def plot_joint(path: Path, cases: Mapping[str, CaseResult], title: str, cycle: CycleResult | None) -> None:
    """Draw the joint of a rod in parts, with the crank cycle if computed. Raises `PictureError`."""
    states = {name: case.assembly for name, case in cases.items() if case.assembly is not None}
    worst = max(states, key=lambda name: (states[name].joint.opening, -states[name].joint.force))
    figure = new_figure(12, 7.5)
    panels = figure.subplot_mosaic(
        [["view", "worst"], ["view", "alone"], ["view", "forces"]], width_ratios=[1.05, 1]
    )
    _draw_view(figure, panels["view"], cases[worst], cases[ASSEMBLY], worst)
    largest = max(cases[name].assembly.joint.max_pressure for name in (worst, ASSEMBLY))  # type: ignore[union-attr]
    for panel, name in (("worst", worst), ("alone", ASSEMBLY)):
        _draw_pressure(figure, panels[panel], cases[name], largest, name)
    _draw_forces(panels["forces"], states, cycle)
    figure.suptitle(title, fontsize=11)
    save(figure, path, 100)


def _draw_view(figure: Any, axes: Any, case: CaseResult, alone: CaseResult, name: str) -> None:
    mesh, state = case.mesh, case.assembly
    moved = case.displacement - alone.displacement
    facets, joint = _facing(mesh), np.unique(mesh.facets[Surface.JOINT])
    reach = float(np.hypot(*mesh.points[joint, :2].T).max())  # from the big end's axis
    moved = moved - moved[joint].mean(axis=0)
    gap = 0.0 if state is None else state.joint.opening
    size = gap or float(np.abs(moved[np.unique(facets)]).max())
    factor = float(f"{min(_SHOWN * reach / size, _MOST):.0e}") if size > 0 else 1.0
    points = mesh.points + factor * moved
    near = case.counts & (np.abs(mesh.points[:, :2]).max(axis=1) < _AROUND * reach)
    stress = scale("MPa") * case.von_mises
    limit = float(stress[near if near.any() else case.counts].max())
    drawn = axes.tripcolor(
        points[:, 1], points[:, 0], facets, stress, shading="gouraud", cmap="viridis", vmin=0, vmax=limit
    )
    figure.colorbar(
        drawn, ax=axes, shrink=0.6, label=heading("von Mises stress", "MPa"), location="bottom", pad=0.01
    )
    around = _AROUND * reach
    for side in (Surface.JOINT, Surface.JOINT_CAP):
        ends = mesh.facets[side][:, FACET_EDGES].reshape(-1, 2)
        front = mesh.points[ends, 2].min(axis=1) > mesh.points[ends, 2].max() * (1 - 1e-6)
        at = points[ends[front]]
        axes.plot(at[..., 1].T, at[..., 0].T, color="k", lw=1.2)
    for bolt in () if state is None else state.bolts:
        axes.annotate(
            quantity(bolt.force / KN, ".1f", "kN"),
            (bolt.at[1], bolt.at[0]),
            (bolt.at[1], bolt.at[0] - 0.8 * around),
            ha="center",
            fontsize=9,
            arrowprops={"arrowstyle": "-", "ls": "-.", "lw": 0.8, "color": "0.3"},
        )
    axes.set(xlim=(-around, around), ylim=(-around, around), aspect="equal")
    label_axes(axes, "y, mm", "x, mm")
    opened = f"; gap at most {quantity(gap / UM, '.0f', 'µm')}" if gap > 0 else ""
    axes.set_title(f"{name}: moved since assembly, × {factor:g}{opened}", fontsize=10)


def _draw_pressure(figure: Any, axes: Any, case: CaseResult, largest: float, name: str) -> None:
    mesh = case.mesh
    facets = mesh.facets[Surface.JOINT][:, :3]
    at = mesh.points[np.unique(facets), :2]
    along = np.linalg.svd(at - at.mean(axis=0), full_matrices=False)[2][0]
    along = along if along[1] >= 0 else -along
    across, z = np.asarray(mesh.points[:, :2] @ along), mesh.points[:, 2]
    pressure, seat = np.zeros(len(z)), case.seats[Surface.JOINT]
    pressure[seat.nodes] = seat.pressure
    shown, limit = scale("MPa") * pressure, scale("MPa") * largest
    colours = {"shading": "gouraud", "cmap": "magma_r", "vmin": 0, "vmax": limit}
    drawn = axes.tripcolor(across, z, facets, shown, **colours)
    opened = np.zeros(len(z)) if case.gap is None else case.gap
    if opened[facets].max() > 0:
        levels = [_OPEN * opened.max(), opened.max()]
        axes.tricontourf(across, z, facets, opened, levels=levels, colors="none", hatches=["////"])
    figure.colorbar(drawn, ax=axes, label=unit("MPa"))
    axes.set(aspect="equal")
    label_axes(axes, "" if name != ASSEMBLY else "along the joint, mm", "z, mm")
    hatched = " (hatched: open)" if opened[facets].max() > 0 else ""
    axes.set_title(f"{name}: pressure on the joint{hatched}", fontsize=10)


def _draw_forces(axes: Any, states: Mapping[str, AssemblyState], cycle: CycleResult | None) -> None:
    if cycle is not None and cycle.states:
        for number, force in enumerate(bolt_forces(cycle.states), 1):
            axes.plot(cycle.angles / DEG, force / KN * scale("kN"), label=f"bolt {number}", lw=1.4)
        last = round(float(cycle.angles[-1]) / DEG)
        axes.set(xlabel="crank angle, °", xlim=(0, last), xticks=range(0, last + 1, last // 8))
    else:
        forces, place = bolt_forces(list(states.values())), np.arange(len(states))
        width = 0.8 / len(forces)
        for number, force in enumerate(forces):
            at, height = place + (number + 0.5) * width - 0.4, force / KN * scale("kN")
            axes.bar(at, height, width, label=f"bolt {number + 1}")
        axes.set_xticks(place, list(states))
        low, high, one = (value * scale("kN") for value in (forces.min() / KN, forces.max() / KN, 1.0))
        axes.set(ylim=(max(low - 0.5 * (high - low) - one, 0), high + one))
    axes.set(ylabel=heading("bolt force", "kN"))
    axes.legend(frameon=False, fontsize=8)


def _facing(mesh: TetMesh) -> Ints:
    """Facets (n, 3) of the outside that face the viewer, the nearest last."""
    joint = {Surface.JOINT, Surface.JOINT_CAP}
    every = np.concatenate([facets[:, :3] for surface, facets in mesh.facets.items() if surface not in joint])
    a, b, c = mesh.points[every].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    facing = np.abs(normal[:, 2]) > _FACING * np.linalg.norm(normal, axis=1)
    high = mesh.points[every, 2].mean(axis=1)
    chosen = np.flatnonzero(facing & (high > 0))
    return np.asarray(every[chosen[np.argsort(high[chosen], kind="stable")]])


# Directions and places along a bore at which pressures are looked up.
_DIRECTIONS, _ALONG = 181, 25
# Nodes that such a pressure is weighted from by their distance, and where one of them is that place.
_NEAREST, _SAME = 4, 1e-9
_BORES = ((Surface.SMALL_END_BORE, "small end"), (Surface.BIG_END_BORE, "big end"))


def plot_bores(path: Path, cases: Mapping[str, CaseResult], rod_length: float, title: str) -> None:
    """Draw pressure along the bore and change of diameter for every case. Raises `PictureError`."""
    figure = new_figure(10, 10)
    panels = figure.subplots(2, 2, subplot_kw={"projection": "polar"})
    touched = {case: found for case, found in cases.items() if found.touch}
    for column, (surface, name) in enumerate(_BORES):
        x = rod_length if surface is Surface.SMALL_END_BORE else 0.0
        above, below = panels[:, column]
        angle, pressures = _around(surface, x, touched.values())
        for number, (case, found) in enumerate(touched.items()):
            colour, pressure = f"C{number}", pressures[..., number]
            above.plot(angle, scale("MPa") * pressure.mean(axis=1), color=colour, label=case, lw=1.4)
            above.plot(angle, scale("MPa") * pressure.max(axis=1), color=colour, lw=0.7, ls=":")
            shape = bore_shape(found.mesh, surface, x, found.distortion)
            turned = np.concatenate([shape.direction, shape.direction[1:] + np.pi])
            change = 1e3 * scale("µm") * np.concatenate([shape.change, shape.change[1:]])
            below.plot(turned, change, color=colour, lw=1.4)
        above.set_title(f"{name}: contact pressure, {unit('MPa')} (dotted: largest along the bore)", size=10)
        below.set_title(f"{name}: change of diameter, {unit('µm')}", size=10)
        above.set_ylim(0)
    for panel in panels.flat:
        panel.tick_params(labelsize=8)
        panel.grid(alpha=0.4)
    panels[0, 0].legend(loc="lower left", bbox_to_anchor=(-0.15, -0.12), frameon=False, fontsize=8)
    figure.suptitle(f"{title}. 0°: along the rod, from the crank pin to the piston pin", fontsize=11)
    save(figure, path, 100)


def _around(surface: Surface, x: float, cases: Collection[CaseResult]) -> tuple[Floats, Floats]:
    """Angles all the way round, and pressures (n, n_z, n_cases) there at places along the bore."""
    mesh = next(iter(cases)).mesh
    pressure = np.stack([case.seats[surface].pressure for case in cases], axis=1)
    own = mesh.points[np.unique(mesh.facets[surface])] - [x, 0.0, 0.0]
    angle, z = np.arctan2(own[:, 1], own[:, 0]), own[:, 2] / np.hypot(own[:, 0], own[:, 1]).mean()
    unrolled = np.concatenate([np.stack([angle + turn, z], axis=1) for turn in (-2 * np.pi, 0, 2 * np.pi)])
    places, along = np.linspace(-np.pi, np.pi, _DIRECTIONS), np.linspace(z.min(), z.max(), _ALONG)
    at = np.stack(np.meshgrid(places, along, indexing="ij"), axis=-1)
    # Triangulations of nodes that mirror each other are so degenerate that a look-up takes seconds.
    distance, nodes = cKDTree(unrolled).query(at, _NEAREST)
    share = 1 / np.maximum(distance, _SAME) ** 2
    near = pressure[nodes % len(pressure)]
    return places, np.einsum("...k,...kc->...c", share / share.sum(axis=-1, keepdims=True), near)


_FILM, _PRESSURE = "#0072b2", "#d55e00"  # distinguished by people with colour blindness (Wong 2011)
_EVERY = 90  # degrees, at which the orbit is marked


def plot_film(path: Path, film: FilmResult, title: str) -> None:
    """Draw the film of an end. Raises `PictureError`: the file could not be written."""
    found, cycle, degrees = film.figures, film.cycle, film.degrees
    last = round(2 * degrees[-1] - degrees[-2])
    figure = new_figure(12, 7.5)
    panels = figure.subplot_mosaic([["film", "orbit"], ["pressure", "map"]], width_ratios=[1.6, 1])
    for name, label, values, colour, at in (
        ("film", "smallest film, µm", cycle.thinnest / UM, _FILM, found.h_min_deg),
        ("pressure", "highest pressure, MPa", cycle.highest, _PRESSURE, found.p_max_deg),
    ):
        axes = panels[name]
        axes.plot(degrees, values, color=colour)
        axes.axvline(at, color="0.6", linestyle=":")
        axes.set(xlim=(0, last), xticks=range(0, last + 1, last // 8), ylim=(0, None))
        axes.grid(color="0.9")
        label_axes(axes, crank_angle(last), label)
    roughness = film.lubrication.asperities and 1e3 * film.lubrication.asperities.roughness
    if roughness:
        panels["film"].axhline(roughness, color="0.4", linestyle="--", linewidth=1)
        panels["film"].text(
            0.993 * last, roughness, "roughness", ha="right", va="bottom", fontsize=8, color="0.4"
        )
    x, y = cycle.eccentricity.T
    _draw_orbit(panels["orbit"], x, y, degrees, last)
    panels["orbit"].set(title=f"centre of the {film.end.pin} in the bore, in clearances")
    state, grid = cycle.states[int(cycle.highest.argmax())], cycle.bearing.reynolds.grid
    turned = scale("MPa") * np.roll(state.pressure, grid.n_angle // 2, axis=0)
    around = np.linspace(-180, 180, grid.n_angle + 1) - 180 / grid.n_angle
    for side in (1, -1) if grid.halved else (1,):
        drawn = panels["map"].pcolormesh(around, side * grid.edges, turned.T, cmap="viridis")
    panels["map"].set(
        xlim=(-180, 180), xticks=range(-180, 181, 90), title=f"pressure at {found.p_max_deg:.0f}°"
    )
    label_axes(panels["map"], "angle in the bore from the rod's axis, °", "along the pin, mm")
    figure.colorbar(drawn, ax=panels["map"], label=unit("MPa"))
    figure.suptitle(f"{title}: oil film of the {film.end.words}, {found.verdict}", fontsize=11)
    save(figure, path, 100)


def _draw_orbit(axes: Any, x: Floats, y: Floats, degrees: Floats, last: int) -> None:
    """Draw the journal's centre in the bore, in clearances: the rigid bore ends at the circle."""
    around = np.linspace(0.0, 360 * DEG, 181)
    axes.plot(np.cos(around), np.sin(around), color="0.6", linewidth=1)
    axes.plot(np.append(x, x[0]), np.append(y, y[0]), color=_FILM)
    for angle in range(0, last, _EVERY):
        number = int(np.abs(degrees - angle).argmin())
        at = x[number], y[number]
        axes.plot(*at, "o", color=_FILM, markersize=3)
        # The second revolution is labelled inside the orbit: both may pass the same place.
        off = np.array(at) * (10 if angle < 360 else -10) / max(np.hypot(*at), 1e-9)
        axes.annotate(
            f"{angle}°", at, fontsize=7, xytext=off, textcoords="offset points", ha="center", va="center"
        )
    axes.set(aspect="equal", xmargin=0.1, ymargin=0.1)
    label_axes(axes, "along the rod, away from the crank", "across the rod")
