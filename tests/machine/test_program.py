"""Standard streams that are closed, full, without a reader or not in UTF-8: the code is the job's own."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import fea

pytestmark = pytest.mark.slow


resource = pytest.importorskip("resource", reason="the shell and the limits of POSIX")
STUDY = Path(fea.__file__).parent / "studies" / "columba-2022.toml"
FEA = f"'{sys.executable}' -m fea"


def shell(line, cwd, **environment):
    settings = {"LANG": "C.UTF-8", "LC_ALL": "C.UTF-8", **environment}
    return subprocess.run(
        ["bash", "-c", line.replace("fea", FEA, 1)],
        cwd=cwd,
        env=os.environ | settings,
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=120,
        check=False,
    )


@pytest.mark.parametrize("command", ["loads --json", "--help"])
def test_a_reader_that_has_gone_changes_nothing(command, tmp_path):
    done = shell(f"fea {command} | true; exit ${{PIPESTATUS[0]}}", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("command", ["loads --json", "--help"])
def test_a_full_stdout_is_exit_7(command, tmp_path):
    done = shell(f"fea {command} >/dev/full", tmp_path)
    assert (done.returncode, done.stderr) == (7, "fea: standard output: No space left on device\n")


def test_closed_streams_change_nothing(tmp_path):
    done = shell("fea loads --json <&- >&-", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert shell("fea loads --rpm -1 2>&-", tmp_path).returncode == 2


def test_a_full_stderr_changes_nothing(tmp_path):
    assert shell("fea loads --rpm -1 2>/dev/full", tmp_path).returncode == 2


def test_what_a_closed_stdout_would_have_had_is_in_no_result(tmp_path):
    """A file opened in its place would be given what libraries write to descriptor 1."""
    assert shell("fea loads --csv l.csv >&- <&-", tmp_path).returncode == 0
    assert shell("fea loads --csv m.csv", tmp_path).returncode == 0
    assert (tmp_path / "l.csv").read_bytes() == (tmp_path / "m.csv").read_bytes()


def test_letters_that_an_encoding_lacks_are_written_as_json_writes_them(tmp_path):
    plain = shell("fea verify le1 --json", tmp_path)
    cells = [(row["quantity"], row["target"]) for row in json.loads(plain.stdout)]
    done = shell("fea verify le1 --json", tmp_path, PYTHONIOENCODING="ascii")
    assert done.returncode == 0, done.stderr
    assert "\\u03c3" in done.stdout
    assert [(row["quantity"], row["target"]) for row in json.loads(done.stdout)] == cells
    done = shell("fea reproduce --help", tmp_path, PYTHONIOENCODING="latin-1")
    assert (done.returncode, done.stderr) == (0, "")


def test_the_streams_of_a_limited_process_do_the_same(tmp_path):
    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (2**32, 2**32))

    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "fea", "loads", "--json"],
            cwd=tmp_path, stdout=full, stderr=subprocess.PIPE, text=True, check=False, preexec_fn=limit,
        )  # fmt: skip
    assert (done.returncode, done.stderr) == (7, "fea: standard output: No space left on device\n")
