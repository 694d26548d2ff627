"""The job behind `fea bolts`: one run of a bolted rod, and a table of the bolts that fit its holes.

The table has the present bolt, and every grade in every standard thread that fits.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import isclose, isfinite
from pathlib import Path
from typing import Any, NamedTuple

from fea.analysis.assembling import AssemblySetup
from fea.analysis.figures import Figures, WhereKnown
from fea.analysis.pipeline import refined_rod, solve_speed
from fea.apps.bolts.preloads import PreloadedJoint
from fea.base.choices import BoltGrade, ThreadRolled
from fea.base.note import Note, NoteKind
from fea.base.units import INCH, KN, N_M
from fea.judge.bolt import UTILISATION, TightenedBolt
from fea.judge.safety_factor import SafetyFactor
from fea.machine.clock import Clock, Listener
from fea.rod.meshed_rod import MeshedRod
from fea.study.assembly_table import (
    BOLT,
    SCATTER,
    TIGHTENED,
    YIELD_ESTIMATED,
    AssemblyTable,
    Thread,
    threads_for_hole,
)
from fea.study.changes import load_cases_alone
from fea.study.material_table import DEFAULT_GRADE
from fea.study.study import Study, load_study
from geometry.errors import InvalidValue, require

# Keys of [assembly] that only the present bolt has: how it is tightened, and how it is made.
TIGHTENING: dict[str, Any] = dict.fromkeys((*TIGHTENED, "bolt_angle_deg", "bolt_tightening_factor"))
SIZES: dict[str, Any] = dict.fromkeys(("bolt_shank_mm", "bolt_free_thread_mm", "bolt_head_mm", "bolt_nut_mm"))
# Preloads that differ by less, relatively, are the same.
_SAME = 0.01
OWN_GRADE = "as given"  #: the name of a grade whose strengths are those of [material.bolt]


@dataclass(frozen=True)
class BoltOption:
    """A bolt that fits."""

    grade: str
    bolt: TightenedBolt
    present: bool = False  #: whether it is that of the study

    @property
    def name(self) -> str:
        """Thread and grade."""
        return f"{self.bolt.bolt.thread.name} {self.grade}"


def bolt_options(study: Study, mesh: MeshedRod, present: TightenedBolt) -> tuple[list[BoltOption], list[str]]:
    """Return the bolts that fit, those of the thickest thread first, and why others do not, in words.

    The present bolt stands before the others of its thread. All others are tightened to ν = 90 % of their
    yield strength (VDI 2230-1, R7), as is one of the present thread and grade where that is another preload.
    """
    table, found, refused = study.assembly, list[BoltOption](), dict[str, None]()
    if table is None:
        return [], []
    own = study.part_material.get(BOLT)
    given = own is not None and own.resolved().yield_MPa is not None
    grade = OWN_GRADE if given else (table.grade or DEFAULT_GRADE).value
    threads = threads_for_hole(present.bolt.hole)
    if present.bolt.thread not in threads:
        threads.append(present.bolt.thread)
    for thread in sorted(threads, key=lambda one: (-one.diameter, one.pitch)):
        of_present = thread == present.bolt.thread
        if of_present:
            found.append(BoltOption(grade, present, present=True))
        for name, other in _graded(study, table, grade):
            try:
                setup = AssemblySetup.of(_with_thread(other, thread, same=of_present), mesh)
            except InvalidValue as error:
                refused[f"{thread.name}: {error}"] = None
                continue
            if setup is None:
                continue
            same = isclose(setup.bolt.tightening.preload, present.tightening.preload, rel_tol=_SAME)
            if not (of_present and name == grade and same):
                found.append(BoltOption(name, setup.bolt))
    return found, list(refused)


def _graded(study: Study, table: AssemblyTable, present: str) -> Iterator[tuple[str, Study]]:
    """Yield the study with bolts of every grade, by its name, tightened as VDI 2230 does."""
    free = replace(table, **TIGHTENING)
    if present == OWN_GRADE:
        yield present, replace(study, assembly=free)
    standard = {part: own for part, own in study.part_material.items() if part != BOLT}
    kept = study.part_material if present != OWN_GRADE else standard
    for grade in BoltGrade:
        rolled = table.bolt_thread_rolled if grade.value == present else None
        graded = replace(free, bolt_grade=grade, bolt_thread_rolled=rolled)
        yield grade.value, replace(study, assembly=graded, part_material=kept)


def _with_thread(study: Study, thread: Thread, *, same: bool) -> Study:
    table = study.assembly
    if table is None or same:
        return study
    return replace(study, assembly=replace(table, bolt_thread=thread.name, **SIZES))


class _Bars(NamedTuple):
    """Bars, relative: of the factors, and of the speed at which the joint opens."""

    yielding: float
    fatigue: float
    opening: float
    speed: float

    def __str__(self) -> str:
        names = zip(("yield", "fatigue", "opens"), self, strict=False)
        return ", ".join(f"{name} ± {100 * bar:g} %" for name, bar in names)


# Of a preload that is solved: the tolerance of the search for the speed. Of others: what rows differed by
# from runs with their bolts (docs/do/bolted.md), rounded up.
_SOLVED = _Bars(0.0, 0.0, 0.02, 0.01)
_PRESENT_THREAD = _Bars(0.005, 0.015, 0.05, 0.025)
_OTHER_THREAD = _Bars(0.01, 0.05, 0.1, 0.045)


class BoltRow(Figures):
    """A bolt that fits: how it is tightened, and how it holds at the speed of the study."""

    thread: str
    grade: str
    present: bool
    preload_kN: float  #: at the end of tightening; `embedding_kN` of it is lost by embedding
    embedding_kN: WhereKnown[float] = None
    torque_Nm: float
    stretch_mm: float  #: elongation between the ends of the bolt
    stretch_in: float
    tightening_use: float  #: von Mises stress at the end of tightening over the yield strength
    max_force_kN: WhereKnown[float] = None
    endurance_MPa: WhereKnown[float] = None  #: of the thread
    #: None where no contact carries the preload. Of fatigue also where nothing changes; of opening, a
    #: multiple of the load, and of its speed where the joint opens at none; 0 where it is open at any
    yield_factor: SafetyFactor | None = None
    fatigue_factor: SafetyFactor | None = None
    opening_factor: SafetyFactor | None = None
    opens_at_rpm: float | None = None
    opens_at_rpm_bar: WhereKnown[float] = None
    notes: tuple[Note, ...]  #: doubts and warnings of this bolt


class BoltTableFigures(Figures):
    """What `fea bolts` finds."""

    study: str
    rpm: float
    trusted: bool
    rows: tuple[BoltRow, ...]
    statements: tuple[str, ...]  #: what a reader must know of the table
    notes: tuple[Note, ...]
    total_s: float


def bolts(study: Study | str | Path, listener: Listener | None = None) -> BoltTableFigures:
    """Compare the bolts that fit a rod at the highest speed of its study; `listener` hears of the stages.

    Raises `InvalidValue`: the study has no [assembly] or no [engine], or breaks a rule; `GeometryError`,
    `MeshError`, `UnderconstrainedError`, `SingularMatrixError`, `ContactError`: the rod cannot be drawn,
    meshed or solved.
    """
    study = study if isinstance(study, Study) else load_study(study)
    study.require_engine()
    rule, remedy = "is missing: there are no bolts to compare", "Split the big end with an [assembly]."
    require(study.assembly is not None, "[assembly]", None, rule, remedy)
    rpm = max(speed for speed in study.speeds() if speed is not None)
    require(rpm > 0, "speed.rpm", rpm, "must be positive", "At rest nothing pulls at the joint.")
    clock = Clock(listener)
    study = load_cases_alone(study)
    adapted = refined_rod(study, [rpm], clock)
    rod, result = adapted.rod, adapted.results.get(rpm) or solve_speed(adapted.rod, rpm)
    pins, setup = rod.assembly_contact, rod.assembling
    if pins is None or setup is None:
        rule = "leaves out the contact of the parts, which loads the bolts"
        raise InvalidValue("analysis.pressure", str(study.analysis.pressure), rule, "Leave it out.")
    with clock("bolts"):
        options, refused = bolt_options(study, rod.mesh, setup.bolt)
        joint = PreloadedJoint(rod, pins, rpm, setup.bolt, [one.bolt.preload for one in options])
        rows = tuple(_row(option, joint) for option in options)
    return BoltTableFigures(
        study=study.name,
        rpm=rpm,
        trusted=result.trusted,
        rows=rows,
        statements=(*_statements(options, rows, joint, rpm), *refused),
        notes=result.notes,
        total_s=clock.total,
    )


def _row(option: BoltOption, joint: PreloadedJoint) -> BoltRow:
    bolt, own = option.bolt, option.bolt.bolt
    preload, same = bolt.tightening.preload, own.thread == joint.present.bolt.thread
    bars = _SOLVED if joint.solved(bolt) else _PRESENT_THREAD if same else _OTHER_THREAD
    row = BoltRow(
        thread=own.thread.name,
        grade=option.grade,
        present=option.present,
        preload_kN=preload / KN,
        embedding_kN=bolt.embedding_loss / KN or None,
        torque_Nm=preload * own.lever / N_M,
        stretch_mm=preload * own.stretch_compliance,
        stretch_in=preload * own.stretch_compliance / INCH,
        tightening_use=bolt.tightening_stress / own.strength.yield_strength,
        notes=tuple(note for note in bolt.notes if note.kind in (NoteKind.DOUBT, NoteKind.WARNING)),
    )
    judged, speed = joint.judged(bolt), joint.opens_at(bolt)
    if judged is None or speed is None:
        return row
    tired, opens = min(judged, key=lambda one: one.bending_fatigue_safety), speed < joint.most
    return replace(
        row,
        max_force_kN=max(one.largest_force for one in judged) / KN,
        endurance_MPa=tired.endurance,
        yield_factor=_with_bar(min(one.working_safety for one in judged), bars.yielding),
        fatigue_factor=_with_bar(tired.bending_fatigue_safety, bars.fatigue),
        opening_factor=_with_bar(joint.load_factor(speed), bars.opening) if opens else None,
        opens_at_rpm=speed if opens else None,
        opens_at_rpm_bar=bars.speed * speed if opens else None,
    )


def _with_bar(value: float, bar: float) -> SafetyFactor | None:
    return SafetyFactor(value, (1 - bar) * value, (1 + bar) * value) if isfinite(value) else None


def _statements(
    options: Sequence[BoltOption], rows: Sequence[BoltRow], joint: PreloadedJoint, rpm: float
) -> Iterator[str]:
    """Yield what stands below the table."""
    now = next(row for row in rows if row.present)
    present, own = joint.present, joint.present.bolt
    if now.opening_factor is not None:
        at = f"at {now.opens_at_rpm:.0f} rpm, {now.opening_factor:.2f} times the load at {rpm:.0f} rpm"
        yield f"Present (›): {now.thread} {now.grade}, with which the joint opens at the bore {at}."
    loss = SCATTER["torque"][1] / 100
    loose = replace(present, tightening=present.tightening._replace(preload=(1 - loss) * present.preload))
    if (slower := joint.opens_at(loose)) is not None and slower < joint.most:
        scatter = f"A preload by torque may be {100 * loss:.0f} % below what is meant (VDI 2230)"
        yield f"{scatter}: the present joint then opens at {slower:.0f} rpm."
    before = replace(own, rolled=ThreadRolled.BEFORE).endurance(present.preload)
    yield (
        "A higher grade does not raise the endurance of a thread rolled before heat treatment: σ_ASV = "
        f"0.85 (150/d + 45) depends on its diameter d alone (VDI 2230-1, R9), {before:.1f} MPa with "
        f"{own.thread.name}. It gains against fatigue by its preload, under which less of the load reaches "
        "the bolt. Threads rolled after it, as of the grades of makers, endure up to 1.7 times as much."
    )
    free = f"friction {own.thread_friction:g} in the thread and {own.head_friction:g} under the head"
    use = f"{100 * UTILISATION:.0f} % of their yield strength, torsion included (VDI 2230-1, R7)"
    yield f"The others are tightened to {use}, with {free}; stretch is that of the bolt between its ends."
    if joint.forces.size:
        low, high = joint.forces[[0, -1]] / KN
        yield (
            f"Contact is solved under {joint.forces.size} preloads of {low:.3g} to {high:.3g} kN with the "
            "present bolt, at the load cases from rest. Figures between are interpolated; those of other "
            "threads follow by the joint diagram of VDI 2230-1 and bending between the same seats."
        )
        yield (
            f"Bars: {_PRESENT_THREAD}; of other threads {_OTHER_THREAD}: what the table differed by from "
            "runs with those bolts. That of the mesh is not in them. fea run judges slip and seats, too."
        )
    guessed = [grade for grade in dict.fromkeys(one.grade for one in options) if grade in YIELD_ESTIMATED]
    if guessed:
        yield f"The yield strength of {' and '.join(guessed)} is an estimate."
