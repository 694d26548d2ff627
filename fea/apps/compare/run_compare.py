"""The job behind `fea compare`: each study is run, and what is found stands side by side."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from fea.analysis.figures import Figures, Summary, WhereKnown
from fea.analysis.pipeline import refined_rod
from fea.analysis.result import run_result
from fea.apps.compare.differences import KeyDifference, differences, judged_alike
from fea.apps.limits.explore import explore, limited_speeds
from fea.apps.limits.figures import LargestValue, largest_values, words
from fea.machine.clock import Clock
from fea.study.material_table import MaterialTable
from fea.study.study import Study, load_study
from geometry.errors import require

MOST = 6  # studies, whose columns a page has room for


class LimitsOfDesign(Figures):
    """The largest speed and peak pressure of a design: see `fea limits`; None where nothing ends them."""

    text: str
    largest_rpm: LargestValue | None
    largest_peak_pressure_bar: LargestValue | None


class ComparedDesign(Figures):
    """A design: its name and what was found of it at the highest speed of its study."""

    name: str
    summary: Summary
    limits: WhereKnown[LimitsOfDesign] = None


class ComparisonFigures(Figures):
    """What `fea compare` finds."""

    schema: str = "fea/compare/1"
    designs: tuple[ComparedDesign, ...]
    #: By key, the values of each design: in what is compared, and in what it is judged by
    dimensions: dict[str, tuple[Any, ...]]
    assumptions: dict[str, tuple[Any, ...]]

    @property
    def trusted(self) -> bool:
        """Whether every check of every design passed."""
        return all(design.summary.trusted for design in self.designs)


def named_studies(names: Sequence[str], materials: Sequence[str] = ()) -> list[Study]:
    """Load the studies to compare: two to six by name, or one in two to six materials.

    Raises `InvalidValue`: too few or too many, materials for several studies, an unknown name or material.
    """
    rule = "can be compared of one study"
    require(not materials or len(names) == 1, "--material", " ".join(materials), rule, "Name one study.")
    count, of = (len(materials), "--material") if materials else (len(names), "STUDY")
    remedy = "Name two to six studies, or one study and --material with two to six materials."
    require(2 <= count <= MOST, of, count, f"must be 2 to {MOST}", remedy)
    if not materials:
        studies = [load_study(name) for name in names]
        twice = len({study.name for study in studies}) < len(studies)
        titles = names if twice else [study.name for study in studies]
        return [replace(study, name=title) for study, title in zip(studies, titles, strict=True)]
    study = load_study(names[0])
    tables = [MaterialTable(preset=material) for material in materials]
    return [
        replace(study, name=f"{study.name}, {material}", material=table)
        for material, table in zip(materials, tables, strict=True)
    ]


def compare(
    studies: Sequence[Study],
    listener: Callable[[str], None] | None = None,
    *,
    alike: bool = False,
    limits: bool = False,
) -> ComparisonFigures:
    """Run studies, each at its highest speed, and return what differs between them and what was found.

    `alike`: whether all are judged as the first is; `limits`: whether the largest speed and peak pressure are
    found. Raises what `fea.apps.result.analyse` and, with limits, `fea.apps.limits` raise.
    """
    studies = judged_alike(studies) if alike else list(studies)
    if limits:
        studies = [replace(each, analysis=replace(each.analysis, cycle=True)) for each in studies]
    for study in studies:
        study.require_plausible()
        study.require_loading()
        if limits:
            limited_speeds(study)
    differ = differences(studies)
    designs = [_design(study, listener, limits=limits) for study in studies]
    return ComparisonFigures(
        designs=tuple(designs),
        dimensions=_by_key([one for one in differ if one.of_design]),
        assumptions=_by_key([one for one in differ if not one.of_design]),
    )


def _by_key(found: Sequence[KeyDifference]) -> dict[str, tuple[Any, ...]]:
    return {one.key: one.values for one in found}


def _design(study: Study, listener: Callable[[str], None] | None, *, limits: bool) -> ComparedDesign:
    def show(stage: str) -> None:
        if listener is not None:
            listener(f"{study.name}: {stage}")

    speed = max(study.speeds(), key=lambda rpm: rpm or 0.0)
    adapted = refined_rod(study, [speed], Clock(show))
    summary = run_result(study, adapted, adapted.at(speed)).summary
    if not limits or speed is None:
        return ComparedDesign(name=study.name, summary=summary)
    found = explore(adapted, speed, None, show, mapped=False)
    largest, pressure, _ = largest_values(found)
    of = LimitsOfDesign(text=words(found), largest_rpm=largest, largest_peak_pressure_bar=pressure)
    return ComparedDesign(name=study.name, summary=summary, limits=of)
