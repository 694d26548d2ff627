"""The bolts of a study's cap: what it says of them, and what is assumed where it says nothing."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from fea.base.choices import ThreadRolled
from fea.base.material import Material
from fea.base.note import Assumed, Note, assumptions, doubt, remark, warning
from fea.base.units import INCH, KN, N_M, UM
from fea.judge.bolt import USUAL_EMBEDDING, UTILISATION, Bolt, ClampedParts, TightenedBolt, Tightening
from fea.study.assembly_table import (
    AFTERMARKET,
    BOLT,
    LUBRICANTS,
    PROOF_RATIO,
    SCATTER,
    TIGHTENED,
    YIELD_ESTIMATED,
    AssemblyTable,
    BoltStrength,
    Thread,
    bolt_strength,
    thread_in_hole,
)
from fea.study.material_table import DEFAULT_GRADE, MaterialTable, bolt_material
from geometry.assembly import PLAIN, ROOM, WIDER
from geometry.errors import InvalidValue, require
from geometry.outline import bosses
from geometry.rod import Rod


@dataclass(frozen=True)
class BoltSeats:
    """A hole through cap and rod, with plane seats around it."""

    hole: float  #: diameter, mm
    #: From the head's seat to the far seat, or to the end of a hole that does not go through, mm
    length: float
    cap: float  #: from the head's seat to the joint, mm
    room: float  #: largest radius of a seat around the axis, mm
    outer: float  #: diameter of a cylinder around the axis that the clamped parts fill, mm
    through: bool = True  #: whether there is a far seat for a nut


def seats_of(rod: Rod) -> BoltSeats:
    """Return the seats of a parametric rod with cap bolts (`Rod.cap_bolt` is positive)."""
    boss = bosses(rod)
    if boss is None:
        raise ValueError("the rod has no cap bolts")
    outside, across = boss.top - boss.bolt_at, rod.big_end_width / 2
    return BoltSeats(
        hole=rod.cap_bolt,
        length=2 * boss.half_length,
        cap=boss.half_length,
        room=ROOM * min(outside, across, boss.bolt_at - boss.seat),
        outer=2 * min(outside, across, boss.bolt_at - rod.big_end_bore / 2),
    )


# Height of a nut over d (ISO 4032: 0.84 to 0.9), beyond which a bolt stands out by two pitches.
_NUT_HEIGHT = 0.9
# Engaged thread over d in steel: usual, and least (suppliers' tables for property class 10.9: 0.8 to 1.25).
_ENGAGED, _LEAST_ENGAGED = 1.25, 0.8
# Least shank, of waisted bolts, over d.
_LEAST_SHANK = 0.6
_ALIKE = 1e-6


# Of thread and head, of oiled steel: within friction class B of VDI 2230, table A5 (0.08 to 0.16).
FRICTION = 0.12


def _bolt(
    table: AssemblyTable,
    seats: BoltSeats,
    bolt_table: MaterialTable | None,
    rod_modulus: float,
    assumed: Assumed,
) -> Bolt:
    """Complete what a study says of its bolts. Raises `InvalidValue`: they do not fit the rod."""
    thread = _thread(table, seats, assumed)
    d, (grip, engaged) = thread.diameter, _grip(table, seats, thread, assumed)
    head = _seat(table, "head", seats, thread, assumed)
    nut = _seat(table, "nut", seats, thread, assumed) if engaged == 0 else 0.0
    shank = assumed.or_else(table.bolt_shank_mm, d, "shank {:g} mm (assembly.bolt_shank_mm)")
    least = _LEAST_SHANK * d
    rule = f"must be at least {least:.3g} mm and at most the hole's diameter, {seats.hole:g} mm"
    require(least <= shank <= seats.hole * (1 + _ALIKE), "assembly.bolt_shank_mm", shank, rule)
    # Of bolts of up to 125 mm, 2 d + 6 mm are threaded (ISO 4014).
    usual = 2 * d + 6 - (_NUT_HEIGHT * d + 2 * thread.pitch if engaged == 0 else engaged)
    key = "assembly.bolt_free_thread_mm"
    usual = min(max(usual, 0.0), grip)
    free = assumed.or_else(table.bolt_free_thread_mm, usual, f"{{:.3g}} mm of thread in the grip ({key})")
    require(free <= grip, key, free, f"must be at most the grip, {grip:g} mm")
    strength = _strength(table, bolt_table, thread, assumed)
    thread_friction, head_friction = _friction(table, assumed)
    tables = {} if bolt_table is None else {BOLT: bolt_table}
    modulus = bolt_material(tables, table.grade).material().youngs_modulus
    return Bolt(
        thread=thread,
        grip=grip,
        engaged=engaged,
        head_diameter=head,
        nut_diameter=nut,
        shank_diameter=shank,
        free_thread=free,
        hole=seats.hole,
        modulus=modulus,
        counter_modulus=modulus if engaged == 0 else rod_modulus,
        strength=strength,
        thread_friction=thread_friction,
        head_friction=head_friction,
        rolled=_rolled(table),
    )


def _thread(table: AssemblyTable, seats: BoltSeats, assumed: Assumed) -> Thread:
    thread, key = table.thread, "assembly.bolt_thread"
    if thread is not None:
        rule = f"must not be thicker than its hole, {seats.hole:g} mm"
        fits = thread.diameter <= seats.hole * (1 + _ALIKE)
        require(fits, key, table.bolt_thread, rule, "Enlarge the hole (rod.cap_bolt_mm).")
        return thread
    standard = thread_in_hole(seats.hole)
    if standard is None:
        rule = f"is missing, and no standard bolt goes through a hole of {seats.hole:g} mm"
        raise InvalidValue(key, None, rule, 'Give it, as "M2.5x0.45".')
    assumed.append(f"thread {standard.name} ({key})")
    return standard


def _grip(table: AssemblyTable, seats: BoltSeats, thread: Thread, assumed: Assumed) -> tuple[float, float]:
    """Grip and engaged length, mm."""
    given, length = table.bolt_grip_mm, seats.length
    shorter = given is not None and given < length * (1 - 1e-3)
    if table.bolt_nut_mm is None and (table.bolt_engaged_mm is not None or shorter or not seats.through):
        return _screwed(table, seats, thread, assumed)
    rule = "has no seat: the hole does not go through"
    require(seats.through, "assembly.bolt_nut_mm", table.bolt_nut_mm, rule, "Leave it out.")
    rule = f"of a bolt with a nut must be the distance of the seats, {length:g} mm"
    remedy = "Leave it out, or leave out bolt_nut_mm for a screw in a threaded hole."
    alike = given is None or math.isclose(given, length, rel_tol=1e-3)
    require(alike, "assembly.bolt_grip_mm", given, rule, remedy)
    if given is None:
        assumed.append(f"a nut, and thus a grip of {length:.4g} mm (assembly.bolt_grip_mm)")
    return length, 0.0


def _screwed(table: AssemblyTable, seats: BoltSeats, thread: Thread, assumed: Assumed) -> tuple[float, float]:
    given, key = table.bolt_grip_mm, "assembly.bolt_grip_mm"
    wanted = table.bolt_engaged_mm or _ENGAGED * thread.diameter
    grip = seats.length - wanted if given is None else given
    left = seats.length - grip
    rule = f"must reach beyond the joint, {seats.cap:.4g} mm from the head's seat, to clamp the cap"
    remedy = "Lengthen the grip, the bosses (rod.cap_boss_length_mm) or the hole, or engage less thread."
    require(grip >= seats.cap, key, grip, rule, remedy)
    if given is None:
        assumed.append(f"grip {grip:.4g} mm ({key})")
    if table.bolt_engaged_mm is not None:
        rule = f"must be at most {left:.4g} mm, what the grip of {grip:.4g} mm leaves of the hole"
        require(wanted <= left * (1 + _ALIKE), "assembly.bolt_engaged_mm", wanted, rule, remedy)
    # A thread that nearly reaches the end of the hole reaches it.
    near = table.bolt_engaged_mm is None and left - wanted < PLAIN * seats.hole
    engaged, least = left if near else wanted, _LEAST_ENGAGED * thread.diameter
    rule = f"leaves {engaged:.4g} mm of engaged thread, less than {_LEAST_ENGAGED:g} d: it would strip"
    remedy = f"Engage at least {least:.4g} mm."
    require(engaged >= least * (1 - _ALIKE), key, grip, rule, remedy)
    if table.bolt_engaged_mm is None:
        assumed.append(f"{engaged:.4g} mm of engaged thread (assembly.bolt_engaged_mm)")
    return grip, engaged


def _seat(table: AssemblyTable, what: str, seats: BoltSeats, thread: Thread, assumed: Assumed) -> float:
    key, least, most = f"bolt_{what}_mm", WIDER * seats.hole, 2 * seats.room
    name, given = f"assembly.{key}", getattr(table, key)
    needed = f"needs at least {least:.4g} mm, {WIDER:g} of the hole"
    rule = f"{needed}, and the rod has a seat of {most:.4g} mm"
    remedy = "Increase rod.cap_bolt_spacing_mm, or rod.cap_boss_length_mm."
    require(most >= least, name, given, rule, remedy)
    usual = min(max(thread.usual_seat, least), most)
    seat: float = assumed.or_else(given, usual, f"a seat of {{:.3g}} mm under the {what} ({name})")
    rule = f"must be {least:.4g} to {most:.4g} mm: wider than the hole, and on the plane seat"
    require(least * (1 - _ALIKE) <= seat <= most * (1 + _ALIKE), name, seat, rule)
    return seat


BOLTS = "bolts"


def _notes(tightened: TightenedBolt, table: AssemblyTable, clamped: Material) -> Iterator[Note]:
    """Explain what tightening means for bolt and seats. Raises `InvalidValue`: the bolt breaks."""
    bolt, tightening = tightened.bolt, tightened.tightening
    force, stress = tightening.preload, tightened.tightening_stress
    key = next((key for key in TIGHTENED if getattr(table, key) is not None), TIGHTENED[0])
    rule = (
        f"breaks the bolt: {force / KN:.4g} kN make {stress:.0f} MPa in {bolt.thread.name}, "
        f"whose ultimate strength is {bolt.strength.ultimate:g} MPa"
    )
    remedy = "Reduce it, or choose a thicker or stronger bolt."
    require(stress < bolt.strength.ultimate, f"assembly.{key}", getattr(table, key), rule, remedy)
    torsion = ", with the torsion of tightening" if tightening.turned else ""
    judged = (
        f"{bolt.thread.name}, tightened to {tightening}: {force / bolt.proof_load:.0%} of the "
        f"proof load, {stress / bolt.strength.yield_strength:.0%} of the yield strength{torsion}"
    )
    yield remark(judged, BOLTS)
    if tightening.yields:
        preload = "the preload is that at which they yield while they are turned"
        yield warning(f"the angle turns them beyond yield: {preload}", BOLTS)
    elif stress > bolt.strength.yield_strength:
        yield doubt("tightening yields them, so that only a measured preload can be relied on", BOLTS)
    elif force > bolt.proof_load:
        yield doubt("the preload exceeds the proof load, so that they may not keep their length", BOLTS)
    # Limiting pressures on seats, beyond which they creep (R10), are 0.75 to 1.5 times the ultimate strength
    # in table A9; here it stands for them.
    pressure = force / bolt.least_seat_area
    limit = clamped.ultimate_strength or clamped.yield_strength
    if pressure > limit:
        seats = f"{pressure:.0f} MPa under head or nut, and the strength of the rod is {limit:g} MPa: "
        keys = "(assembly.bolt_head_mm, assembly.bolt_nut_mm)"
        yield warning(f"{seats}the seat may creep and the preload fall {keys}", BOLTS)
    factor = table.bolt_tightening_factor  # α_A = F_Mmax/F_Mmin (R6)
    if factor not in {None, 1}:
        least = f"tightening with a factor of {factor:g} may leave only {force / factor / KN:.3g} kN; "
        yield warning(f"{least}the figures are those of {force / KN:.3g} kN", BOLTS)
    if table.bolt_embedding_um is not None:
        yield remark(f"embedding takes {tightened.embedding_loss / KN:.2g} kN of the preload", BOLTS)
    else:
        usual = USUAL_EMBEDDING / (bolt.compliance + tightened.parts_compliance)
        about = f"by table 5 of VDI 2230 it takes about {usual / KN:.2g} kN (assembly.bolt_embedding_um)"
        yield warning(f"embedding is not deducted; {about}", BOLTS)


def choose_bolt(
    table: AssemblyTable, seats: BoltSeats, bolt_table: MaterialTable | None, clamped: Material
) -> TightenedBolt:
    """Complete [assembly] and [material.bolt]. Raises `InvalidValue`: it does not fit, or breaks."""
    assumed = Assumed()
    bolt = _bolt(table, seats, bolt_table, clamped.youngs_modulus, assumed)
    nut = bolt.engaged == 0
    parts = ClampedParts(
        bolt.grip, bolt.head_diameter, seats.hole, seats.outer, clamped.youngs_modulus, nut
    ).compliance
    tightening = _tightening(table, bolt, parts)
    if table.bolt_tightening_factor is not None:
        tightening = tightening._replace(scatter=None)
    preload = tightening.preload
    if all(getattr(table, name) is None for name in TIGHTENED):
        assumed.append(
            f"preload {preload / KN:.3g} kN, {UTILISATION:.0%} of the yield strength in tightening as in VDI "
            "2230 (assembly.bolt_preload_kN, bolt_torque_Nm or bolt_stretch_mm)"
        )
    loss = (table.bolt_embedding_um or 0.0) * UM / (bolt.compliance + parts)
    rule = f"takes {loss / KN:.3g} kN, all of the preload of {preload / KN:.3g} kN"
    remedy = "Check the unit, or tighten the bolts more."
    require(loss < preload, "assembly.bolt_embedding_um", table.bolt_embedding_um, rule, remedy)
    if table.bolt_thread_rolled is None:
        assumed.append(_ROLLED[bolt.rolled])
    tightened = TightenedBolt(bolt, tightening, loss, parts)
    notes = (*assumptions(BOLTS, assumed), *_notes(tightened, table, clamped))
    return replace(tightened, notes=notes)


def _strength(
    table: AssemblyTable, bolt_table: MaterialTable | None, thread: Thread, assumed: Assumed
) -> BoltStrength:
    """Strengths of [material.bolt] where it has them, else those of the property class."""
    given = None if bolt_table is None else bolt_table.resolved()
    if given is None or given.yield_MPa is None:
        if table.grade is None:
            assumed.append(f"property class {DEFAULT_GRADE.value} (assembly.bolt_grade)")
        elif table.grade in YIELD_ESTIMATED:
            assumed.append(f"the yield strength of {table.grade.value}, an estimate ([material.bolt])")
        return bolt_strength(table.grade or DEFAULT_GRADE, thread.diameter)
    key, rule = "material.bolt.ultimate_MPa", "must be given, at least as large as the yield strength"
    ultimate = given.ultimate_MPa or 0.0
    require(ultimate >= given.yield_MPa, key, given.ultimate_MPa, rule, "The bolt's limits follow from it.")
    return BoltStrength(PROOF_RATIO * given.yield_MPa, given.yield_MPa, ultimate)


def _friction(table: AssemblyTable, assumed: Assumed) -> tuple[float, float]:
    if table.bolt_lubricant is not None:
        usual = LUBRICANTS[table.bolt_lubricant]
        given = (table.thread_friction, table.head_friction)
        thread, head = (usual if friction is None else friction for friction in given)
        return thread, head
    in_thread = "friction {:g} in the thread (assembly.thread_friction)"
    under_head = "friction {:g} under the head (assembly.head_friction)"
    thread = assumed.or_else(table.thread_friction, FRICTION, in_thread)
    return thread, assumed.or_else(table.head_friction, FRICTION, under_head)


def _tightening(table: AssemblyTable, bolt: Bolt, parts: float) -> Tightening:
    """Preload by what the study gives, and how it follows; `parts`: compliance of the clamped parts, mm/N."""
    torque, stretch, angle = table.bolt_torque_Nm, table.bolt_stretch_mm, table.bolt_angle_deg
    friction = f"friction {bolt.thread_friction:g} in the thread and {bolt.head_friction:g} under the head"
    if stretch is not None:
        give = bolt.stretch_compliance
        how = f"by a stretch of {stretch:.3g} mm ({stretch / INCH * 1e3:.3g} thousandths of an inch)"
        how += f" at {give * KN / UM:.3g} µm/kN"
        return Tightening(stretch / give, how, SCATTER["stretch"], turned=False)
    if torque is None:
        preload = bolt.allowed_preload if table.bolt_preload_kN is None else table.bolt_preload_kN * KN
        return Tightening(preload, f"by {preload * bolt.lever / N_M:.3g} N·m")
    snug, give = torque * N_M / bolt.lever, bolt.compliance + parts
    if angle is None:
        return Tightening(snug, f"by {torque:.3g} N·m with {friction}", SCATTER["torque"])
    # Bolt and parts take up the turn: F = F_snug + θ/360° P/(δ_S + δ_P), until the bolt yields.
    force, most = snug + angle / 360 * bolt.thread.pitch / give, bolt.allowed_preload / UTILISATION
    how = f"by {torque:g} N·m ({snug / KN:.3g} kN with {friction}) and {angle:g}°"
    how += f" at {give * KN / UM:.3g} µm/kN of bolt and parts"
    return Tightening(min(force, most), how, SCATTER["angle"], yields=force > most)


_ROLLED = {
    ThreadRolled.AFTER: (
        "thread rolled after heat treatment, as makers of such bolts say, and the endurance of VDI 2230, "
        "which is that of classes up to 12.9 (assembly.bolt_thread_rolled)"
    ),
    ThreadRolled.BEFORE: "thread rolled before heat treatment (assembly.bolt_thread_rolled)",
}


def _rolled(table: AssemblyTable) -> ThreadRolled:
    usual = ThreadRolled.AFTER if table.grade in AFTERMARKET else ThreadRolled.BEFORE
    return table.bolt_thread_rolled or usual
