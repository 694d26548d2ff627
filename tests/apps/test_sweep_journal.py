import json
import os
import sqlite3
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fea.apps.sweep.journal import Journal, RodResult
from fea.apps.sweep.sweep_file import RowState, SweepRow
from fea.output.folder import StorageError
from geometry.errors import InvalidValue

pytestmark = pytest.mark.slow


META = {"schema": "fea/sweep/1", "version": "1", "sweep": "abc"}


def planned(count):
    """Rows of `count` rods at two speeds each."""
    return [
        SweepRow(n, n // 2, {"rod.web_thickness_mm": n // 2}, 1000.0 * (1 + n % 2),
                 job=f"job{n // 2}", key=f"key{n}")
        for n in range(2 * count)
    ]  # fmt: skip


def result(number, *, fails=False):
    if fails:
        return RodResult(f"job{number}", {}, 1.0, "no mesh")
    return RodResult(f"job{number}", {1000.0: {"factor": number}, 2000.0: {"factor": -number}}, 1.0)


def steps(journal, count, failing):
    """What a sweep does with its journal, a transaction each."""
    yield lambda: journal.meta or journal.enter(META, planned(count))
    for number in range(count):
        job = f"job{number}"
        yield (
            lambda number=number, job=job: (
                job in journal.pending() and journal.finish([result(number, fails=number in failing)])
            )
        )


def contents(path):
    with_rows = Journal(path)
    try:
        return [vars(row) for row in with_rows.rows()] if with_rows.meta else []
    finally:
        with_rows.close()


def die_at(path, statement, count, failing, told):
    """In a child: work, and die before a statement of SQL; tell of each transaction that has ended."""
    journal = Journal(path)
    left = statement

    def count_down(_sql):
        nonlocal left
        left -= 1
        if left < 0:
            os._exit(9)

    journal._base.set_trace_callback(count_down)
    for step in steps(journal, count, failing):
        step()
        os.write(told, b".")
    os._exit(0)


@settings(max_examples=15, deadline=None)
@given(st.lists(st.integers(0, 60), min_size=1, max_size=4), st.integers(1, 5), st.sets(st.integers(0, 4)))
def test_dying_at_any_statement_loses_nothing(deaths, count, failing):
    with TemporaryDirectory() as folder:
        path, undisturbed = Path(folder, "a.sqlite"), Path(folder, "b.sqlite")
        for statement in deaths:
            before = contents(path) if path.exists() else []
            read, write = os.pipe()
            child = os.fork()
            if not child:
                try:
                    die_at(path, statement, count, failing, write)
                finally:
                    os._exit(1)
            os.close(write)
            with os.fdopen(read, "rb") as pipe:
                ended = len(pipe.read())
            assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) in (0, 9)
            after = contents(path)
            assert len(after) in ({2 * count} if ended or before else {0, 2 * count})
            settled = {row["number"] for row in after if row["state"] is not RowState.PENDING}
            assert settled >= {row["number"] for row in before if row["state"] is not RowState.PENDING}
            assert settled >= set(range(2 * min(ended - 1, count)))  # what was entered is there
            assert all((n ^ 1) in settled for n in settled)  # both speeds of a rod or none
        for place in (path, undisturbed):
            journal = Journal(place)
            for step in steps(journal, count, failing):
                step()
            journal.close()
        assert contents(path) == contents(undisturbed)


def test_equal_rods_and_failed_ones(tmp_path):
    journal = Journal(tmp_path / "j.sqlite")
    journal.enter(META, planned(2))
    assert journal.pending() == ["job0", "job1"]
    assert journal.design("job1") == ({"rod.web_thickness_mm": 1}, [1000.0, 2000.0])
    journal.finish([result(0), result(1, fails=True)])
    assert journal.counts() == {RowState.PENDING: 0, RowState.DONE: 2, RowState.FAILED: 2}
    assert [row.reason for row in journal.rows()] == ["", "", "no mesh", "no mesh"]
    journal.retry()
    assert journal.pending() == ["job1"]
    journal.finish([result(1)])
    before = [vars(row) for row in journal.rows()]
    journal.finish([result(1, fails=True)])  # a row that is done stays as it is
    journal.finish([RodResult("job1", {1000.0: {"factor": 7}, 2000.0: {}}, 1.0)])
    assert [vars(row) for row in journal.rows()] == before
    assert journal.counts()[RowState.DONE] == 4


def test_a_full_disk_leaves_the_journal_as_it_was(tmp_path):
    journal = Journal(tmp_path / "j.sqlite")
    journal.enter(META, planned(300))
    pages = journal._base.execute("PRAGMA page_count").fetchone()[0]
    journal._base.execute(f"PRAGMA max_page_count = {pages}")
    journal.finish([result(0)])
    before = [vars(row) for row in journal.rows()]
    big = RodResult("job1", {1000.0: {"factor": "x" * 10**6}, 2000.0: {}}, 1.0)
    with pytest.raises(StorageError, match="full"):
        journal.finish([result(2), big])
    journal.close()
    assert contents(tmp_path / "j.sqlite") == before


@pytest.mark.parametrize("content", [b"no database at all, but long enough to be a file" * 40])
def test_another_file_is_refused_and_left_alone(tmp_path, content):
    path = tmp_path / "sweep.sqlite"
    path.write_bytes(content)
    with pytest.raises(InvalidValue, match="is not the journal of a sweep"):
        Journal(path).meta  # noqa: B018
    assert path.read_bytes() == content


def test_another_database_is_refused_and_left_alone(tmp_path):
    path = tmp_path / "sweep.sqlite"
    with sqlite3.connect(path) as base:
        base.execute("CREATE TABLE accounts (owner TEXT)")
    base.close()
    before = path.read_bytes()
    with pytest.raises(InvalidValue, match="has the tables accounts"):
        Journal(path)
    assert path.read_bytes() == before


def test_a_resumed_sweep_asks_for_what_is_left_without_reading_the_rest(tmp_path):
    journal = Journal(tmp_path / "j.sqlite")
    journal.enter(META, planned(500))
    journal.finish([result(number) for number in range(499)])
    journal.close()
    base = sqlite3.connect(tmp_path / "j.sqlite")
    plan = base.execute(
        "EXPLAIN QUERY PLAN SELECT job FROM rods WHERE state = 'pending' GROUP BY job ORDER BY min(number)"
    ).fetchall()
    base.close()
    assert "rods_by_state" in json.dumps(plan)
