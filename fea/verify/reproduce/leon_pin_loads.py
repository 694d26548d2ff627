"""León 2001, table 17: the loads of the finite-element model, taken from tables 13–15."""

from collections.abc import Iterator

import numpy as np

from fea.units import DEG
from fea.verify.reproduce.leon_engine import SOURCE, along_cylinder, exact_forces
from fea.verify.reproduce.leon_forces import TABLES
from fea.verify.reproduce.printed import Cell, column, records
from fea.verify.reproduce.row import Row, Slip
from fea.verify.reproduce.table import Table


def pin_loads() -> Table:
    """Table 17."""
    rows = [row for record in records("leon2001_table17_pin_loads") for row in _pin_load(record)]
    return Table(
        SOURCE,
        "17",
        "loads of the finite-element model",
        tuple(rows),
        (
            (
                "6000 rpm: 47 060.64 N is the largest *compression* of table 13; the largest force is the "
                "tension of 59 719.52 N at 0°."
            ),
            "3000 rpm: 460° is the third largest of table 14 (450° has 18 510.34 N, 470° 18 180.47 N).",
            "The normal force acts between piston and wall; on the pin bore of a clamped rod it is bending.",
        ),
    )


def _pin_load(record: dict[str, str]) -> Iterator[Row]:
    rpm, key = int(record["rpm"]), record["crank_deg"]
    name = f"leon2001_table{TABLES[rpm]}_forces_{rpm}rpm"
    total = column(name, "F_resultant_N")
    i = [cell.key for cell in total].index(key)
    yield _critical_angle(rpm, key, total)
    exact = exact_forces(rpm, float(key))
    figures = {
        "rod_deg": ("rod angle", "°", exact.motion.rod_angle / DEG),
        "F_resultant_N": ("resultant", "N", -along_cylinder(exact)),
        "F_normal_N": ("normal force", "N", np.abs(exact.wall)),
        "F_rod_N": ("rod force", "N", -exact.pin_axial),
    }
    for title, (quantity, unit, corrected) in figures.items():
        cell = column(name, title)[i]
        yield Row(
            source=SOURCE,
            table="17",
            quantity=quantity,
            at=f"{rpm} rpm, {key}°",
            unit=unit,
            published=float(record[title]),
            digit=0.01,
            as_published=cell.value if title == "rod_deg" else abs(cell.value),
            corrected=float(corrected),
            formula_cause=f"table {TABLES[rpm]}",
        )


def _critical_angle(rpm: int, key: str, total: list[Cell]) -> Row:
    """The crank angle of the largest force: as published, in the printed table, and in the exact cycle."""
    largest = max(total, key=lambda cell: abs(cell.value))
    compressive = max(total, key=lambda cell: cell.value)
    taken = next(cell for cell in total if cell.key == key)
    slip = Slip(
        f"the largest force of table {TABLES[rpm]} is {largest.value:.2f} N at {largest.key}°; used was "
        + ("the largest compression, " if compressive is taken else "")
        + f"{taken.value:.2f} N",
        float(taken.key),
    )
    fine = np.arange(0, 720, 0.1)
    exact = exact_forces(rpm, fine)
    return Row(
        source=SOURCE,
        table="17",
        quantity="crank angle of the largest force",
        at=f"{rpm} rpm",
        unit="°",
        published=float(key),
        digit=1.0,
        as_published=float(largest.key),
        corrected=float(fine[np.argmax(np.abs(exact.pin_axial))]),
        formula_cause=f"table {TABLES[rpm]}",
        slip=slip,
    )
