"""What differs between studies: in what is compared, and in what it is judged by."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from fea.output.stored_run import StoredRun
from fea.study.study import Study
from geometry.errors import require

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


class ComparedStudy(NamedTuple):
    """What is compared: a study and, if it is solved already, its run."""

    study: Study
    run: StoredRun | None = None

    def changed(self, change: Callable[[Study], Study]) -> "ComparedStudy":
        """Return a design with its study changed; a run stays as it was solved."""
        return ComparedStudy(change(self.study)) if self.run is None else self


def judged_alike(designs: Sequence[ComparedStudy]) -> list[ComparedStudy]:
    """Return designs judged as the first is: engine, speed, pins, mesh. `InvalidValue`: a run is not."""
    first = designs[0].study
    names = ("engine", "speed", "duty", "forces", "mesh", "analysis", "contact", "film")
    same = {name: getattr(first, name) for name in names}
    alike = [each.changed(lambda study: replace(study, **same)) for each in designs]
    for each in alike:
        others = [one.key for one in differences([first, each.study]) if not one.of_design]
        rule = f"is solved, with other {', '.join(others)} than the first"
        require(not others, "--same", each.study.name, rule, "Name its study in place of its folder.")
    return alike
