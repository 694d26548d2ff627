"""Bolts, joint and fits of an assembled rod as tables of a report."""

from fea.analysis.assembly_figures import AssemblyFigures, BoltsFigures, FaceCaseFigures
from fea.output.report.tables import Table
from fea.output.report.wording import figure
from fea.output.terminal.figures import UNKNOWN, factor, number
from fea.units import KN


def assembly_tables(found: AssemblyFigures) -> list[Table]:
    """Return the bolts, the joint by load case, and each fit by load case."""
    return [_bolts(found.bolts), _joint(found), *(_fit(name, found) for name in found.fits)]


def _bolts(bolts: BoltsFigures) -> Table:
    rows = (
        ("preload after tightening and embedding, kN", number(bolts.preload_N / KN, ".1f")),
        ("largest force, kN", number(bolts.max_force_N / KN, ".1f")),
        ("amplitude, kN", number(bolts.amplitude_N / KN, ".2g")),
        ("largest force over proof load", number(bolts.proof_use, ".2f")),
        ("stress at tightening over yield strength", number(bolts.tightening_use, ".2f")),
        ("safety factor against yielding", factor(bolts.yield_safety_factor)),
        ("alternating stress in the thread, MPa", figure(bolts.alternating_stress_MPa, 3)),
        ("endurance limit of the thread, MPa", figure(bolts.endurance_MPa, 3)),
        ("safety factor against fatigue", factor(bolts.fatigue_safety_factor)),
        ("largest pressure under head or nut, MPa", figure(bolts.seat_pressure_MPa, 3)),
    )
    return Table(f"Bolts, {bolts.thread}, by VDI 2230", ("quantity", "value"), rows)


def _joint(found: AssemblyFigures) -> Table:
    rows = []
    for case, own in found.joint.by_case.items():
        forces = sorted(bolt.force_N / KN for bolt in found.bolts.by_case[case])
        ends = f"{forces[0]:.1f} to {forces[-1]:.1f}" if forces else UNKNOWN
        rows.append(
            (
                case, ends, number(own.clamp_force_N / KN, ".1f"), number(own.open_percent, ".0f"),
                number(own.opening_um, ".1f"), number(own.slipping_percent, ".0f"),
                number(own.slip_um, ".1f"), number(own.slip_reserve, ".3g"),
            )
        )  # fmt: skip
    head = (
        "load case",
        "bolts, kN",
        "clamped, kN",
        "open, %",
        "gap, µm",
        "slips, %",
        "slip, µm",
        "reserve of slip",
    )
    return Table(f"Joint between rod and cap, friction {found.joint.friction:g}", head, tuple(rows))


def _fit(name: str, found: AssemblyFigures) -> Table:
    own = found.fits[name]
    rows = tuple((case, *_face(face)) for case, face in own.by_case.items())
    head = ("load case", "mean, MPa", "least, MPa", "largest, MPa", "lifted, %", "slips, %")
    caption = f"Fit of the {name}: pressures on the seat, {1e3 * own.interference_mm:.0f} µm of interference"
    return Table(caption, head, rows)


def _face(face: FaceCaseFigures) -> tuple[str, ...]:
    pressures = (face.mean_pressure_MPa, face.min_pressure_MPa, face.max_pressure_MPa)
    shares = (face.open_percent, face.slipping_percent)
    return (*(number(value, ".1f") for value in pressures), *(number(value, ".0f") for value in shares))
