"""The bolts of a study's cap: what it says of them, and what is assumed where it says nothing."""

from dataclasses import dataclass

from fea.assess.assumed import Assumed
from fea.assess.bolt_compliance import BoltCompliance, bolt_compliance
from fea.assess.bolt_remarks import (
    embedding_remark,
    scatter_remarks,
    seat_remarks,
    tightening_remarks,
)
from fea.assess.bolt_seats import BoltSeats
from fea.assess.bolt_shape import BoltShape, bolt_shape
from fea.assess.bolt_tightening import UTILISATION, Lever, allowed_preload
from fea.assess.clamped_parts import ClampedParts
from fea.assess.joint_diagram import embedding_loss, expected_embedding, load_factor
from fea.choices import ThreadRolled
from fea.material import Material
from fea.rod.bolt import Bolt
from fea.study.assembly_materials import BOLT, DEFAULT_GRADE, bolt_material
from fea.study.assembly_table import AssemblyTable
from fea.study.bolt_grades import PROOF_RATIO, BoltStrength, bolt_strength
from fea.study.material_table import MaterialTable
from fea.units import KN, N_M, UM
from geometry.invalid import require

# Of thread and head, of oiled steel: within friction class B of VDI 2230, table A5 (0.08 to 0.16).
FRICTION = 0.12


@dataclass(frozen=True)
class ChosenBolt:
    """A bolt, and what a reader must know of it.

    Attributes
    ----------
    bolt
        The bolt.
    compliance
        Its parts.
    parts_compliance
        δ_P of the clamped parts by VDI 2230's deformation cone, mm/N, for comparison.
    torque
        That gives its preload, N·mm.
    assumed
        What the study does not say, in words.
    said
        Of its tightening.
    """

    bolt: Bolt
    compliance: BoltCompliance
    parts_compliance: float
    torque: float
    assumed: tuple[str, ...]
    said: tuple[str, ...]

    @property
    def load_factor(self) -> float:
        """Φ_K by VDI 2230, of a central load at the seats, for comparison."""
        return load_factor(self.compliance.total, self.parts_compliance)

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader must know."""
        assumed = [f"bolts: assumed are {', '.join(self.assumed)}"] if self.assumed else []
        return (*assumed, *self.said)


def choose_bolt(
    table: AssemblyTable, seats: BoltSeats, own: MaterialTable | None, clamped: Material
) -> ChosenBolt:
    """Complete what a study says of its bolts.

    Parameters
    ----------
    table
        [assembly].
    seats
        The room that the rod has.
    own
        [material.bolt], if it is given.
    clamped
        Material of the rod.

    Raises
    ------
    InvalidValue
        The bolt does not fit the rod, or tightening breaks it.
    """
    assumed = Assumed()
    shape = bolt_shape(table, seats, assumed)
    strength = _strength(table, own, shape, assumed)
    compliance, parts = _compliances(table, shape, seats, own, clamped.youngs_modulus)
    friction = _friction(table, assumed)
    lever = Lever(shape.thread, (shape.head + seats.hole) / 2, *friction)
    limit = allowed_preload(shape.thread, shape.least_diameter, friction[0], strength.yield_strength)
    preload = _preload(table, lever, compliance, limit, assumed)
    loss = embedding_loss((table.bolt_embedding_um or 0.0) * UM, compliance.total, parts)
    rule = f"takes {loss / KN:.3g} kN, all of the preload of {preload / KN:.3g} kN"
    remedy = "Check the unit, or tighten the bolts more."
    require(loss < preload, "assembly.bolt_embedding_um", table.bolt_embedding_um, rule, remedy)
    bolt = Bolt(
        thread=shape.thread,
        preload=preload - loss,
        assembly_preload=preload,
        stiffness=1 / compliance.total,
        head_diameter=shape.head,
        nut_diameter=shape.nut,
        engaged=shape.grip.engaged,
        grip=shape.grip.length,
        hole=seats.hole,
        shank_diameter=shape.shank,
        proof=strength.proof,
        yield_strength=strength.yield_strength,
        ultimate_strength=strength.ultimate,
        thread_friction=friction[0],
        head_friction=friction[1],
        rolled=_rolled(table, assumed),
    )
    torque = lever.torque(preload)
    expected = embedding_loss(expected_embedding(), compliance.total, parts)
    said = (
        *tightening_remarks(bolt, table, torque),
        *seat_remarks(bolt, clamped),
        *scatter_remarks(bolt, table.bolt_tightening_factor),
        embedding_remark(table.bolt_embedding_um, loss, expected),
    )
    return ChosenBolt(bolt, compliance, parts, torque, tuple(assumed), said)


def _strength(
    table: AssemblyTable, own: MaterialTable | None, shape: BoltShape, assumed: Assumed
) -> BoltStrength:
    """Strengths of [material.bolt] where it has them, else those of the property class."""
    given = None if own is None else own.resolved()
    if given is None or given.yield_MPa is None:
        if table.grade is None:
            assumed.append(f"property class {DEFAULT_GRADE.value} (assembly.bolt_grade)")
        return bolt_strength(table.grade or DEFAULT_GRADE, shape.thread.diameter)
    key, rule = "material.bolt.ultimate_MPa", "must be given, at least as large as the yield strength"
    ultimate = given.ultimate_MPa or 0.0
    require(ultimate >= given.yield_MPa, key, given.ultimate_MPa, rule, "The bolt's limits follow from it.")
    return BoltStrength(PROOF_RATIO * given.yield_MPa, given.yield_MPa, ultimate)


def _compliances(
    table: AssemblyTable, shape: BoltShape, seats: BoltSeats, own: MaterialTable | None, rod_modulus: float
) -> tuple[BoltCompliance, float]:
    """Compliance of the bolt, and of the parts by the guideline."""
    material = bolt_material({} if own is None else {BOLT: own}, table.grade)
    modulus, grip = material.material().youngs_modulus, shape.grip
    bolt = bolt_compliance(
        shape.thread,
        grip=grip.length,
        free_thread=shape.free_thread,
        shank_area=shape.shank_area,
        modulus=modulus,
        counter_modulus=modulus if grip.nut else rod_modulus,
        nut=grip.nut,
    )
    parts = ClampedParts(grip.length, shape.head, seats.hole, seats.outer, rod_modulus, grip.nut)
    return bolt, parts.compliance


def _friction(table: AssemblyTable, assumed: Assumed) -> tuple[float, float]:
    """μ_G and μ_K."""
    thread = assumed.or_else(
        table.thread_friction, FRICTION, "friction {:g} in the thread (assembly.thread_friction)"
    )
    head = assumed.or_else(
        table.head_friction, FRICTION, "friction {:g} under the head (assembly.head_friction)"
    )
    return thread, head


def _preload(
    table: AssemblyTable,
    lever: Lever,
    compliance: BoltCompliance,
    limit: float,
    assumed: Assumed,
) -> float:
    """Force after tightening, N."""
    if table.bolt_torque_Nm is not None:
        return lever.preload(table.bolt_torque_Nm * N_M)
    if table.bolt_stretch_mm is not None:
        return table.bolt_stretch_mm / compliance.between_ends
    if table.bolt_preload_kN is not None:
        return table.bolt_preload_kN * KN
    assumed.append(
        f"preload {limit / KN:.3g} kN, {UTILISATION:.0%} of the yield strength in tightening as in VDI 2230 "
        "(assembly.bolt_preload_kN, bolt_torque_Nm or bolt_stretch_mm)"
    )
    return limit


def _rolled(table: AssemblyTable, assumed: Assumed) -> ThreadRolled:
    if table.bolt_thread_rolled is not None:
        return table.bolt_thread_rolled
    assumed.append("thread rolled before heat treatment (assembly.bolt_thread_rolled)")
    return ThreadRolled.BEFORE
