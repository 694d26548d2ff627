"""What differs between studies: in what is compared, and in what it is judged by."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from fea.output.stored_run import StoredRun
from fea.study.study import Study
from geometry.errors import require

# What is compared: a study that is still to be solved, or a run that was.
Design = Study | StoredRun

# Tables of a study that say what is compared; the others say by what it is judged.
_DESIGN = ("rod", "material", "assembly")
# Keys that say by what it is judged all the same.
_JUDGED = ("assembly.joint_friction", "assembly.temperature_C")
_UNSEEN = ("output", "optimise")
_PRESSURE = "analysis.pressure"  # has a default


class KeyDifference(NamedTuple):
    """A key whose values differ: those of the studies, in their order; None where there is none."""

    key: str
    values: tuple[Any, ...]

    @property
    def of_design(self) -> bool:
        """Whether it is of what is compared: rod, material or bolts."""
        return self.key.split(".")[0] in _DESIGN and self.key not in _JUDGED


def differences(studies: Sequence[Study]) -> list[KeyDifference]:
    """Return the keys whose values differ between studies, defaults of each resolved."""
    flat = [dict(_flat(study.as_dict())) | {_PRESSURE: study.analysis.pin_load} for study in studies]
    found = [
        KeyDifference(key, tuple(each.get(key) for each in flat))
        for key in dict.fromkeys(key for each in flat for key in each)
    ]
    return [one for one in found if any(value != one.values[0] for value in one.values)]


def _flat(tables: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in tables.items():
        if isinstance(value, Mapping) and name not in _UNSEEN:
            yield from _flat(value, f"{above}{name}.")
        elif name not in _UNSEEN:
            yield f"{above}{name}", value


def study_of(design: Design) -> Study:
    """Return the study of a design."""
    return design.study if isinstance(design, StoredRun) else design


def judged_alike(designs: Sequence[Design]) -> list[Design]:
    """Return the designs with everything by which the first one is judged: engine, speed, pins, mesh.

    Raises `InvalidValue`: a run was solved by something else.
    """
    first = study_of(designs[0])
    same = {name: getattr(first, name) for name in ("engine", "speed", "duty", "forces", "mesh", "analysis")}
    same |= {"contact": first.contact, "film": first.film}
    for run in (each for each in designs if isinstance(each, StoredRun)):
        others = [one.key for one in differences([first, run.study]) if not one.of_design]
        rule = f"is solved, with other {', '.join(others)} than the first"
        require(not others, "--same", str(run.folder), rule, "Name its study in place of its folder.")
    return [each if isinstance(each, StoredRun) else replace(each, **same) for each in designs]
