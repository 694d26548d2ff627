"""The rod in three dimensions: a header that a page reads as JSON, and its packed numbers."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from fea.analysis.figures import BoreFigures
from fea.analysis.film import FilmResult
from fea.analysis.motion import Motion, ParityMotion
from fea.analysis.result import BORES, Array
from fea.base.choices import Support
from fea.judge.verdict import CAP
from fea.output.json_file import JsonObject
from fea.output.life_tables import lettered
from fea.output.pictures.scale import exaggeration
from fea.output.pictures.shown import VON_MISES, Field, available, field_of
from fea.output.report.surface import LEVELS, NumberedSurface, Packer, corner_steps
from fea.output.stored_run import Run
from fea.output.units import coordinates, factor, number, quantity, scale, unit
from fea.study.pin_models import pin_model
from geometry.arrays import Floats, Ints
from loads.bearing import PressureArc
from mesh.tetmesh import TetMesh

_MIDDLE = Field("principal_2", "middle principal stress", "MPa", signed=True)
_OF_FILM = Field("film_pressure", "pressure of the oil film", "MPa")
# In the order in which a load case offers them.
CASE_FIELDS = (
    VON_MISES, "principal_1", "principal_2", "principal_3", "displacement", "safety_factor_node",
    "contact_pressure",
)  # fmt: skip
# How many values describe the pressure from the middle of an arc to its end.
_SAMPLES = 17
# Of an instant of the cycle: what follows from its stress and displacement.
INSTANT_FIELDS = CASE_FIELDS[:-1]


def fields_of(names: Iterable[str], data: Mapping[str, Array], peak: float) -> list[JsonObject]:
    """Return those fields that a result has; the legend of the von Mises stress ends at the `peak`."""
    return [_described(name, data, {VON_MISES: peak}) for name in names if name in data]


case_fields = partial(fields_of, CASE_FIELDS)


def instant_fields(peak: float, extremes: Mapping[str, Array], displaced: float) -> list[JsonObject]:
    """Return the fields of every instant: one legend for the whole cycle.

    It ends at the largest von Mises stress that counts, MPa, at the extremes in the arrays of the envelope,
    and at the largest displacement, mm.
    """
    low, high = float(extremes["principal_3"].min()), float(extremes["principal_1"].max())
    ends = {
        VON_MISES: np.array([0.0, peak]),
        **dict.fromkeys(("principal_1", "principal_2", "principal_3"), np.array([low, high])),
        "displacement": np.array([0.0, displaced]),
        "safety_factor_node": extremes["safety_factor_node"],
    }
    return fields_of(INSTANT_FIELDS, ends, peak)


def _described(name: str, data: Mapping[str, Array], known: Mapping[str, float]) -> JsonObject:
    own = {field.name: field for field in (_MIDDLE, _OF_FILM)}
    field = own.get(name) or field_of(name)
    values = np.asarray(field.values(data), float)
    finite = values[np.isfinite(values)]
    largest = float(finite.min() if field.low else finite.max()) if finite.size else 0.0
    worst = field.scale * known[name] if name in known else largest
    bands = field.bands(finite, worst)
    return {
        "name": name,
        "label": field.words,
        "unit": unit(field.own_unit),
        "low": field.low and not field.signed,
        "factor": field.scale,
        "limits": [float(f"{limit / field.scale:.6g}") for limit in bands.limits],
        "labels": [f"{limit:.6g}" for limit in bands.limits],
        "colours": ["#" + bytes(colour).hex() for colour in bands.colours],
        "above": bool(finite.size and finite.max() > bands.limits[-1] * (1 + 1e-9)),
    }


def hot_spots(run: Run) -> Iterator[JsonObject]:
    """Yield the worst place of every load case, its sharp edges, and the worst places of the cycle."""
    for name, case in run.summary.results.items():
        if name not in run.fields:
            continue
        stress = quantity(case.max_von_mises_MPa, ".0f", "MPa")
        text = f"{stress}, safety factor {factor(case.min_safety_factor)}"
        yield _spot(name.capitalize(), text, case.at_mm, name, "von_mises")
        for edge in case.sharp_edges or ():
            stress = f"structural stress {quantity(edge.structural_von_mises_MPa, '.0f', 'MPa')}"
            title = f"{name.capitalize()}, sharp edge {edge.name}"
            yield _spot(title, stress, edge.at_mm, name, "von_mises")
    cycle = run.summary.cycle
    if cycle is None or run.envelope is None:
        return
    result = "envelope" if run.motion is None else "cycle"
    for title, spot in zip(lettered(len(cycle.spots)), cycle.spots, strict=True):
        text = f"up to {quantity(spot.max_von_mises_MPa, '.0f', 'MPa')} at {number(spot.crank_deg, '.0f')}°"
        yield _spot(f"Cycle, {title}", text, spot.at_mm, result, "von_mises") | {"angle": spot.crank_deg}
    if cycle.fatigue is not None:
        text = f"fatigue factor {factor(cycle.fatigue.fatigue_safety_factor)}"
        yield _spot("Weakest in fatigue", text, cycle.fatigue.at_mm, "envelope", "fatigue_safety_factor")


def _spot(title: str, text: str, at: tuple[float, float, float], result: str, field: str) -> JsonObject:
    where = f"x, y, z = {coordinates(at)} {unit('mm')}"
    return {"title": title, "text": text, "place": where, "at": list(at), "result": result, "field": field}


def pressure_kind(name: str) -> JsonObject:
    """Return what a pin does to its bore, from the pressure's name in the study."""
    arcs = pin_model(name).arcs
    if arcs is None:
        return {"kind": name}
    load = arcs(name)
    return {"kind": "arc", "tension": _arc(load.tension), "compression": _arc(load.compression)}


def _arc(arc: PressureArc) -> JsonObject:
    away = np.linspace(0.0, arc.angle / 2, _SAMPLES)
    shares = arc.unbounded(away).round(4).tolist()
    return {"shares": shares, "deg": round(float(np.degrees(arc.angle)), 6)}


def bore_loads(contact: Mapping[str, BoreFigures] | None) -> list[list[float]] | None:
    """Return place, °, arc, °, and largest pressure, MPa, of the contact on the big and the small end."""
    if contact is None:
        return None
    found = (contact.get(surface.value) for surface in BORES)
    return [[one.at_deg, one.arc_deg, one.max_pressure_MPa] if one else [0.0, 0.0, 0.0] for one in found]


def cycle_loads(run: Run) -> JsonObject:
    """Return forces [x, y] on the rod at the big and the small end at every degree, N, and contact if any."""
    if run.forces is None:
        return {}
    columns = {name: np.asarray(values, float) for name, values in run.forces.items()}
    found: JsonObject = {
        "forces": [
            [_whole(-columns["crank_axial_N"]), _whole(columns["crank_transverse_N"])],
            [_whole(columns["pin_axial_N"]), _whole(columns["pin_transverse_N"])],
        ]
    }
    if run.contact is not None:
        touch = {name: np.nan_to_num(np.asarray(values, float)) for name, values in run.contact.items()}
        found["touch"] = [
            [touch[f"{end}_{name}"].round(2).tolist() for name in ("at_deg", "arc_deg", "pressure_MPa")]
            for end in ("big_end", "small_end")
        ]
    return found


def _whole(values: Floats) -> list[int]:
    return [int(value) for value in np.rint(values)]


# Steps from nothing to the peak: of stress in a load case, of displacement, and of a mode of the cycle.
_STRESS, _DISPLACEMENT, _MODE = 2**14, 2**13, 10**4
_MOVED = 2**13
_FILM = 2**10  # of the pressure of an oil film
# Letters of the packed numbers with which the page, with its text, still picture and script, stays within 1
# MB; how many times coarser the steps of stress and displacement are where it would not.
_LARGEST, _COARSER = 560_000, (8, 24)


@dataclass(frozen=True)
class DrawnRod:
    """The data with which a page draws the rod."""

    header: Mapping[str, Any]  #: for JSON: results, legends, loads, and how the numbers are packed
    numbers: str  #: in base64 (`fea.output.report.surface`)
    complete: bool  #: whether it holds the nodes between the elements' corners, too


def scene(run: Run) -> DrawnRod | None:
    """Return the rod of a run with its load cases, and its cycle; None where the run has no fields.

    Nodes between the corners of elements are left out where the page would become too large with them, and
    then the finest steps of their values.
    """
    if not run.fields:
        return None
    mesh = run.mesh
    found = _scene(run, mesh, NumberedSurface.of(mesh))
    if len(found.numbers) > _LARGEST and found.header["order"] == 2:
        found = _scene(run, mesh, NumberedSurface.of(mesh, most=0))
    for coarser in _COARSER:
        if len(found.numbers) > _LARGEST:
            found = _scene(run, mesh, NumberedSurface.of(mesh, most=0), coarser=coarser)
    return found


def _scene(run: Run, mesh: TetMesh, surface: NumberedSurface, coarser: int = 1) -> DrawnRod:
    packer = Packer(coarser)
    packer.integers("corners", corner_steps(surface.facets))
    packer.values("positions", mesh.points[surface.nodes], surface.parents)
    results = [_case(run, name, data, surface, packer) for name, data in run.fields.items()]
    cycle = run.summary.cycle
    if run.envelope is not None and cycle is not None:
        results.append(_envelope(run.envelope, cycle.max_von_mises_MPa, surface, packer))
        if run.motion is not None:
            results.append(_cycle(run, run.envelope, run.motion, surface, packer))
    largest = max(float(np.linalg.norm(data["displacement"], axis=1).max()) for data in run.fields.values())
    header = {
        "order": surface.order,
        "last": run.summary.cycle_degrees,
        "vertices": int(surface.facets.max()) + 1,
        "nodes": len(surface.nodes),
        "exaggeration": exaggeration(float(np.ptp(mesh.points, axis=0).max()), largest),
        "bores": [bore._asdict() for bore in run.bores],
        "pressure": pressure_kind(run.summary.model.pressure),
        "clamped": run.study.analysis.support is Support.CLAMPED,
        "shown": {"length": _unit("mm", 1, 2), "force": _unit("kN", 1, 0, 1e-3)},
        "results": results,
        "spots": [*hot_spots(run)],
        "films": [_film(film, packer) for film in run.films],
        "first": _first(run, [result["id"] for result in results]),
        "arrays": packer.entries,
    }
    return DrawnRod(header, packer.text(), surface.order == mesh.order)


def _first(run: Run, drawn: Sequence[str]) -> JsonObject:
    """Return what the view opens with: the result that governs, if it is `drawn`."""
    governs = run.summary.governing_result
    if governs not in drawn:
        return {"result": run.summary.worst_case, "field": "von_mises"}
    tired = governs == "envelope" and run.summary.survival.mode == "fatigue"
    return {"result": governs, "field": "fatigue_safety_factor" if tired else "von_mises"}


def _unit(name: str, si: int, us: int, per: float = 1.0) -> JsonObject:
    """Return a unit for the page, with the decimals that it has, in SI units or in US units."""
    digits = si if unit(name) == name else us
    return {"unit": unit(name), "factor": per * scale(name), "digits": digits}


def _case(
    run: Run, name: str, data: Mapping[str, Array], surface: NumberedSurface, packer: Packer
) -> JsonObject:
    nodal = {key: np.asarray(values)[surface.nodes] for key, values in data.items()}
    figures, loads = run.summary.results[name], run.summary.loads[name]
    singular = figures.singular_max_von_mises_MPa is not None
    stress = np.stack([nodal[f"principal_{k}"] for k in (1, 2, 3)], axis=1)
    packer.values(f"{name}.stress", stress, surface.parents, levels=_levels(stress, _STRESS))
    moved = nodal["displacement"]
    packer.values(f"{name}.displacement", moved, surface.parents, levels=_levels(moved, _DISPLACEMENT))
    # Yield strength, MPa, from stress and safety factor; without stress, that of the others.
    free = nodal["safety_factor_node"] < CAP
    strength = np.where(free, nodal["safety_factor_node"] * nodal["von_mises"], np.nan)
    usual = float(np.nanmedian(strength)) if free.any() else 0.0
    # Rounding would make constants look like noise.
    rounded = np.array([float(f"{value:.7g}") for value in np.where(free, strength, usual)])
    packer.values(f"{name}.strength", rounded, surface.parents)
    if "contact_pressure" in nodal:
        packer.values(f"{name}.contact_pressure", nodal["contact_pressure"], surface.parents)
    crank, pin = (-loads.crank_axial_N, loads.crank_transverse_N), (loads.pin_axial_N, loads.pin_transverse_N)
    return {
        "id": name,
        "kind": "case",
        "title": name.capitalize(),
        "angle": loads.crank_deg,
        "forces": [[round(value, 1) + 0.0 for value in force] for force in (crank, pin)],
        "touch": bore_loads(figures.contact),
        "fields": [
            field | ({"away": list(figures.at_mm)} if singular and field["name"] == VON_MISES else {})
            for field in case_fields(nodal, figures.max_von_mises_MPa)
        ],
    }


def _levels(values: Floats, steps: int) -> int:
    """Number of levels with which the largest size has so many steps."""
    largest = float(np.abs(values).max()) or 1.0
    return max(1, min(LEVELS, round(float(np.ptp(values)) / largest * steps)))


def _envelope(data: Mapping[str, Array], peak: float, surface: NumberedSurface, packer: Packer) -> JsonObject:
    nodal = {key: np.asarray(values)[surface.nodes] for key, values in data.items()}
    fields = fields_of([name for name in available(list(nodal)) if name != "endurance_limit"], nodal, peak)
    for field in fields:
        values = nodal[field["name"]].astype(float)
        if field["low"]:  # one over a factor is what stress is proportional to; negative: not judged
            values = np.where(values > 0, 1 / np.where(values > 0, values, 1.0), np.nan)
        levels = _levels(values[np.isfinite(values)], _STRESS) if np.isfinite(values).any() else 1
        packer.values(f"envelope.{field['name']}", values, surface.parents, levels=levels)
    named = {"id": "envelope", "kind": "envelope", "title": "Worst of the cycle"}
    return named | {"angle": None, "fields": fields}


def _cycle(
    run: Run, extremes: Mapping[str, Array], found: Motion, surface: NumberedSurface, packer: Packer
) -> JsonObject:
    at = np.searchsorted(found.nodes, surface.nodes)
    order, parents = surface.rows(found.row[at])
    number = np.empty(int(order.max()) + 1, np.int64)
    number[order] = np.arange(len(order))
    packer.integers("cycle.row", corner_steps(number[found.row[at]]))
    packer.integers("cycle.sign", (found.sign[at] < 0) @ np.array([1, 2, 4]))
    packer.values("cycle.strength", found.strength[order], parents)
    displaced = 0.0
    modes = []
    for name, motion in (("even", found.even), ("odd", found.odd)):
        if motion is not None:
            _pack_parity(packer, name, motion, (order, parents), found.peak)
            displaced += _largest_displacement(motion) if found.moves else 0.0
            modes.append(motion.stress.shape[2])
    shown = instant_fields(found.peak, extremes, displaced)
    return {
        "id": "cycle",
        "kind": "cycle",
        "title": "Crank cycle",
        "angle": None,
        "instants": len(found.angles),
        "modes": modes,
        "error": float(f"{found.error:.3g}"),
        "loads": cycle_loads(run),
        "moves": found.moves,
        "fields": [field for field in shown if found.moves or field["name"] != "displacement"],
    }


def _film(film: FilmResult, packer: Packer) -> JsonObject:
    """Pressures of a film, step by step, over the angle and the width or half of it; and its orbit."""
    cycle, grid = film.cycle, film.cycle.bearing.reynolds.grid
    pressures, steps = (
        np.array([state.pressure.ravel() for state in cycle.states]),
        np.arange(len(cycle.states)),
    )
    packer.values(film.name, pressures, np.stack([steps - 1] * 2, axis=1), levels=_FILM)
    return {
        "id": film.name,
        "end": film.end.words,
        "last": round(float(np.degrees(film.turn))),
        "angles": grid.n_angle,
        "halved": grid.halved,
        "edges": grid.edges.round(4).tolist(),
        "orbit": cycle.eccentricity.round(4).tolist(),
        "field": _described(_OF_FILM.name, {_OF_FILM.name: pressures.ravel()}, {}),
    }


def _pack_parity(packer: Packer, name: str, of: ParityMotion, rows: tuple[Ints, Ints], peak: float) -> None:
    """Modes as columns, a component of stress after the other, and their courses."""
    order, parents = rows
    columns = np.moveaxis(of.stress[order], 1, 2)
    step = max(peak / _MODE, float(np.abs(columns).max()) / 2**14)
    packer.steps(f"{name}.stress", columns, parents, step)
    moved = np.moveaxis(of.displacement[order], 1, 2)
    largest = float(np.abs(moved).max(initial=0.0)) or 1.0
    packer.steps(f"{name}.displacement", moved, parents, largest / _MOVED)
    # A course as finely as its mode: half a step of stress, and of displacement, where that is largest.
    drift = np.abs(moved).max(axis=(0, 2)) * _MOVED / largest
    sizes = np.abs(of.stress).max(axis=(0, 1)) / step
    sizes[: len(drift)] = np.maximum(sizes[: len(drift)], drift)
    instants, enough = np.arange(of.courses.shape[1]), packer.coarser / np.maximum(sizes, 1e-30)
    packer.values(f"{name}.courses", of.courses.T, np.stack([instants - 1] * 2, axis=1), enough=enough)


def _largest_displacement(of: ParityMotion) -> float:
    """A close upper bound of the largest displacement of one parity, mm."""
    moving = of.courses[: of.displacement.shape[2]]
    sizes = np.linalg.norm(of.displacement, axis=1)
    some = moving[:, ::15]
    far = np.argsort(-sizes.sum(axis=1))[:200]
    return float(np.linalg.norm(of.displacement[far] @ some, axis=1).max())
