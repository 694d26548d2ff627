import errno
import json
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from fea.output import folder
from fea.output.folder import OccupiedError, StorageError, reported, require_replaceable, run_folder

WRITER = """
import json, sys, time
from pathlib import Path
from fea.output.folder import run_folder
target, pause = Path(sys.argv[1]), float(sys.argv[2])
for number in range(1000):
    with run_folder(target) as part:
        (part / "study.toml").write_text(f"{number}")
        (part / "loads.csv").write_text("#")
        print(number, flush=True)
        time.sleep(pause)
        files = ["summary.json", "study.toml", "loads.csv"]
        summary = {"schema": "fea/summary/1", "study": number, "files": files}
        (part / "summary.json").write_text(json.dumps(summary))
"""


def write_run(
    part: Path, study: str = "one", cases: tuple[str, ...] = ("tension",), shared: list[str] | None = None
) -> None:
    names = ["study.toml", "loads.csv", *(f"{case}.vtu" for case in cases)]
    for name in names:
        (part / name).write_text(study)
    summary = {"schema": "fea/summary/1", "study": study, "files": [*names, "summary.json"]}
    (part / "summary.json").write_text(json.dumps(summary | ({"shared_files": shared} if shared else {})))


def study_in(target: Path) -> str:
    return json.loads((target / "summary.json").read_text())["study"]


def hidden(target: Path) -> list[str]:
    return [entry.name for entry in target.parent.iterdir() if entry.name.startswith(".")]


def test_a_run_appears_complete_with_its_parents_and_ordinary_permissions(tmp_path):
    target = tmp_path / "results" / "run"
    with run_folder(target) as part:
        write_run(part)
        assert not target.exists()
        assert part.parent == target.parent  # the same file system
    assert study_in(target) == "one"
    assert hidden(target) == []
    (tmp_path / "ordinary").mkdir()
    assert target.stat().st_mode == (tmp_path / "ordinary").stat().st_mode


@pytest.mark.parametrize("in_one_step", [True, False])
def test_a_new_run_replaces_all_of_an_earlier_one(tmp_path, monkeypatch, in_one_step):
    if not in_one_step:
        monkeypatch.setattr(folder, "exchange", lambda *_: False)
    target = tmp_path / "run"
    for study, cases in (("one", ("tension", "side")), ("two", ("gas",))):
        with run_folder(target) as part:
            write_run(part, study, cases)
    assert study_in(target) == "two"
    assert {entry.name for entry in target.iterdir()} == {
        "summary.json",
        "study.toml",
        "loads.csv",
        "gas.vtu",
    }
    assert hidden(target) == []


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_a_run_that_fails_leaves_everything_as_it_was(tmp_path, error):
    target = tmp_path / "new" / "results" / "run"
    with pytest.raises(error), run_folder(target):
        raise error
    assert list(tmp_path.iterdir()) == []
    with run_folder(target) as part:
        write_run(part)
    with pytest.raises(error), run_folder(target) as part:
        write_run(part, "two")
        raise error
    assert study_in(target) == "one"
    assert hidden(target) == []


_LINKS = pytest.mark.skipif(os.name != "posix", reason="symbolic links need a privilege elsewhere")


@_LINKS
def test_an_empty_directory_and_a_linked_run_are_replaced(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    for study in ("one", "two"):
        with run_folder(tmp_path / "link") as part:
            write_run(part, study)
    assert (tmp_path / "link").is_symlink()
    assert study_in(tmp_path / "real") == "two"


def test_a_sweep_over_speeds_is_an_earlier_run_too(tmp_path):
    target = tmp_path / "sweep"
    for _ in range(2):
        with run_folder(target) as part:
            for speed in ("800rpm", "6000rpm"):
                (part / speed).mkdir()
                write_run(part / speed, shared=["map.csv"])
            (part / "map.csv").write_text("rpm\n")
    (target / "800rpm" / "notes.txt").write_text("mine")
    with pytest.raises(OccupiedError, match="not from an earlier run"):
        require_replaceable(target)
    (target / "800rpm" / "notes.txt").unlink()
    require_replaceable(target)
    (target / "notes.txt").write_text("mine")
    with pytest.raises(OccupiedError, match="not from an earlier run"):
        require_replaceable(target)


def test_runs_side_by_side_are_not_one_of_several_speeds(tmp_path):
    for name in ("one-800rpm", "one-6000rpm"):
        (tmp_path / "results" / name).mkdir(parents=True)
        write_run(tmp_path / "results" / name)
    with pytest.raises(OccupiedError, match="not from an earlier run"):
        require_replaceable(tmp_path / "results")


def test_a_picture_beside_its_result_is_part_of_the_run(tmp_path):
    target = tmp_path / "run"
    with run_folder(target) as part:
        write_run(part)
    (target / "tension.png").touch()
    require_replaceable(target)
    (target / "loads.png").touch()
    with pytest.raises(OccupiedError, match="not from an earlier run"):
        require_replaceable(target)


def mine_alone(target):
    (target / "summary.json").unlink()


def mine_beside(target):
    (target / "notes.txt").write_text("mine")


def mine_inside(target):
    (target / "gas.vtu").mkdir()


def mine_linked(target):
    (target / "gas.vtu").symlink_to("/etc/passwd")


def of_another_program(target):
    (target / "summary.json").write_text('{"schema": "other/1"}')


def half_a_file(target):
    (target / "summary.json").write_text('{"schema": "fea/summ')


@pytest.mark.parametrize(
    "spoil",
    [
        mine_alone,
        mine_beside,
        mine_inside,
        pytest.param(mine_linked, marks=_LINKS),
        of_another_program,
        half_a_file,
    ],
)
def test_what_is_not_a_run_is_never_touched(tmp_path, spoil):
    target = tmp_path / "run"
    target.mkdir()
    write_run(target)
    spoil(target)
    before = sorted(entry.name for entry in target.iterdir())
    with (
        pytest.raises(OccupiedError, match=r"not from an earlier run.*--out"),
        run_folder(target),
    ):
        pytest.fail("the block must not be entered")
    assert sorted(entry.name for entry in target.iterdir()) == before


def test_what_appears_during_the_run_is_not_touched_either(tmp_path):
    target = tmp_path / "run"
    with pytest.raises(OccupiedError), run_folder(target) as part:
        write_run(part)
        target.mkdir()
        (target / "thesis.tex").write_text("mine")
    assert (target / "thesis.tex").read_text() == "mine"
    assert hidden(target) == []


def test_a_file_and_the_current_directory_are_refused(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OccupiedError, match="is a file"):
        require_replaceable(tmp_path / "file")
    with pytest.raises(OccupiedError, match=r"is inside .*file, which is not a directory"):
        require_replaceable(tmp_path / "file" / "run")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(OccupiedError, match="current directory"):
        require_replaceable(Path())
    with pytest.raises(OccupiedError, match="current directory"):
        require_replaceable(tmp_path.parent)


def test_what_the_system_refuses_is_said_with_its_reason(tmp_path, monkeypatch):
    def refuse(*_args, **_options):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "mkdir", refuse)
    with pytest.raises(StorageError, match=r"run could not be written: Permission denied.*--out"):
        run_folder(tmp_path / "run").__enter__()
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(StorageError, match=r"Permission denied. Choose"), reported(Path("run"), "Choose"):
        refuse()
    with pytest.raises(StorageError, match=r"long paths"), reported(Path("a" * 240), "Choose"):
        refuse()


def test_a_failed_swap_puts_the_earlier_run_back(tmp_path, monkeypatch):
    target = tmp_path / "run"
    with run_folder(target) as part:
        write_run(part)
    rename = Path.rename

    def refuse_parts(self, other):
        if self.suffix == ".part":
            raise OSError(5, "Input/output error")
        return rename(self, other)

    monkeypatch.setattr(folder, "exchange", lambda *_: False)
    monkeypatch.setattr(Path, "rename", refuse_parts)
    with pytest.raises(StorageError, match="Input/output error"), run_folder(target) as part:
        write_run(part, "two")
    assert study_in(target) == "one"
    assert hidden(target) == []


def test_a_run_that_stepped_aside_is_put_back_by_the_next(tmp_path):
    target = tmp_path / "run"
    with run_folder(target) as part:
        write_run(part)
    target.rename(tmp_path / ".run.0123abcd.backup")
    with pytest.raises(RuntimeError), run_folder(target):
        raise RuntimeError
    assert study_in(target) == "one"
    assert hidden(target) == []


def killed_writer(target: Path, lines: int, pause: float, wait: float = 0) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(target), str(pause)], stdout=subprocess.PIPE
    )
    with process:
        for _ in range(lines):
            process.stdout.readline()
        time.sleep(wait)
        process.send_signal(signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL


@pytest.mark.skipif(os.name != "posix", reason="there is no kill -9 elsewhere")
def test_a_killed_run_harms_nothing_and_the_next_clears_its_remains(tmp_path):
    target = tmp_path / "run"
    killed_writer(target, lines=2, pause=0.3)  # the second run is under way
    assert study_in(target) == 0
    assert len(hidden(target)) == 1
    with run_folder(target) as part:
        write_run(part)
        assert hidden(target) == [part.name]
    assert hidden(target) == []


@pytest.mark.skipif(os.name != "posix", reason="there is no kill -9 elsewhere")
def test_wherever_a_run_is_killed_the_target_is_one_complete_run(tmp_path):
    target = tmp_path / "run"
    for wait in (0.0, 0.0003, 0.001, 0.002, 0.005):
        killed_writer(target, lines=3, pause=0.0, wait=wait)
        assert study_in(target) == int((target / "study.toml").read_text())
        assert {entry.name for entry in target.iterdir()} == {"summary.json", "study.toml", "loads.csv"}


def test_runs_into_one_place_at_once_are_all_complete(tmp_path):
    target = tmp_path / "run"

    def run(study: str) -> None:
        with run_folder(target) as part:
            (part / "study.toml").write_text(study)
            time.sleep(0.01)
            write_run(part, study)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(run, map(str, range(24))))
    assert study_in(target) == (target / "study.toml").read_text()
    assert hidden(target) == []


@pytest.mark.parametrize("length", [245, 255])
def test_a_name_too_long_for_what_stands_beside_it_is_refused_at_once(tmp_path, length):
    target = tmp_path / "results" / ("x" * length)
    with pytest.raises(StorageError, match=re.escape(os.strerror(errno.ENAMETOOLONG))):
        require_replaceable(target)
    with pytest.raises(StorageError, match=re.escape(os.strerror(errno.ENAMETOOLONG))), run_folder(target):
        pass
    assert list(tmp_path.iterdir()) == []


def test_parents_made_for_a_run_that_cannot_begin_go_again(tmp_path, monkeypatch):
    monkeypatch.setattr(folder, "_mend", _refused)
    with pytest.raises(StorageError, match="Permission denied"), run_folder(tmp_path / "a" / "b" / "run"):
        pass
    assert list(tmp_path.iterdir()) == []


def _refused(_place):
    raise PermissionError(13, "Permission denied")


def test_messages_name_a_place_as_it_is_short_to_type(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("keep")
    for target, words in (
        (tmp_path / "file", "^file is a file"),
        (tmp_path / "file" / "r", f"^{re.escape(str(Path('file', 'r')))} is inside file,"),
    ):
        with pytest.raises(OccupiedError, match=words):
            require_replaceable(target)
