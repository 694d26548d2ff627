"""Which bolts fit the holes of a rod: the present one, and every grade in every standard thread."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import isclose
from typing import Any

from fea.analysis.assembling import AssemblySetup
from fea.base.choices import BoltGrade
from fea.judge.bolt import TightenedBolt
from fea.rod.meshed_rod import MeshedRod
from fea.study.assembly_table import BOLT, TIGHTENED, AssemblyTable, Thread, threads_for_hole
from fea.study.material_table import DEFAULT_GRADE
from fea.study.study import Study
from geometry.errors import InvalidValue

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
