"""The bolts of a study's cap: what it says of them, and what is assumed where it says nothing."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from fea.base.choices import ThreadRolled
from fea.base.material import Material
from fea.base.note import Assumed, Note, assumptions, doubt, remark, warning
from fea.base.units import INCH, KN, N_M, UM
from fea.contact.bolt_beam import BoltBeam
from fea.judge.bolt import Bolt
from fea.judge.bolt_shape import BoltSeats, BoltShape, bolt_shape
from fea.judge.vdi2230 import (
    UTILISATION,
    BoltCompliance,
    ClampedParts,
    Lever,
    allowed_preload,
    bolt_beam,
    bolt_compliance,
    embedding_loss,
    expected_embedding,
    load_factor,
)
from fea.study.assembly_table import BOLT, DEFAULT_GRADE, AssemblyTable, bolt_material
from fea.study.bolts import (
    LUBRICANTS,
    PROOF_RATIO,
    SCATTER,
    BoltStrength,
    bolt_strength,
    is_aftermarket,
    yield_estimated,
)
from fea.study.material_table import MaterialTable
from geometry.errors import require

_BOLTS = "bolts"
_TIGHTENED = ("bolt_preload_kN", "bolt_torque_Nm", "bolt_stretch_mm")


class Tightening(NamedTuple):
    """How bolts are tightened."""

    preload: float  #: N, before embedding
    how: str  #: in words
    scatter: tuple[int, int] | None = None  #: of the preload, ± per cent from and to, where it is usual
    yields: bool = False  #: whether it is the force at which the turned bolt yields

    def __str__(self) -> str:
        scatter = "" if self.scatter is None else ", usually ±{} to {} % (VDI 2230)".format(*self.scatter)
        return f"{self.preload / KN:.3g} kN {self.how}{scatter}"


def tightening_notes(bolt: Bolt, table: AssemblyTable, tightening: Tightening) -> tuple[Note, ...]:
    """Judge the end of tightening.

    Raises `InvalidValue`: the bolt breaks.
    """
    force, turned = bolt.assembly_preload, table.bolt_stretch_mm is None
    stress = bolt.tightening_stress(turned=turned)
    _require_whole(bolt, table, stress)
    torsion = ", with the torsion of tightening" if turned else ""
    judged = (
        f"{bolt.thread.name}, tightened to {tightening}: {force / bolt.proof_load:.0%} of the "
        f"proof load, {stress / bolt.strength.yield_strength:.0%} of the yield strength{torsion}"
    )
    said = [remark(judged, _BOLTS)]
    if tightening.yields:
        text = (
            "the angle turns them beyond yield: the preload is that at which they yield while they are turned"
        )
        said.append(warning(text, _BOLTS))
    elif stress > bolt.strength.yield_strength:
        text = "tightening yields them, so that only a measured preload can be relied on"
        said.append(doubt(text, _BOLTS))
    elif force > bolt.proof_load:
        text = "the preload exceeds the proof load, so that they may not keep their length"
        said.append(doubt(text, _BOLTS))
    return tuple(said)


def _require_whole(bolt: Bolt, table: AssemblyTable, stress: float) -> None:
    key = next((key for key in _TIGHTENED if getattr(table, key) is not None), _TIGHTENED[0])
    rule = (
        f"breaks the bolt: {bolt.assembly_preload / KN:.4g} kN make {stress:.0f} MPa in {bolt.thread.name}, "
        f"whose ultimate strength is {bolt.strength.ultimate:g} MPa"
    )
    remedy = "Reduce it, or choose a thicker or stronger bolt."
    require(stress < bolt.strength.ultimate, f"assembly.{key}", getattr(table, key), rule, remedy)


def seat_notes(bolt: Bolt, clamped: Material) -> tuple[Note, ...]:
    """Warn of seats that creep under the preload (VDI 2230-1, step R10).

    The limiting pressures of table A9 are 0.75 to 1.5 times the ultimate strength; here it stands for them.
    """
    pressure = bolt.assembly_preload / bolt.least_seat_area
    limit = clamped.ultimate_strength or clamped.yield_strength
    if pressure <= limit:
        return ()
    text = (
        f"{pressure:.0f} MPa under head or nut, and the strength of the rod is {limit:g} MPa: "
        "the seat may creep and the preload fall (assembly.bolt_head_mm, assembly.bolt_nut_mm)"
    )
    return (warning(text, _BOLTS),)


def scatter_notes(bolt: Bolt, factor: float | None) -> tuple[Note, ...]:
    """Say how small the preload may be, F_Mmax/α_A (VDI 2230-1, step R6), where α_A is given."""
    if factor is None or factor == 1:
        return ()
    least = bolt.assembly_preload / factor
    text = (
        f"tightening with a factor of {factor:g} may leave only {least / KN:.3g} kN; "
        f"the figures are those of {bolt.assembly_preload / KN:.3g} kN"
    )
    return (warning(text, _BOLTS),)


def embedding_note(given: float | None, loss: float, expected: float) -> Note:
    """Say what embedding takes of the preload: by a given amount, µm, or about; losses in N."""
    if given is not None:
        return remark(f"embedding takes {loss / KN:.2g} kN of the preload", _BOLTS)
    text = (
        f"embedding is not deducted; by table 5 of VDI 2230 it takes about {expected / KN:.2g} kN "
        "(assembly.bolt_embedding_um)"
    )
    return warning(text, _BOLTS)


# Of thread and head, of oiled steel: within friction class B of VDI 2230, table A5 (0.08 to 0.16).
FRICTION = 0.12


@dataclass(frozen=True)
class ChosenBolt:
    """A bolt, and what a reader must know of it."""

    bolt: Bolt
    compliance: BoltCompliance  #: its parts
    beam: BoltBeam  #: as it bends
    parts_compliance: float  #: δ_P of the clamped parts by VDI 2230's deformation cone, mm/N, for comparison
    torque: float  #: that gives its preload, N·mm
    tightening: Tightening
    notes: tuple[Note, ...]

    @property
    def load_factor(self) -> float:
        """Φ_K by VDI 2230, of a central load at the seats, for comparison."""
        return load_factor(self.compliance.total, self.parts_compliance)


def choose_bolt(
    table: AssemblyTable, seats: BoltSeats, bolt_table: MaterialTable | None, clamped: Material
) -> ChosenBolt:
    """Complete what a study says of its bolts: [assembly], and [material.bolt] if it is given.

    Raises `InvalidValue`: the bolt does not fit the rod, or tightening breaks it.
    """
    assumed = Assumed()
    shape = bolt_shape(table, seats, assumed)
    strength = _strength(table, bolt_table, shape, assumed)
    compliance, beam, parts = _compliances(table, shape, seats, bolt_table, clamped.youngs_modulus)
    friction = _friction(table, assumed)
    lever = Lever(shape.thread, (shape.head_diameter + seats.hole) / 2, *friction)
    limit = allowed_preload(shape.thread, shape.least_diameter, friction[0], strength.yield_strength)
    tightening = _tightening(table, lever, compliance, parts, limit)
    if table.bolt_tightening_factor is not None:
        tightening = tightening._replace(scatter=None)
    preload = tightening.preload
    if all(getattr(table, name) is None for name in _TIGHTENED):
        assumed.append(
            f"preload {limit / KN:.3g} kN, {UTILISATION:.0%} of the yield strength in tightening as in VDI "
            "2230 (assembly.bolt_preload_kN, bolt_torque_Nm or bolt_stretch_mm)"
        )
    loss = embedding_loss((table.bolt_embedding_um or 0.0) * UM, compliance.total, parts)
    rule = f"takes {loss / KN:.3g} kN, all of the preload of {preload / KN:.3g} kN"
    remedy = "Check the unit, or tighten the bolts more."
    require(loss < preload, "assembly.bolt_embedding_um", table.bolt_embedding_um, rule, remedy)
    bolt = Bolt(
        **vars(shape),
        strength=strength,
        stiffness=1 / compliance.total,
        thread_friction=friction[0],
        rolled=_rolled(table, assumed),
        assembly_preload=preload,
        preload=preload - loss,
    )
    torque = lever.torque(preload)
    expected = embedding_loss(expected_embedding(), compliance.total, parts)
    notes = (
        *assumptions(_BOLTS, assumed),
        *tightening_notes(bolt, table, tightening),
        *seat_notes(bolt, clamped),
        *scatter_notes(bolt, table.bolt_tightening_factor),
        embedding_note(table.bolt_embedding_um, loss, expected),
    )
    return ChosenBolt(bolt, compliance, beam, parts, torque, tightening, notes)


def _strength(
    table: AssemblyTable, bolt_table: MaterialTable | None, shape: BoltShape, assumed: Assumed
) -> BoltStrength:
    """Strengths of [material.bolt] where it has them, else those of the property class."""
    given = None if bolt_table is None else bolt_table.resolved()
    if given is None or given.yield_MPa is None:
        if table.grade is None:
            assumed.append(f"property class {DEFAULT_GRADE.value} (assembly.bolt_grade)")
        elif yield_estimated(table.grade):
            assumed.append(f"the yield strength of {table.grade.value}, an estimate ([material.bolt])")
        return bolt_strength(table.grade or DEFAULT_GRADE, shape.thread.diameter)
    key, rule = "material.bolt.ultimate_MPa", "must be given, at least as large as the yield strength"
    ultimate = given.ultimate_MPa or 0.0
    require(ultimate >= given.yield_MPa, key, given.ultimate_MPa, rule, "The bolt's limits follow from it.")
    return BoltStrength(PROOF_RATIO * given.yield_MPa, given.yield_MPa, ultimate)


def _compliances(
    table: AssemblyTable,
    shape: BoltShape,
    seats: BoltSeats,
    bolt_table: MaterialTable | None,
    rod_modulus: float,
) -> tuple[BoltCompliance, BoltBeam, float]:
    """Compliance of the bolt along its axis and in bending, and of the parts by the guideline."""
    modulus = (
        bolt_material({} if bolt_table is None else {BOLT: bolt_table}, table.grade).material().youngs_modulus
    )
    nut = shape.engaged == 0
    alike = {
        "grip": shape.grip,
        "free_thread": shape.free_thread,
        "modulus": modulus,
        "counter_modulus": modulus if nut else rod_modulus,
    }
    shank = shape.shank_diameter
    bolt = bolt_compliance(shape.thread, shank_area=math.pi / 4 * shank**2, nut=nut, **alike)
    beam = bolt_beam(shape.thread, shank_diameter=shank, nut=nut, **alike)
    parts = ClampedParts(shape.grip, shape.head_diameter, seats.hole, seats.outer, rod_modulus, nut)
    return bolt, beam, parts.compliance


def _friction(table: AssemblyTable, assumed: Assumed) -> tuple[float, float]:
    """μ_G and μ_K: as they are given, of the lubricant, or assumed."""
    if table.bolt_lubricant is not None:
        usual = LUBRICANTS[table.bolt_lubricant]
        given = (table.thread_friction, table.head_friction)
        thread, head = (usual if friction is None else friction for friction in given)
        return thread, head
    thread = assumed.or_else(
        table.thread_friction, FRICTION, "friction {:g} in the thread (assembly.thread_friction)"
    )
    head = assumed.or_else(
        table.head_friction, FRICTION, "friction {:g} under the head (assembly.head_friction)"
    )
    return thread, head


def _tightening(
    table: AssemblyTable, lever: Lever, compliance: BoltCompliance, parts: float, limit: float
) -> Tightening:
    """Preload by what the study gives, and how it follows; `limit` is VDI 2230's usual one."""
    torque, stretch, angle = table.bolt_torque_Nm, table.bolt_stretch_mm, table.bolt_angle_deg
    friction = f"friction {lever.thread_friction:g} in the thread and {lever.head_friction:g} under the head"
    if stretch is not None:
        give = compliance.between_ends
        how = f"by a stretch of {stretch:.3g} mm ({stretch / INCH * 1e3:.3g} thousandths of an inch)"
        return Tightening(stretch / give, f"{how} at {give * KN / UM:.3g} µm/kN", SCATTER["stretch"])
    if torque is None:
        preload = limit if table.bolt_preload_kN is None else table.bolt_preload_kN * KN
        return Tightening(preload, f"by {lever.torque(preload) / N_M:.3g} N·m")
    snug, give = lever.preload(torque * N_M), compliance.total + parts
    if angle is None:
        return Tightening(snug, f"by {torque:.3g} N·m with {friction}", SCATTER["torque"])
    # Bolt and parts take up the turn: F = F_snug + θ/360° P/(δ_S + δ_P), until the bolt yields.
    force, most = snug + angle / 360 * lever.thread.pitch / give, limit / UTILISATION
    how = f"by {torque:g} N·m ({snug / KN:.3g} kN with {friction}) and {angle:g}°"
    how += f" at {give * KN / UM:.3g} µm/kN of bolt and parts"
    return Tightening(min(force, most), how, SCATTER["angle"], yields=force > most)


def _rolled(table: AssemblyTable, assumed: Assumed) -> ThreadRolled:
    if table.bolt_thread_rolled is not None:
        return table.bolt_thread_rolled
    if table.grade is not None and is_aftermarket(table.grade):
        assumed.append(
            "thread rolled after heat treatment, as makers of such bolts say, and the endurance of VDI 2230, "
            "which is that of classes up to 12.9 (assembly.bolt_thread_rolled)"
        )
        return ThreadRolled.AFTER
    assumed.append("thread rolled before heat treatment (assembly.bolt_thread_rolled)")
    return ThreadRolled.BEFORE
