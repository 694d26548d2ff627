"""Studies of engines from models to ships, drawn at random, and the same with one value in another unit."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fea.base.units import OTHER_UNITS
from fea.study.engine_library import engine_names, engine_preset
from fea.study.files import toml_text
from fea.study.material_table import LIBRARY
from fea.study.plausibility import ImplausibleValue
from fea.study.study import Study, parse_study
from fea.study.tables import unit_of
from geometry.errors import InvalidValue
from geometry.rod import proportioned

# Bore, stroke, length of the rod, its bores (mm); piston with pin and rings (kg); rpm, compression ratio,
# peak pressure (bar). Rounded: bore, stroke and speed are the makers', the rest is usual for such engines.
ENGINES = {
    "model, 0.8 cm³": (10.3, 9.8, 19.0, 3.6, 2.6, 0.0012, 13_500, 7.0, 35),
    "model, 7.5 cm³": (22.0, 19.6, 36.0, 7.0, 6.0, 0.009, 15_000, 9.0, 45),
    "chain saw": (44.7, 32.0, 56.0, 19.0, 14.0, 0.07, 10_000, 9.5, 45),
    "Honda GX160": (68.0, 45.0, 84.0, 30.0, 18.0, 0.21, 3600, 8.5, 40),
    "Formula One, 2.4 l": (98.0, 39.8, 102.0, 42.0, 18.0, 0.24, 18_000, 13.0, 120),
    "VW 1.9 TDI": (79.5, 95.5, 144.0, 50.6, 26.0, 0.72, 4000, 19.5, 150),
    "truck, 2 l a cylinder": (128.0, 155.0, 251.0, 95.0, 52.0, 4.0, 1900, 17.5, 180),
    "locomotive, 4.8 l": (170.0, 210.0, 390.0, 135.0, 72.0, 12.0, 1800, 15.5, 200),
    "medium speed, 32 cm": (320.0, 400.0, 790.0, 290.0, 145.0, 88.0, 750, 15.0, 190),
    "medium speed, 46 cm": (460.0, 580.0, 1160.0, 400.0, 205.0, 260.0, 500, 15.0, 190),
    "two-stroke, 50 cm": (500.0, 1910.0, 2050.0, 560.0, 500.0, 2400.0, 127, 17.0, 145),
    "two-stroke, 96 cm": (960.0, 2500.0, 2900.0, 980.0, 960.0, 12_000.0, 102, 16.0, 145),
}
_SCATTER = 0.05
# The optional rod keys that a designer gives beside the bores.
_SHAPE = (
    "big_end_ring",
    "small_end_ring",
    "big_end_width",
    "small_end_width",
    "shank_depth_big_end",
    "shank_depth_small_end",
    "shank_width",
    "web_thickness",
    "flange_thickness",
    "big_end_fillet",
)


class WrongUnit(NamedTuple):
    """A study with one value in another unit."""

    tables: dict[str, Any]
    key: str
    unit: str


def tables(draw: np.random.Generator) -> dict[str, Any]:
    """Draw the tables of a study in its right units."""

    def near(value: float, scatter: float = _SCATTER) -> float:
        return float(f"{value * np.exp(draw.normal(0, scatter)):.4g}")

    if draw.random() < 0.5:
        names = list(ENGINES)
        bore, stroke, length, big, small, piston, rpm, ratio, peak = ENGINES[names[draw.integers(len(names))]]
    else:
        names = list(engine_names())
        preset = engine_preset(names[draw.integers(len(names))])
        got = {key: figure.value for key, figure in {**preset.engine, **preset.rod}.items()}
        bore, stroke, piston = (float(got[key]) for key in ("bore_mm", "stroke_mm", "piston_mass_kg"))
        length, big, small = (
            float(got[key]) for key in ("length_mm", "big_end_bore_mm", "small_end_bore_mm")
        )
        rpm, ratio = preset.redline_rpm, float(got.get("compression_ratio", 10.0))
        peak = float(got.get("peak_pressure_bar", 65.0))
    rod = {"length_mm": near(length, 0.02), "big_end_bore_mm": near(big), "small_end_bore_mm": near(small)}
    if draw.random() < 0.6:
        full = proportioned(rod["length_mm"], rod["big_end_bore_mm"], rod["small_end_bore_mm"])
        for name in _SHAPE:
            if draw.random() < 0.5:
                rod[f"{name}_mm"] = near(getattr(full, name), 0.1)
    if draw.random() < 0.2:
        mass = 0.24e-6 * length**3
        rod |= {"mass_kg": near(mass), "center_of_gravity_mm": near(0.3 * length)}
        rod["inertia_kg_m2"] = near(0.18e-6 * mass * length**2)
    metal = list(LIBRARY.values())[draw.integers(8)].figures
    material = {key: near(value, 0.02) if key != "nu" else value for key, value in metal.items()}
    study: dict[str, Any] = {
        "rod": rod,
        "material": {key: value for key, value in material.items() if "fatigue_strength" not in key},
        "engine": {
            "stroke_mm": near(stroke),
            "bore_mm": near(bore),
            "piston_mass_kg": near(piston, 0.15),
            "gas": "otto",
            "compression_ratio": near(ratio, 0.03),
            "peak_pressure_bar": max(near(peak, 0.1), 1.4 * ratio**1.4),  # above that of compression
        },
        "speed": {"rpm": near(rpm * draw.uniform(0.5, 1.0))},
    }
    if draw.random() < 0.3:
        study["contact"] = {
            "small_end_clearance_mm": near(0.7e-3 * small, 0.3),
            "big_end_clearance_mm": near(1.0e-3 * big, 0.3),
            "piston_pin_bore_mm": near(0.55 * small),
            "piston_pin_length_mm": near(2.6 * small),
        }
    return study


def wrong(draw: np.random.Generator, right: dict[str, Any]) -> WrongUnit:
    """Convert one value of a study, drawn at random, to another usual unit, drawn at random."""
    places = [(table, key) for table, entries in right.items() for key in entries if units_of(key)]
    table, key = places[draw.integers(len(places))]
    units = list(units_of(key))
    unit = units[draw.integers(len(units))]
    value = right[table][key] / units_of(key)[unit]
    return WrongUnit({**right, table: {**right[table], key: value}}, f"{table}.{key}", unit)


def units_of(key: str) -> dict[str, float]:
    """Return the other units of a key, with their sizes in its own."""
    _, own = unit_of(key)
    by_symbol = {unit_of(f"x_{unit}")[1] or unit: factors for unit, factors in OTHER_UNITS.items()}
    return by_symbol.get(own or key, {})


def said_of(study: dict[str, Any]) -> InvalidValue | list[ImplausibleValue]:
    """The refusal that the tables of a study meet, or else what is noted of its units."""
    try:
        asked: Study = parse_study(toml_text(study), "drawn", Path.cwd())
        found = asked.unusual()
        if not any(finding.refused for finding in found):
            engine = asked.require_engine()
            engine.gas_model(engine.engine(asked.rod.length or 0.0))
    except InvalidValue as refusal:
        return refusal
    return found


def drawn(count: int, seed: int) -> Iterator[tuple[dict[str, Any], WrongUnit]]:
    """Draw so many right studies, each with a wrong one."""
    draw = np.random.default_rng(seed)
    while count:
        right = tables(draw)
        if isinstance(said_of(right), InvalidValue) and "rod." in str(said_of(right)):
            continue  # dimensions drawn apart from each other need not make a solid
        yield right, wrong(draw, right)
        count -= 1
