"""León 2001, tables 8–10 and 12: inertia force of the reciprocating mass, angular force of the rod."""

import numpy as np

from fea.units import DEG, M_S2
from fea.verify.reproduce.leon_engine import (
    INERTIA,
    LAMBDA,
    M_B,
    M_RECIPROCATING,
    PISTON,
    SOURCE,
    SPEEDS,
    L,
    exact_motion,
)
from fea.verify.reproduce.misprint import wrong_digit
from fea.verify.reproduce.printed import column, degrees, values
from fea.verify.reproduce.row import Slip
from fea.verify.reproduce.table import Column, Table, table


def tables() -> list[Table]:
    """Tables 8–10 and 12."""
    return [*(reciprocating(number, rpm) for number, rpm in zip((8, 9, 10), SPEEDS, strict=True)), angular()]


def reciprocating(number: int, rpm: int) -> Table:
    """Tables 8–10: acceleration of tables 4–6, and 1.690 kg times it as the inertia force."""
    name = f"leon2001_table{number}_inertia_force_{rpm}rpm"
    a_cells, f_cells = column(name, "acceleration_m_s2"), column(name, "F_N")
    before = values(column(f"leon2001_table{number - 4}_piston_acceleration_{rpm}rpm", "acceleration_m_s2"))
    exact = -exact_motion(rpm, degrees(a_cells)).piston_acceleration / M_S2
    force = M_RECIPROCATING * values(a_cells)
    slips = (
        {k: wrong_digit("-8279.170675", M_RECIPROCATING * -4898.9175) for k in ("130", "230")}
        if rpm == 3000
        else {}
    )
    cause = f"acceleration of table {number - 4}"
    speed = f"{rpm} rpm"
    return table(
        SOURCE,
        str(number),
        f"inertia force of the reciprocating mass at {rpm} rpm",
        [
            Column(
                quantity="piston acceleration",
                unit="m/s²",
                cells=a_cells,
                as_published=before,
                corrected=exact,
                cause=cause,
                speed=speed,
            ),
            Column(
                quantity="inertia force",
                unit="N",
                cells=f_cells,
                as_published=force,
                corrected=(PISTON + M_B) * exact,
                cause=cause,
                speed=speed,
                slips=slips,
            ),
        ],
        ["At 130° and 230° one digit of the force is wrong (…175 × 1.690 ends in 575)."]
        if rpm == 3000
        else [],
    )


def angular() -> Table:
    """Table 12: F = I α / (l cos β) from table 11 and the angles of table 2."""
    name = "leon2001_table12_rod_angular_force"
    angles = column(name, "rod_deg")
    beta_2 = values(column("leon2001_table2_rod_angle", "rod_deg"))
    exact_beta = np.arcsin(LAMBDA * np.sin(degrees(angles) * DEG)) / DEG
    columns = [
        Column(
            quantity="rod angle",
            unit="°",
            cells=angles,
            as_published=beta_2,
            corrected=exact_beta,
            cause="printed without its sign",
            slips={"110": wrong_digit("18.15", 18.25)},
        )
    ]
    for rpm in SPEEDS:
        cells = column(name, f"F_{rpm}rpm_N")
        alpha = values(column("leon2001_table11_rod_angular_acceleration", f"alpha_{rpm}rpm"))
        exact = exact_motion(rpm, degrees(cells))
        columns.append(
            Column(
                quantity="rod angular force",
                unit="N",
                cells=cells,
                as_published=INERTIA * alpha / (L * np.cos(beta_2 * DEG)),
                corrected=INERTIA * exact.rod_acceleration / (L * np.cos(exact.rod_angle)),
                cause="α of table 11, which is too small by (2π)²",
                speed=f"{rpm} rpm",
                slips=_misread_alpha() if rpm == 800 else {},
            )
        )
    return table(
        SOURCE,
        "12",
        "angular inertia force of the rod",
        columns,
        [
            "At 800 rpm, 90° and 270°, the force follows from 62.61 rad/s², but table 11 has 62.81.",
            "At 110° the angle is misprinted; the force was computed with 18.25°.",
            "It counts inertia twice: m_A and m_B already include I = m·a·b, and (I − m·a·b)·α = 0.",
        ],
    )


def _misread_alpha() -> dict[str, Slip]:
    text = "62.61 was used instead of the 62.81 rad/s² of table 11"
    force = INERTIA * 62.61 / (L * np.cos(19.47 * DEG))
    return {"90": Slip(text, -force), "270": Slip(text, force)}
