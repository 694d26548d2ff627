"""The job behind `fea compare`: each study is run, and what is found stands side by side.

Studies differ in what is compared, and in what they are judged by.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from shlex import quote
from typing import Any, NamedTuple

from fea.analysis.figures import Figures, WhereKnown
from fea.analysis.pipeline import refined_rod
from fea.analysis.result import run_result
from fea.analysis.summary_figures import Summary
from fea.apps.limits.explore import explore, limited_speeds
from fea.apps.limits.figures import LargestValue, largest_values, words
from fea.machine.clock import Clock
from fea.output.json_file import STUDY
from fea.output.report.found_limits import limits_beside
from fea.output.stored_run import StoredRun, read_figures
from fea.study.material_table import MaterialTable
from fea.study.study import Study, load_study, shipped_studies
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


MOST = 6  # studies, whose columns a page has room for
_ENDS = ("largest_rpm", "largest_peak_pressure_bar")


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
    lacks: WhereKnown[str] = None  #: what a run that was solved before does not have, and how to fill it


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


def named_designs(names: Sequence[str], materials: Sequence[str] = ()) -> list[ComparedStudy]:
    """Load what to compare: two to six studies or folders of runs, or a study in two to six materials.

    Raises `InvalidValue`: too few or too many, materials for several studies, an unknown name or material.
    """
    rule = "can be compared of one study"
    require(not materials or len(names) == 1, "--material", " ".join(materials), rule, "Name one study.")
    count, of = (len(materials), "--material") if materials else (len(names), "STUDY")
    remedy = "Name two to six studies, or one study and --material with two to six materials."
    require(2 <= count <= MOST, of, count, f"must be 2 to {MOST}", remedy)
    if not materials:
        designs = [_design(name) for name in names]
        twice = len({design.study.name for design in designs}) < len(designs)
        titles = names if twice else [design.study.name for design in designs]
        named = [replace(design.study, name=title) for design, title in zip(designs, titles, strict=True)]
        return [ComparedStudy(study, design.run) for study, design in zip(named, designs, strict=True)]
    study = load_study(names[0])
    tables = [MaterialTable(preset=material) for material in materials]
    return [
        ComparedStudy(replace(study, name=f"{study.name}, {material}", material=table))
        for material, table in zip(materials, tables, strict=True)
    ]


def _design(name: str) -> ComparedStudy:
    if name in shipped_studies() or not Path(name).is_dir():
        return ComparedStudy(load_study(name))
    run = read_figures(Path(name))
    return ComparedStudy(replace(run.study, name=run.folder.resolve().name), run)


def compare(
    designs: Sequence[ComparedStudy],
    listener: Callable[[str], None] | None = None,
    *,
    alike: bool = False,
    limits: bool = False,
) -> ComparisonFigures:
    """Run studies, each at its highest speed, and return what differs between them and what was found.

    Runs are taken as they were solved, with the limits that `fea limits` wrote beside them. `alike`: whether
    all are judged as the first is; `limits`: whether the largest speed and peak pressure of studies are
    found. Raises what `fea.apps.result.analyse` and, with limits, `fea.apps.limits` raise.
    """
    designs = judged_alike(designs) if alike else list(designs)
    if limits:
        designs = [each.changed(lambda study: study.with_(analysis={"cycle": True})) for each in designs]
    for study in (each.study for each in designs if each.run is None):
        study.require_plausible()
        study.require_loading()
        if limits:
            limited_speeds(study)
    differ = differences([each.study for each in designs])
    return ComparisonFigures(
        designs=tuple(_found(each, listener, limits=limits) for each in designs),
        dimensions=_by_key([one for one in differ if one.of_design]),
        assumptions=_by_key([one for one in differ if not one.of_design]),
    )


def _by_key(found: Sequence[KeyDifference]) -> dict[str, tuple[Any, ...]]:
    return {one.key: one.values for one in found}


def _stored(run: StoredRun, name: str) -> ComparedDesign:
    raw, study, without = limits_beside(run.folder, run.study), quote(str(run.folder / STUDY)), []
    if run.summary.rpm is not None and run.summary.envelope is None:
        without.append(f"the crank cycle (fea run {study} --cycle --out {quote(str(run.folder))})")
    of = None
    if raw is not None and raw["required_safety_factor"] == (run.study.analysis.min_safety or 1.0):
        ends = {key: raw[key] and LargestValue(**raw[key]) for key in _ENDS}
        of = LimitsOfDesign(text=raw["text"], **ends)
    elif run.study.engine is not None:
        without.append(f"limits (fea limits {study} --out {quote(str(run.folder))}-limits)")
    lacks = " and ".join(without) or None
    return ComparedDesign(name=name, summary=run.summary, limits=of, lacks=lacks)


def _found(design: ComparedStudy, listener: Callable[[str], None] | None, *, limits: bool) -> ComparedDesign:
    study = design.study
    if design.run is not None:
        return _stored(design.run, study.name)

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
