"""What tightening means for a bolt, in words; a bolt that it breaks is refused."""

from fea.assess.bolt_tightening import tightening_stress
from fea.material import Material
from fea.rod.bolt import Bolt
from fea.study.assembly_table import AssemblyTable
from fea.units import KN, N_M
from geometry.invalid import require

_TIGHTENED = ("bolt_preload_kN", "bolt_torque_Nm", "bolt_stretch_mm")


def tightening_remarks(bolt: Bolt, table: AssemblyTable, torque: float) -> tuple[str, ...]:
    """Judge the end of tightening, by a torque in N·mm.

    Raises
    ------
    InvalidValue
        The bolt breaks.
    """
    force, turned = bolt.assembly_preload, table.bolt_stretch_mm is None
    stress = force / bolt.least_area
    if turned:
        stress = tightening_stress(force, bolt.thread, bolt.least_diameter, bolt.thread_friction)
    _require_whole(bolt, table, stress)
    how = f"by {torque / N_M:.3g} N·m" if turned else "by stretching"
    torsion = ", with the torsion of tightening" if turned else ""
    said = (
        f"bolts: {bolt.thread.name}, tightened to {force / KN:.3g} kN {how}: "
        f"{force / bolt.proof_load:.0%} of the proof load, "
        f"{stress / bolt.yield_strength:.0%} of the yield strength{torsion}"
    )
    if stress > bolt.yield_strength:
        return said, "bolts: tightening yields them, so that only a measured preload can be relied on"
    if force > bolt.proof_load:
        return said, "bolts: the preload exceeds the proof load, so that they may not keep their length"
    return (said,)


def _require_whole(bolt: Bolt, table: AssemblyTable, stress: float) -> None:
    key = next((key for key in _TIGHTENED if getattr(table, key) is not None), _TIGHTENED[0])
    rule = (
        f"breaks the bolt: {bolt.assembly_preload / KN:.4g} kN make {stress:.0f} MPa in {bolt.thread.name}, "
        f"whose ultimate strength is {bolt.ultimate_strength:g} MPa"
    )
    remedy = "Reduce it, or choose a thicker or stronger bolt."
    require(stress < bolt.ultimate_strength, f"assembly.{key}", getattr(table, key), rule, remedy)


def seat_remarks(bolt: Bolt, clamped: Material) -> tuple[str, ...]:
    """Warn of seats that creep under the preload (VDI 2230-1, step R10).

    The limiting pressures of table A9 are 0.75 to 1.5 times the ultimate strength; here it stands for them.
    """
    pressure = bolt.assembly_preload / bolt.least_seat_area
    limit = clamped.ultimate_strength or clamped.yield_strength
    if pressure <= limit:
        return ()
    said = (
        f"bolts: {pressure:.0f} MPa under head or nut, and the strength of the rod is {limit:g} MPa: "
        "the seat may creep and the preload fall (assembly.bolt_head_mm, assembly.bolt_nut_mm)"
    )
    return (said,)


def scatter_remarks(bolt: Bolt, factor: float | None) -> tuple[str, ...]:
    """Say how small the preload may be, F_Mmax/α_A (VDI 2230-1, step R6), where α_A is given."""
    if factor is None or factor == 1:
        return ()
    least = bolt.assembly_preload / factor
    said = (
        f"bolts: tightening with a factor of {factor:g} may leave only {least / KN:.3g} kN; "
        f"the figures are those of {bolt.assembly_preload / KN:.3g} kN"
    )
    return (said,)


def embedding_remark(given: float | None, loss: float, expected: float) -> str:
    """Say what embedding takes of the preload: by a given amount, µm, or about; losses in N."""
    if given is not None:
        return f"bolts: embedding takes {loss / KN:.2g} kN of the preload"
    return (
        f"bolts: embedding is not deducted; by table 5 of VDI 2230 it takes about {expected / KN:.2g} kN "
        "(assembly.bolt_embedding_um)"
    )
