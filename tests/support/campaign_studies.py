"""What the campaign through every door draws: studies, in SI and in US units, and pressure traces."""

from typing import Any

import numpy as np
from traces import ATMOSPHERE, BAR_IN, cycle, written

from geometry.rod import proportioned

MESHES = ("inp", "msh", "bdf", "med", "vtu", "vtk", "xdmf")
MATERIALS = ("4340", "300M", "EN24T", "C70S6", "42CrMo4", "Ti-6Al-4V", "7075-T6")
# Unit and factor by which figures of these keys are written in other units.
_US = {"mm": ("in", 1 / 25.4), "kg": ("lb", 1 / 0.45359237), "MPa": ("psi", 1e6 / 6894.757293168361),
       "bar": ("psi", 1e5 / 6894.757293168361), "GPa": ("psi", 1e9 / 6894.757293168361)}  # fmt: skip


def random_tables(draw: np.random.Generator, *, bolted: bool = False, faster: float = 1.0,
                  material: dict[str, float] | None = None) -> dict[str, Any]:  # fmt: skip
    """The tables of a study of a rod of usual proportions, in an engine that suits it, on a coarse mesh.

    Parameters
    ----------
    bolted
        A rod in parts.
    faster
        Factor on the speed.
    material
        Figures in place of a material of the library.
    """
    length = float(np.exp(draw.uniform(np.log(70), np.log(260))))
    big = length * draw.uniform(0.32, 0.42)
    small = big * draw.uniform(0.4, 0.55)
    rod = {"length_mm": length, "big_end_bore_mm": float(big), "small_end_bore_mm": float(small)}
    usual = proportioned(length, big, small)
    section = str(draw.choice(["I", "I", "H", "rectangular"]))
    if section != "I":
        rod["shank_section"] = section
    if draw.random() < 0.3:
        rod["web_thickness_mm"] = float(usual.web_thickness * draw.uniform(0.9, 1.15))
    if draw.random() < 0.3:
        rod["big_end_ring_mm"] = float(usual.big_end_ring * draw.uniform(0.95, 1.2))
    if bolted:
        bolt = 0.36 * usual.big_end_width
        wider = proportioned(length, big, small, cap_bolt=bolt).cap_bolt_spacing + bolt * draw.uniform(
            0.7, 1.2
        )
        rod |= {"cap_bolt_mm": float(bolt), "cap_bolt_spacing_mm": float(wider)}
    stroke = length * draw.uniform(0.5, 0.68)
    bore = stroke * draw.uniform(0.85, 1.15)
    engine = {"stroke_mm": float(stroke), "bore_mm": float(bore), "cylinders": int(draw.choice([1, 3, 4, 6])),
              "piston_mass_kg": float(0.9 * (bore / 86) ** 3 * draw.uniform(0.5, 1.0)), "gas": "otto",
              "compression_ratio": float(draw.uniform(8.5, 12)),
              "peak_pressure_bar": float(draw.uniform(50, 100))}  # fmt: skip
    rpm = faster * draw.uniform(10, 18) * 30 / (stroke * 1e-3)
    tables: dict[str, Any] = {"rod": rod, "engine": engine, "speed": {"rpm": round(float(rpm))}}
    tables["material"] = {"preset": str(draw.choice(MATERIALS))}
    if material:
        tables["material"] = {"E_GPa": 205.0, "nu": 0.29, "density_kg_m3": 7850.0} | material
    tables["mesh"] = {"size_mm": float(round(length / 12, 2))}
    if bolted:
        tables["assembly"] = {"bolt_preload_kN": float(0.35 * bolt**2 * draw.uniform(0.6, 1.2))}
    return tables


def in_other_units(tables: dict[str, Any]) -> dict[str, Any]:
    """The same study in inches, pounds and psi."""

    def other(key: str, value: Any) -> tuple[str, Any]:
        plain, _, unit = key.rpartition("_")
        if unit not in _US or isinstance(value, list):
            return key, value
        name, factor = _US[unit]
        reference = " abs" if key == "peak_pressure_bar" else ""
        return plain, f"{value * factor:.12g} {name}{reference}"

    return {name: dict(other(*item) for item in keys.items()) for name, keys in tables.items()}


def trace_pair(draw: np.random.Generator, ratio: float) -> tuple[tuple[str, dict[str, Any]], ...]:
    """One trace as two files with the keys that they need: the plain one, and another convention."""
    fine = np.arange(-360.0, 360.0, 0.5)
    pressure, _ = cycle(draw, fine, ratio, 0.29)
    plain = written(fine + 360, pressure, header=["crank angle [deg],p [bar abs]"])
    unit, gauge = str(draw.choice(list(BAR_IN))), bool(draw.random() < 0.5)
    step, comma = int(draw.choice([1, 2])), bool(draw.random() < 0.4)
    start = float(draw.choice([0.0, 360.0]))
    shown = (pressure - gauge * ATMOSPHERE)[::step] * BAR_IN[unit]
    name = f"{unit} {'gauge' if gauge else 'abs'}"
    separator = ";" if comma else str(draw.choice([",", "\t", ";"]))
    header = [separator.join(["crank angle [deg]", f"p [{name}]"])] if draw.random() < 0.7 else []
    keys = {} if header else {"pressure_unit": unit, "pressure_reference": "gauge" if gauge else "absolute"}
    newline = str(draw.choice(["\n", "\r\n"]))
    text = written(
        fine[::step] + start, shown, separator=separator, comma=comma, header=header, newline=newline
    )
    return (plain, {}), (text, keys)
