"""The dimensions of a rod as sliders, and how far each can go."""

from collections.abc import Mapping
from dataclasses import dataclass, fields

from fea.rod.loading import EngineLoading
from fea.study.study import Study
from fea.study.tables import unit_of
from geometry.dimensions import key
from geometry.errors import InvalidValue
from geometry.rod import Rod

# Ends of a slider over the value, where no rule of the rod ends it before.
_FROM, _TO = 0.5, 1.5
# Of the value: how closely the end of the feasible range is found.
_WITHIN = 1e-3
_OF_POCKETS = ("web_thickness", "flange_thickness", "pocket_corner_radius", "pocket_floor_radius")
_GROUPS = {
    "big end": ("big_end", "cap_"),
    "small end": ("small_end", "bushing", "oil_hole"),
    "shank": ("shank", "flange", "web", "pocket", "ring_step", "oil_gallery"),
}


@dataclass(frozen=True)
class LiveDimension:
    """A slider for a dimension of the rod."""

    name: str  #: its key in [rod]
    label: str
    help: str
    group: str
    unit: str
    value: float  #: that of the study


@dataclass(frozen=True)
class Range:
    """How far a dimension can go while the others stay."""

    low: float
    high: float
    #: low_reason, high_reason: the rule that ends it there; empty where only the slider ends
    low_reason: str = ""
    high_reason: str = ""
    #: What the moved mesh is known to reach, and what is interpolated; None where nothing is known yet
    reach_low: float | None = None
    reach_high: float | None = None
    covered_low: float | None = None
    covered_high: float | None = None


def dimensions(study: Study) -> tuple[LiveDimension, ...]:
    """Return the dimensions that a rod has, without those of features left out; none of a file's."""
    rod = study.rod.dimensions
    if rod is None:
        return ()
    found = []
    for each in fields(Rod):
        value, told = getattr(rod, each.name), each.metadata
        idle = each.name in _OF_POCKETS and not rod.has_pockets
        idle |= each.name == "pocket_setback" and not (rod.has_pockets or rod.shank_bore)
        if told.get("unit") != "mm" or not value or idle:
            continue
        label, unit = unit_of(key(each.name))
        group = next((name for name, own in _GROUPS.items() if each.name.startswith(own)), "rod")
        group = "rod" if each.name in ("big_end_bore", "small_end_bore") else group
        found.append(LiveDimension(key(each.name), label, told["help"], group, unit, value))
    order = ["rod", *_GROUPS]
    return tuple(sorted(found, key=lambda one: order.index(one.group)))


def fault(study: Study, design: Mapping[str, float]) -> str:
    """Return the rule that a design breaks; empty where it can be drawn and driven."""
    try:
        length = study.rod.with_dimensions(design).length
        if study.engine is not None and length is not None and length != study.rod.length:
            EngineLoading.of(study.engine, length)
    except InvalidValue as error:
        return str(error)
    return ""


def feasible(study: Study, design: Mapping[str, float], name: str, value: float) -> Range:
    """Return how far a dimension goes from a design that can be drawn: as far as no rule is broken.

    Where rods can be drawn again beyond a rule, the range ends at the first.
    """
    ends, reasons = [], []
    for share in (_FROM, _TO):
        far = share * value
        why = fault(study, {**design, name: far})
        near = value
        while why and abs(far - near) > _WITHIN * value:
            middle = (near + far) / 2
            there = fault(study, {**design, name: middle})
            if there:
                far, why = middle, there
            else:
                near = middle
        ends.append(near if why else far)
        reasons.append(why)
    (low, high), (low_reason, high_reason) = ends, reasons
    return Range(low, high, low_reason, high_reason)
