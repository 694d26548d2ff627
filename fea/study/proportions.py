"""Which dimensions of a rod are this program's own: those of its published rods and in usual proportions.

A study that a run has written has every dimension, so that its values say where they come from: a dimension
counts as assumed where it has the value that this program would give it beside the others.
"""

from collections.abc import Iterator
from contextlib import suppress
from math import isclose

from fea.study.rod_table import KINDS, LEAST, rod_of_kind
from geometry.dimensions import dimensions
from geometry.errors import InvalidValue
from geometry.presets import PRESETS
from geometry.rod import Rod, proportioned

_BORES = tuple(name.removesuffix("_mm") for name in LEAST)  # and their distance
# Relative; a study has its dimensions with six digits.
_SAME = 1e-4
# Dimensions that carry the stress, by a word in the name of a place (`fea.rod.places.place_name`).
_OF_PLACES: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = (
    (
        ("shank",),
        ("shank_width", "shank_depth_big_end", "shank_depth_small_end", "flange_thickness", "web_thickness"),
    ),
    (("small end", "small-end", "bushing"), ("small_end_ring", "small_end_width", "small_end_fillet")),
    (("joint", "bolt", "cap", "nut"), ("big_end_ring", "cap_boss_length", "cap_bolt_spacing")),
    (("big end", "big-end", "shell"), ("big_end_ring", "big_end_width", "big_end_fillet")),
)


def assumed_dimensions(rod: Rod) -> frozenset[str]:
    """Return the names of the dimensions, in `geometry.dimensions`, that are this program's own."""
    given = {name: value for name in dimensions() if (value := getattr(rod, name))}
    free = [name for name in given if name not in _BORES]
    found = set()
    for own in _alike(rod):
        found |= {name for name in free if isclose(getattr(own, name), given[name], rel_tol=_SAME)}
    for name in free:
        rest = {other: value for other, value in given.items() if other != name}
        with suppress(InvalidValue):
            usual = proportioned(**rest, shank_section=rod.shank_section)
            if isclose(getattr(usual, name), given[name], rel_tol=_SAME):
                found.add(name)
    return frozenset(found)


def _alike(rod: Rod) -> Iterator[Rod]:
    """Yield the published rods, and those of a kind, with the bores of a rod and their distance."""
    bores = tuple(getattr(rod, name) for name in _BORES)
    yield from (own for own in PRESETS.values() if bores == tuple(getattr(own, n) for n in _BORES))
    for kind in KINDS:
        with suppress(InvalidValue):
            yield rod_of_kind(kind, *bores).rod


def dimensions_at(rod: Rod | None, place: str) -> tuple[str, ...]:
    """Return the names of the dimensions that carry the stress at a place, in words."""
    named = next((names for words, names in _OF_PLACES if any(word in place for word in words)), ())
    return () if rod is None else tuple(name for name in named if getattr(rod, name))


def assumed_at(rod: Rod | None, place: str) -> tuple[str, ...]:
    """Return the dimensions that carry the stress at a place, in words, if most of them are assumed."""
    named = dimensions_at(rod, place)
    if rod is None:
        return ()
    assumed = assumed_dimensions(rod) if named else frozenset()
    own = tuple(name for name in named if name in assumed)
    return own if 2 * len(own) > len(named) else ()
