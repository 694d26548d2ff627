"""The builder's sheet: what decides, on a page; what is not known has the command that fills it."""

from collections.abc import Iterator
from pathlib import Path
from shlex import quote
from typing import NamedTuple

from fea.analysis.summary_figures import Summary
from fea.base.note import NoteKind
from fea.base.units import KN
from fea.output.assembly_statements import linings, opening_text
from fea.output.folder import final, near
from fea.output.json_file import STUDY
from fea.output.life_statements import life
from fea.output.report.advice import Advice
from fea.output.report.found_limits import answers_for, found_limits
from fea.output.statements import basis, governs, head_gap
from fea.output.stored_run import Run
from fea.output.units import bar, factor, quantity
from fea.study.plausibility import assumed_at
from fea.study.study import shipped_studies

_UNFILLED = "not computed"


class SheetRow(NamedTuple):
    """A row: its title, the answer, what else is to be said, a command that fills it, and its section."""

    title: str
    value: str
    more: tuple[str, ...] = ()
    command: str = ""
    section: str = ""  #: id of the section of the report that says more


def sheet_rows(run: Run, folder: Path | None) -> list[SheetRow]:
    """Return the rows of a run's sheet; limits are looked for beside its folder."""
    study = _study(run, folder)
    named = quote(study)
    around = *_strength(run, named), *_around(run.summary, named), *_gap(run.summary)
    return [*_limits(run, folder, study), *around, *_uncertain(run)]


def by_proportions(run: Run) -> str:
    """Return which dimensions at the place that fails first are assumed, in words; empty for none."""
    names = assumed_at(run.study.rod.dimensions, place_that_fails(run.summary))
    return ", ".join(name.replace("_", " ") for name in names)


def place_that_fails(summary: Summary) -> str:
    """Return where the governing factor is, in words; empty where that has no place."""
    survival, envelope = summary.survival, summary.envelope
    if survival.mode == "fatigue":
        spot = None if envelope is None else envelope.fatigue
        return (survival.fatigue_where if spot is None else spot.where) or ""
    if survival.mode == "yielding":
        weakest = None if summary.governing is None else summary.governing.weakest
        return (weakest.where if weakest else envelope.where if envelope else None) or ""
    return {"buckling": "shank"}.get(survival.mode, "joint" if survival.mode.endswith("joint") else "")


def _study(run: Run, folder: Path | None) -> str:
    """Return how a command names the study of a run: by its own file, or that of the run if flags differ."""
    name = run.summary.study
    name = name if name in shipped_studies() else f"{name}.toml"
    if folder is None or answers_for(name, run.study, run.summary.rpm):
        return name
    return (near(final(folder.absolute())) / STUDY).as_posix()


def _beside(run: Run, folder: Path | None, study: str) -> str:
    """Return the option with which `fea limits` of a study writes beside a run, where it does not anyway."""
    above = None if folder is None else near(final(folder.absolute()).parent)
    usual = above is None or above.is_absolute() or above == Path("results")
    if above is None or (usual and Path(study).name != STUDY):
        return ""
    return f" --out {quote((above / f'{run.summary.study}-limits').as_posix())}"


def _limits(run: Run, folder: Path | None, study: str) -> Iterator[SheetRow]:
    if run.study.engine is None:
        return
    found = {} if folder is None else found_limits(folder, run.study)
    command = f"fea limits {quote(study)}{_beside(run, folder, study)}, then fea report"
    for name, title in (("speed", "Highest speed"), ("boost", "Highest boost")):
        if name in found:
            yield SheetRow(title, found[name].value, (found[name].ending,))
        elif found:
            yield SheetRow(title, "not limited", ("by what fea limits judges",))
        else:
            yield SheetRow(title, _UNFILLED, command=command)
            command = "the same command"


def _strength(run: Run, study: str) -> Iterator[SheetRow]:
    summary = run.summary
    first = next(governs(summary)).removeprefix("Governs: ").rstrip(".")
    more = (*life(summary), *basis(summary))
    yield SheetRow("What fails first", f"{first[0].upper()}{first[1:]}", more, "", "results")
    if summary.assembly is None:
        alone = ("Cap and rod are one piece here; [assembly] in the study adds joint and bolts.",)
        yield SheetRow("Bolts", "not part of this run", alone)
        return
    bolts, joint = summary.assembly.bolts, summary.assembly.joint
    factors = f"yielding {factor(bolts.yield_safety_factor)}"
    if (fatigue := bolts.bending_fatigue_safety_factor) is not None:
        factors += f", fatigue {factor(fatigue)}"
    gap = max(case.opening_um for case in joint.by_case.values())
    opens = f"the joint {opening_text(gap)}" if gap > 0 else "the joint stays closed"
    if joint.opens is not None and (load := joint.opens.load_factor):
        opens += (
            f" ({'at the bore ' if load > 1 else ''}from {load:.2g} times the load of {joint.opens.case})"
        )
    preload, most = (quantity(force / KN, ".1f", "kN") for force in (bolts.preload_N, bolts.max_force_N))
    grade = "" if run.study.assembly is None else f" {run.study.assembly.bolt_grade}"
    others = [] if bolts.tightened is None else [f"Tightened to {bolts.tightened}."]
    others.append(f"fea bolts {study} compares grades and threads.")
    said = f"{bolts.thread}{grade}, preload {preload}, at most {most}; {opens}."
    yield SheetRow("Bolts", f"Safety factors: {factors}", (said, *others), "", "assembly")


def _around(summary: Summary, study: str) -> Iterator[SheetRow]:
    loads = tuple(linings(summary))
    if summary.film is None:
        if summary.engine is not None:
            yield SheetRow("Bearings", f"oil film {_UNFILLED}", loads, f"fea run {study} --film --report")
        return
    said = []
    for end, film in summary.film.items():
        gap = f"{quantity(film.h_min_um, '.2f', 'µm')} ± {bar(film.h_min_error_percent)} %"
        said.append(f"{end.replace('_', ' ').capitalize()}: {film.verdict}, least film {gap}.")
    worst = min(summary.film.values(), key=lambda film: film.h_min_um)
    yield SheetRow("Bearings", worst.verdict.capitalize(), (*said, *loads), "", "film")


def _gap(summary: Summary) -> Iterator[SheetRow]:
    if (gap := summary.head_clearance) is not None:
        least = f"leave more than {quantity(gap.most_mm, '.2f', 'mm')}"
        yield SheetRow("Piston to head", least, tuple(head_gap(summary)), "", "head-clearance")


def _uncertain(run: Run) -> Iterator[SheetRow]:
    advice, count = Advice(run), sum(note.kind is NoteKind.ASSUMPTION for note in run.summary.notes)
    effects, left_out = advice.effects(), run.what_if.left_out
    if effects or left_out:
        what = f"{len(effects)} of {count} that this answer stands on" if effects else "not worked out"
        worked_out = effects and "→" in effects[0]
        title = "Assumptions that change it most" if worked_out else "Assumptions to check first"
        yield SheetRow(title, what, (*effects, *filter(None, [left_out])), "", "assumptions")
    remedies = advice.remedies()
    if remedies:
        yield SheetRow("What would make it pass", remedies[0], tuple(remedies[1:]))
