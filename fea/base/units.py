"""The one converter between engineering units and the coherent system mm, N, MPa, t, s, rad.

Multiply by a constant to convert input, divide by it to convert output: ``mass = 0.785 * KG``.
"""

import math

M = 1e3
GPA = 1e3
BAR = 0.1
KG = 1e-3
KG_M2 = 1e3  # t·mm²
KG_M3 = 1e-12  # t/mm³
N_M = 1e3  # N·mm
KN = 1e3
UM = 1e-3
M_S = 1e3
M_S2 = 1e3
DEG = math.pi / 180
RPM = 2 * math.pi / 60

# How the units at the ends of keys are written, where that is otherwise.
WRITTEN = {
    "kg_m2": "kg·m²",
    "kg_m3": "kg/m³",
    "1_K": "1/K",
    "1_GPa": "1/GPa",
    "mPas": "mPa·s",
    "Nm": "N·m",
    "um": "µm",
    "C": "°C",
    "deg": "degrees",
    "bar_V": "bar/V",
}
INCH, _POUND = 25.4, 0.45359237  # mm, kg
_POUND_FORCE = 9.80665 * _POUND  # N
_PSI = _POUND_FORCE / INCH**2  # MPa
# What else a quantity is given in, by the unit at the end of its key: how much of that unit it is.
OTHER_UNITS: dict[str, dict[str, float]] = {
    "mm": {"inches": INCH, "cm": 10.0, "m": 1e3, "µm": 1e-3},
    "um": {"mm": 1e3, "inches": 1e3 * INCH},
    "kg": {"g": 1e-3, "lb": _POUND, "t": 1e3},
    "kg_m2": {
        "kg·mm²": 1e-6,
        "kg·cm²": 1e-4,
        "g·cm²": 1e-7,
        "g·mm²": 1e-9,
        "lb·in²": _POUND * INCH**2 * 1e-6,
        "t·mm²": 1e-3,
    },
    "kg_m3": {
        "g/cm³": 1e3,
        "t/mm³": 1e12,
        "kg/mm³": 1e9,
        "lb/in³": _POUND / INCH**3 * 1e9,
        "lb/ft³": _POUND / (12 * INCH) ** 3 * 1e9,
    },
    "GPa": {"MPa": 1e-3, "Pa": 1e-9, "ksi": _PSI, "psi": _PSI * 1e-3, "Mpsi": _PSI * 1e3, "kPa": 1e-6},
    "MPa": {"Pa": 1e-6, "ksi": _PSI * 1e3, "psi": _PSI, "GPa": 1e3, "kPa": 1e-3, "bar": 0.1},
    "bar": {"MPa": 10.0, "psi": 10 * _PSI, "kPa": 1e-2, "Pa": 1e-5},
    "kN": {"N": 1e-3, "lbf": _POUND_FORCE * 1e-3, "kgf": 9.80665e-3, "kip": _POUND_FORCE},
    "N": {"kN": 1e3, "lbf": _POUND_FORCE, "kgf": 9.80665},
    "Nm": {
        "lbf·ft": 12e-3 * INCH * _POUND_FORCE,
        "lbf·in": 1e-3 * INCH * _POUND_FORCE,
        "kgf·m": 9.80665,
        "N·mm": 1e-3,
    },
    "rpm": {"rad/s": 1 / RPM, "Hz": 60.0},
    "deg": {"rad": 1 / DEG},
    "1_K": {"1e-6/K": 1e-6, "1/°F": 1.8},
    "1_GPa": {"1/MPa": 1e3, "1/psi": 1e6 / (1e3 * _PSI)},
    "mPas": {"Pa·s": 1e3, "cP": 1.0},
    "C": {},  # °F and K have another zero
    "percent": {},
    "hours": {},
    "V": {"mV": 1e-3},
    "bar_V": {"psi/V": 10 * _PSI, "MPa/V": 10.0},
}
