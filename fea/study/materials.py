"""The materials that come with the program, by name: `materials.toml`, and bolts by their grades."""

import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from fea.base.choices import BoltGrade
from fea.base.shipped import shipped_toml
from fea.study.bolts import bolt_strength, grade_source
from fea.study.toml_files import TomlTable
from geometry.errors import InvalidValue

Figures = Mapping[str, float]


@dataclass(frozen=True)
class LibraryMaterial:
    """A material of the library."""

    name: str
    title: str  #: what it is
    also: tuple[str, ...]  #: other names
    figures: Figures  #: by the keys of [material]
    sources: Mapping[str, str]  #: where figures come from, by those keys; also of what could not be found

    @property
    def source(self) -> str:
        """The sources as one text: each, with its figures where there are several."""
        by_text: dict[str, list[str]] = {}
        for key, text in self.sources.items():
            by_text.setdefault(text, []).append(key)
        if len(by_text) == 1:
            return next(iter(by_text))
        return " ".join(f"{', '.join(keys)}: {text}" for text, keys in by_text.items())


def _materials() -> Iterator[LibraryMaterial]:
    for name, table in shipped_toml("study/materials.toml").items():
        yield from _variants(name, table)
    for grade in BoltGrade:
        least, name = bolt_strength(grade, 0.0), f"bolt-{grade}"
        figures = {"E_GPa": 205.0, "nu": 0.30, "density_kg_m3": 7850.0}
        strengths = {"yield_MPa": least.yield_strength, "ultimate_MPa": least.ultimate}
        sources = dict.fromkeys(figures | strengths, grade_source(grade))
        yield LibraryMaterial(name, f"Bolt, {grade}", (), figures | strengths, sources)


def _variants(name: str, table: TomlTable) -> Iterator[LibraryMaterial]:
    title, also, source, usual = (table.pop(key, "") for key in ("title", "also", "source", "usual"))
    variants = table.pop("variants", {"": {}})
    if table.pop("interpolate", False):
        # At every whole hardness, linear between those that are given, MPa without decimals.
        known = {int(hardness): figures for hardness, figures in variants.items()}
        found = {str(hardness): dict(figures) for hardness, figures in known.items()}
        for low, high in pairwise(sorted(known)):
            for hardness in range(low + 1, high):
                share = (hardness - low) / (high - low)
                found[str(hardness)] = {
                    key: float(round((1 - share) * value + share * known[high][key]))
                    for key, value in known[low].items()
                }
        variants = {hardness: found[hardness] for hardness in sorted(found)}
    by_figure = source if isinstance(source, dict) else {", ".join(table): source}
    sources = {key: text for keys, text in by_figure.items() for key in keys.split(", ")}
    for variant, figures in variants.items():
        names = tuple(also) if variant == usual else ()
        own = f"{name}-{variant}" if variant else name
        yield LibraryMaterial(own, title, names, table | figures, sources)


LIBRARY = {material.name: material for material in _materials()}
# As names are compared: without regard to case, blanks and hyphens.
_IGNORED = str.maketrans("", "", " -_")


def _plain(name: str) -> str:
    return name.casefold().translate(_IGNORED)


_BY_NAME = {_plain(name): each for each in LIBRARY.values() for name in (*each.also, each.name)}


def library_material(where: str, name: str) -> LibraryMaterial:
    """Return a material by one of its names; `where` names the key. Raises `InvalidValue`: unknown name."""
    if found := _BY_NAME.get(_plain(name)):
        return found
    near = difflib.get_close_matches(_plain(name), _BY_NAME, n=3, cutoff=0.5)
    names = ", ".join(dict.fromkeys(_BY_NAME[plain].name for plain in near))
    remedy = f"Did you mean {names}? " if near else ""
    raise InvalidValue(where, name, "is not in the library", f"{remedy}`fea materials` lists all names.")
