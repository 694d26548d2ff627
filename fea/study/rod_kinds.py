"""Rods by kind: from length and bores to a rod with cap screws, in the proportions of `rod_kinds.toml`."""

from dataclasses import dataclass

from fea.base.shipped import shipped_toml
from fea.study.bolts import Thread, parse_thread
from fea.study.tables import one_of
from geometry.dimensions import ShankSection
from geometry.outline import bosses
from geometry.rod import Rod, proportioned

_KINDS = shipped_toml("study/rod_kinds.toml")
# Of rod bolts; a fine thread each.
_THREADS = ("1/4-28 UNF", "5/16-24 UNF", "3/8-24 UNF", "7/16-20 UNF", "1/2-20 UNF")
# Radius of the seat of a head over the bolt's diameter: flanges of 12-point bolts are about 1.55 d wide.
_HEAD = 0.8
_BORES = ("big_end_bore", "small_end_bore")


@dataclass(frozen=True)
class RodOfKind:
    """A rod in the proportions of its kind."""

    rod: Rod
    thread: Thread  #: of its cap screws
    #: title, material, grade: of the kind, and in a study those of the rod and of its bolts
    title: str
    material: str
    grade: str


def rod_of_kind(
    kind: str, length: float, big_end_bore: float, small_end_bore: float, thread: str | None = None
) -> RodOfKind:
    """Return a rod of a kind, by the distance and the diameters of its bores, mm.

    Its cap screws are of the given `thread`, or of one that suits the big end. Raises `InvalidValue`: there
    is no such kind, or a dimension breaks a rule.
    """
    one_of(_KINDS)("--kind", kind)
    told = _KINDS[kind]
    threads = [parse_thread("--thread", name) for name in ((thread,) if thread else _THREADS)]
    screw = min(threads, key=lambda one: abs(one.diameter - told["bolt"] * big_end_bore))
    bores = dict(zip(_BORES, (big_end_bore, small_end_bore), strict=True))
    given = {name: round(share * bores[bore], 2) for bore in _BORES for name, share in told[bore].items()}
    section = ShankSection(told["shank_section"])
    given |= {"cap_bolt": screw.diameter}
    rod = proportioned(length, *bores.values(), shank_section=section, **given)
    boss = bosses(rod)
    if boss is not None:  # the head's seat begins where the fillet ends
        given["cap_bolt_spacing"] = round(2 * (boss.seat + _HEAD * screw.diameter), 2)
        rod = proportioned(length, *bores.values(), shank_section=section, **given)
    return RodOfKind(rod, screw, told["title"], told["material"], told["grade"])
