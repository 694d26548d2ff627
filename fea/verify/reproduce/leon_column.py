"""León 2001: the rod as a column, by Euler as printed and by Johnson as its slenderness requires."""

import math

from fea.verify.reproduce.leon_engine import SOURCE
from fea.verify.reproduce.misprint import wrong_digit
from fea.verify.reproduce.printed import decimals, records
from fea.verify.reproduce.row import Row
from fea.verify.reproduce.table import Table

AREA = 89.0  # mm²
SECOND_MOMENT = 1260.0  # mm⁴
LENGTH = 141.0  # mm
E, YIELD = 207e3, 220.0  # MPa, AISI 1018 as printed
_RADIUS_PRINTED = 3.766  # mm, a misprint of 3.763 that was used for the slenderness

GYRATION = math.sqrt(SECOND_MOMENT / AREA)
SLENDERNESS = LENGTH / GYRATION
TRANSITION = math.sqrt(2 * math.pi**2 * E / YIELD)


def euler(slenderness: float) -> float:
    """Euler's critical load, N: π² E A/(KL/r)²."""
    return math.pi**2 * E * AREA / slenderness**2


def johnson(slenderness: float, strength: float = YIELD) -> float:
    """Johnson's critical load, N: A S_y (1 − S_y (KL/r)²/(4π² E)), for columns shorter than C_c."""
    return AREA * strength * (1 - strength * slenderness**2 / (4 * math.pi**2 * E))


_JOHNSON = "Euler's formula was used, although KL/r is below C_c and Johnson's formula governs"


def buckling() -> Table:
    """The column check."""
    slender = LENGTH / _RADIUS_PRINTED
    printed_euler = euler(37.44)
    as_published: dict[str, tuple[float, float, str]] = {
        "radius of gyration": (GYRATION / 10, GYRATION / 10, ""),
        "slenderness KL/r": (slender, SLENDERNESS, "r = .3766 cm instead of .3763"),
        "transition slenderness Cc": (TRANSITION, TRANSITION, ""),
        "critical load": (printed_euler, johnson(SLENDERNESS), _JOHNSON),
        "allowable load N = 6": (printed_euler / 6, johnson(SLENDERNESS) / 6, _JOHNSON),
        "allowable load N = 4": (printed_euler / 4, johnson(SLENDERNESS) / 4, _JOHNSON),
    }
    rows = tuple(_row(record, *as_published[record["quantity"]]) for record in records("leon2001_column"))
    return Table(SOURCE, "column", "the rod as a column", rows, _remarks())


def _row(record: dict[str, str], as_published: float, corrected: float, cause: str) -> Row:
    quantity, text = record["quantity"], record["value"]
    slip = wrong_digit(text, GYRATION / 10) if quantity == "radius of gyration" else None
    digit = 10.0 ** -decimals(text)
    return Row(
        source=SOURCE,
        table="column",
        quantity=quantity,
        at="",
        unit=record["unit"],
        published=float(text),
        digit=digit,
        as_published=as_published,
        corrected=corrected,
        formula_cause=cause,
        slip=slip,
    )


def _remarks() -> tuple[str, ...]:
    depth = math.sqrt(12 * SECOND_MOMENT / AREA)
    width = AREA / depth
    weak = LENGTH / (width / math.sqrt(12))
    strong, strongest = johnson(SLENDERNESS) / 1e3, johnson(SLENDERNESS, 620.4) / 1e3
    return (
        f"KL/r = {SLENDERNESS:.1f} is far below C_c = {TRANSITION:.0f}: Johnson's formula governs.",
        f"It gives {strong:.1f} kN with the printed yield, {strongest:.1f} kN with that of the stress model.",
        "The load of table 17, 45.9 kN, exceeds the former and both printed allowables (21.6 and 32.4 kN).",
        f"A and I are those of a rectangle of {width:.2f} × {depth:.2f} mm about its strong axis.",
        f"About the weak axis, KL/r = {weak:.1f}.",
    )
