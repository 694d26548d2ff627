"""A `fea studio` in a process, and a page of it that is a script."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
from websockets.sync.client import connect

PATIENCE = 120  # seconds
_FAKE = """
import sys
from pathlib import Path
from fea.__main__ import _end_quietly
from fea.machine.system import interrupt_once
interrupt_once()
from fea.apps.studio.run_studio import run_studio
from fea.study.study import load_study
run_studio(load_study("leon-2001"), Path("session"), 0, lambda at: print(at, flush=True), "fake_studio")
"""


class Served:
    """The process, and the address that it printed."""

    def __init__(self, process):
        self.process = process
        self.address = process.stdout.readline().strip()
        assert self.address.startswith("http://127.0.0.1:"), self.address
        self.url = urlsplit(self.address)

    def workers(self):
        """Processes that it has started."""
        listed = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        return [int(pid) for pid in listed.read_text().split()]

    def page(self, *, origin=None, token=None):
        query = self.url.query if token is None else f"token={token}"
        origin = f"http://{self.url.netloc}" if origin is None else origin
        return connect(f"ws://{self.url.netloc}/socket?{query}", origin=origin, max_size=None)


@contextmanager
def served(folder, *arguments):
    """A studio with the model of `fake_studio`, or with `fea studio` of the arguments."""
    code = ["-m", "fea", "studio", *arguments] if arguments else ["-c", _FAKE]
    path = os.pathsep.join(entry for entry in sys.path if entry)
    process = subprocess.Popen(
        [sys.executable, *code],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield Served(process)
    finally:
        process.kill()
        process.communicate()


def gone(pids):
    """Whether processes end soon."""
    end = time.monotonic() + 5
    while time.monotonic() < end:
        if not any(_lives(pid) for pid in pids):
            return True
        time.sleep(0.05)
    return False


def _lives(pid):
    with suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def end(pid):
    os.kill(pid, signal.SIGKILL)


class Page:
    """What the page's script does, without a browser: it asks, and reads what comes."""

    def __init__(self, socket):
        self.socket, self.serial = socket, 0

    def say(self, do, **what):
        self.socket.send(json.dumps({"do": do, **what}))

    def ask(self, design, *, rests, touched="", **operation):
        self.serial += 1
        state = {"design": design, "operation": operation}
        self.say("ask", serial=self.serial, state=state, rests=rests, touched=touched)
        return state

    def heard(self, timeout=PATIENCE):
        """The next message: its kind, what it says, and the numbers with it."""
        message = self.socket.recv(timeout=timeout)
        if isinstance(message, str):
            told = json.loads(message)
            return told.pop("kind"), told, None
        length = int.from_bytes(message[:4], "little")
        told = json.loads(message[4 : 4 + length])
        kind = np.uint32 if told["kind"] == "mesh" else np.float32
        return told.pop("kind"), told, np.frombuffer(message, kind, offset=4 + length)

    def until(self, kind, **what):
        """What the next message of a kind says that has some entries."""
        while True:
            heard, told, _ = self.heard()
            if heard == kind and all(told.get(key) == value for key, value in what.items()):
                return told
