from dataclasses import replace
from io import StringIO
from pathlib import Path

import pytest
from printed import flowing, require_brief
from rich.console import Console
from written_figures import load, result, summary

from fea.analysis.rod_report import SolidFigures
from fea.analysis.summary_figures import PassFigures
from fea.base.checks import Check
from fea.base.note import UNITS, assumption, by_consequence, doubt, omission, remark, warning
from fea.output.tables import AnswerTable
from fea.output.terminal.prose import gathered
from fea.output.terminal.rod import solid_lines
from fea.output.terminal.run import part_table, print_runs
from fea.output.units import kilo

LOADS = {
    "tension": load(crank_deg=4.0, pin_axial_N=31512.0, crank_axial_N=48100.0, wall_N=-212.0),
    "given": load(crank_deg=None, pin_axial_N=-30200.0, crank_axial_N=-4e4, wall_N=None),
}
TENSION = result(
    max_von_mises_MPa=312.04,
    error_percent=3.14,
    verdict="not converged",
    at_mm=(22.17, -0.0, 7.5),
    min_safety_factor=1.9884,
    max_displacement_mm=0.10912,
)
GIVEN = result(max_von_mises_MPa=210.0, max_displacement_mm=0.05)
FILES = ("given.vtu", "summary.json", "tension.vtu")
SUMMARY = summary(loads=LOADS, results={"tension": TENSION, "given": GIVEN}, files=FILES)


def said(*runs, width: int = 80, verbose: bool = False) -> str:
    console = Console(file=StringIO(), width=width)
    print_runs(runs, console, verbose=verbose)
    return console.file.getvalue()


@pytest.fixture
def folder(tmp_path):
    return tmp_path


def test_the_table_tells_each_case_with_forces_in_kilonewton(folder):
    rows = [line.split() for line in said((folder, SUMMARY)).splitlines()]
    assert [
        "tension",
        "4",
        "+31.5",
        "+48.1",
        "-0.2",
        "312.0",
        "3.1",
        "22.2,",
        "0.0,",
        "7.5",
        "1.99",
        "0.109",
    ] in rows
    assert ["given", "–", "-30.2", "-40.0", "–", "210.0", "–", "1.0,", "2.0,", "3.0", "9.00", "0.050"] in rows


def test_the_table_of_a_part_breaks_its_headings_and_cuts_no_figure():
    """Cut, a range of forces from 8770 to 8890 was one from 8770 to 88."""
    head, row = ("joint", "bolts, lbf", "micro-slip, %", "slip safety, "), ("side", "8770…8890", "20", "3.57")
    table = AnswerTable("Joint", head, (row, row))
    for width in (80, 36):
        console = Console(file=StringIO(), width=width)
        console.print(part_table(table, console))
        *_, last = filter(str.strip, console.file.getvalue().splitlines())
        assert tuple(last.split()) == row, width


@pytest.mark.parametrize(
    ("newtons", "said"), [(-3.0, "+0.0"), (-51.0, "-0.1"), (-1.7963e6, "-1796"), (4e8, "+4.0e+05")]
)
def test_forces_of_any_size(newtons, said):
    assert kilo(newtons) == said


@pytest.mark.parametrize(
    ("largest", "said"), [(3e4, "+0.2"), (3e3, "+0.22"), (216.0, "+0.216"), (0.0, "+0.21600")]
)
def test_small_forces_have_three_digits_beside_others_as_small(largest, said):
    assert kilo(216.0, largest) == said


def test_peaks_that_are_not_settled_are_named(folder):
    assert "Not converged: tension (" in said((folder, SUMMARY))
    diverging = replace(GIVEN, verdict="not converged", singular_max_von_mises_MPa=99.0)
    diverging = replace(diverging, singular_where="small-end bore's edge")
    singular = replace(SUMMARY, results={"tension": TENSION, "given": diverging})
    short = said((folder, singular))
    assert "Singular, left out: small-end bore's edge, 99 MPa (contact.small_end_relief_mm)" in short
    assert "diverging" not in short.lower()
    text = flowing(said((folder, singular), verbose=True))
    assert "Singular, left out: small-end bore's edge, 99 MPa" in text


def test_it_fits_eighty_columns(folder):
    assert all(len(line.rstrip()) <= 80 for line in said((folder, SUMMARY)).splitlines()[:8])


def test_it_begins_with_the_verdict_and_ends_with_what_to_do(folder):
    lines = said((folder, SUMMARY)).splitlines()
    assert lines[0] == "leon-2001 at 6000 rpm: does not yield, safety factor 1.99 ± 0.06 (tension);"
    assert "1 of 1 checks passed; 2.3 s" in "\n".join(lines)
    assert lines[-1] == f"Next: fea view {folder / 'tension.vtu'}"
    drawn = replace(SUMMARY, files=(*FILES, "tension.png"))
    assert f"look at {folder / 'tension.png'}" in said((folder, drawn)).splitlines()[-1]


@pytest.mark.parametrize("width", [40, 50, 60, 70, 80, 100])
def test_no_figure_is_cut_on_a_narrow_terminal(folder, width):
    text = said((folder, SUMMARY), width=width)
    assert "…" not in text
    rows = [line.split() for line in text.splitlines()]
    (tension,) = (row for row in rows if row[:1] == ["tension"] and "312.0" in row)
    assert {"312.0", "3.1", "1.99"} <= set(tension)
    assert ("0.109" in tension) == (width >= 70)


def test_paths_are_told_from_where_one_is(folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    assert f"Next: fea view {Path(folder.name, 'tension.vtu')}" in said((folder, SUMMARY))


def test_several_speeds_end_with_what_to_look_at(folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    runs = []
    for rpm, safety in ((3000, 3.0), (6000, 1.5), (9000, 1.2)):
        found = replace(
            SUMMARY,
            rpm=rpm,
            results={"tension": replace(TENSION, min_safety_factor=safety), "given": GIVEN},
            files=FILES if rpm < 9000 else ("summary.json",),
        )
        runs.append((folder / f"{rpm}rpm", found))
    lines = said(*reversed(runs)).splitlines()
    assert lines[-1] == f"Next: fea view {Path(folder.name, '6000rpm', 'tension.vtu')}"
    assert [words[0] for line in lines if (words := line.split()) and words[0].isdigit()] == [
        "3000",
        "6000",
        "9000",
    ]
    runs[0] = (runs[0][0], replace(runs[0][1], shared_files=("map.csv", "cycle_map.png")))
    assert said(*runs).splitlines()[-2:] == [
        f"Next: look at {Path(folder.name, 'cycle_map.png')}",
        f"Then: fea view {Path(folder.name, '6000rpm', 'tension.vtu')}",
    ]


def test_notes_that_only_the_speed_tells_apart_are_one():
    trace = "pressure was not measured at {} rpm: the trace of 6000 rpm is used"
    notes = [(rpm, [warning(trace.format(rpm)), warning("coarse")]) for rpm in (7000, 8000.5, 6000)]
    assert gathered(notes) == [warning(trace.format("7000, 8000.5, 6000")), warning("coarse")]
    many = [(rpm, [warning(trace.format(rpm))]) for rpm in (7000, 6000, 9000, 8000, 10000)]
    assert gathered(many) == [warning(trace.format("5 speeds from 6000 to 10000"))]


def test_every_path_is_named(folder):
    assert f"Written to {folder}/ (3 files)." in said((folder, SUMMARY))
    text = said((folder, SUMMARY), verbose=True)
    assert f"Written to {folder}/" in text
    assert "given.vtu  tension.vtu" in text


def test_a_failed_check_is_said_loudly(folder, monkeypatch):
    monkeypatch.chdir(folder.parent)  # a long path leaves no room for warnings
    checks = {**SUMMARY.checks, "reactions": Check(0.5, 1e-6)}
    text = said((folder, replace(SUMMARY, notes=(warning("trace of 3000 rpm used"),), checks=checks)))
    assert "NOT TO BE TRUSTED: failed checks: reactions (0.5, limit 1e-06)." in text
    assert "1 of 2 checks passed" in text
    assert "Trace of 3000 rpm used." in text


def test_very_large_forces_and_very_small_factors_keep_their_digits(folder):
    load = replace(LOADS["tension"], pin_axial_N=1.49e9, crank_axial_N=-1_796_200.0)
    small = replace(TENSION, min_safety_factor=0.00331)
    extreme = replace(SUMMARY, loads=LOADS | {"tension": load}, results={"tension": small, "given": GIVEN})
    row = next(line.split() for line in said((folder, extreme)).splitlines() if "tension " in line[:9])
    assert {"+1.5e+06", "-1796"} <= set(row)
    assert "0.0033" in row


def test_several_speeds_share_a_table(tmp_path):
    fast = replace(SUMMARY, notes=(warning("trace of 3000 rpm used"),))
    slow = replace(fast, rpm=800, trusted=False)
    text = said((tmp_path / "800rpm", slow), (tmp_path / "6000rpm", fast))
    rows = [line.split() for line in text.splitlines()]
    assert ["800", "tension", "4", "312.0", "3.1", "1.99", "check", "failed"] in rows
    assert ["6000", "tension", "4", "312.0", "3.1", "1.99"] in rows
    assert "Not converged: the worst case of 2 speeds" in text
    assert text.count("Trace of 3000 rpm used.") == 1
    assert f"{tmp_path}/map.csv" in text


def test_several_speeds_are_judged_by_the_worst(tmp_path):
    fails = replace(SUMMARY.survival, answer="fails", text="yields", assured_safety_factor=0.9)
    open_ = replace(SUMMARY.survival, answer="undecided", text="undecided", assured_safety_factor=0.8)
    good = replace(SUMMARY.survival, answer="survives", text="survives", assured_safety_factor=0.7)
    runs = [
        (tmp_path / f"{rpm}rpm", replace(SUMMARY, rpm=rpm, survival=survival))
        for rpm, survival in ((800, good), (3000, fails), (6000, open_))
    ]
    first = said(*runs).splitlines()[0]
    assert first.endswith("at 3000 rpm, the worst of 3 speeds: yields")


def test_what_was_refined_says_so(folder):
    a_pass = PassFigures(elements=1, nodes=2, error_percent=9.0, seconds=0.1)
    one, two = (replace(SUMMARY, passes=(a_pass,) * n) for n in (1, 2))
    assert [", refined)" in said((folder, found)) for found in (SUMMARY, one, two)] == [False, False, True]
    assert "Not converged: tension\n" in said((folder, two))


def test_the_case_with_the_smallest_factor_is_the_worst():
    assert SUMMARY.worst_case == "tension"


def test_nothing_is_said_of_no_run():
    assert said() == ""


NOTES = (
    remark("the mesh was made again with smaller elements at the places at fault, because it was bad"),
    *(assumption(f"assumed value {number} (table.key_{number})", "bolts") for number in range(12)),
    warning("the preload of the bolts may fall, because the seat creeps under so high a pressure", "bolts"),
    *(warning(f"a limit of the figures, number {number}, which takes more than a line of the terminal to say")
      for number in range(7)),
    doubt("strains are too large for linear elasticity: real stresses and displacements differ"),
    omission("inertia of the rod", "the engine stands still"),
)  # fmt: skip


def test_notes_stand_in_the_order_of_their_consequence():
    notes, left_out = by_consequence((*NOTES, *NOTES))
    kinds = list(dict.fromkeys(note.kind.value for note in notes))
    assert kinds == ["doubt", "warning", "assumption", "remark"]
    assert len(notes) == len(NOTES) - 1
    assert left_out == NOTES[-1:]


def test_ten_lines_follow_the_table_and_verbose_says_everything(folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    notes, left_out = by_consequence(NOTES)
    failed = {**SUMMARY.checks, "reactions": Check(0.5, 1e-6)}
    full = replace(SUMMARY, notes=notes, left_out=left_out, checks=failed)
    short = said((folder, full))
    require_brief(short)
    order = (
        "NOT TO BE TRUSTED",
        "Governs: yielding",
        "Strains are too large",
        "Not converged",
        "12 assumptions",
    )
    places = [short.index(text) for text in order]
    assert places == sorted(places)
    assert "12 assumptions, 10 notes, 1 omission: --verbose, `fea report`, summary.json." in short
    text = said((folder, full), verbose=True)
    assert max(map(len, text.splitlines())) <= 80
    assert all(f"- {note}" in flowing(text) for note in (*notes, *left_out))


def test_values_that_engines_do_not_have_stand_below_the_headline(folder):
    odd = [doubt(f"engine.key_{number} = 1: it is odd", UNITS) for number in range(3)]
    lines = said((folder, replace(SUMMARY, notes=tuple(odd)))).splitlines()
    assert lines[2].startswith("Check the units: engine.key_0 = 1: it is odd; engine.key_1 = 1")
    assert "Unusual, too: 1 more value (--verbose)." in " ".join(lines[2:5])


def test_few_of_the_solids_that_are_left_out_are_listed_the_largest_first():
    kept = [SolidFigures(name="rod", role="rod", kept=True, mass_kg=0.5, size_mm=(1.0, 2.0, 3.0))]
    left = [
        SolidFigures(name=f"bolt {n}", role="bolt", kept=False, mass_kg=n / 100, size_mm=(1.0, 2.0, 3.0))
        for n in range(1, 28)
    ]
    lines = [line.strip() for line in solid_lines([*left, *kept])]
    assert [line.split(":")[0] for line in lines[:4]] == ["rod", "bolt 27", "bolt 26", "bolt 25"]
    assert lines[4] == "and 24 smaller solids, left out (--json lists them)"
    assert len(lines) == 5
