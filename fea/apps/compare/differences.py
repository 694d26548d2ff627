"""What differs between studies: in what is compared, and in what it is judged by."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from fea.study.study import Study

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


def judged_alike(studies: Sequence[Study]) -> list[Study]:
    """Return the studies with everything by which the first one is judged: engine, speed, pins, mesh."""
    first = studies[0]
    same = {name: getattr(first, name) for name in ("engine", "speed", "duty", "forces", "mesh", "analysis")}
    return [first, *(replace(each, **same, contact=first.contact, film=first.film) for each in studies[1:])]
