"""Processes that draw, as copies of one that has loaded the libraries: hundreds of tests need one."""

import json
import os
import select
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryFile

import pytest

from fea.machine.isolated import IsolatedProcess, serve
from fea.output.pictures import picture as process

_LIBRARIES = ("fea.output.pictures.drawing", "pyvista.plotting", "fea.output.pictures.animation_frames")
# What decides how libraries are loaded, by how it begins: where a test changes it, a new interpreter draws.
_DECIDES = ("PYVISTA", "LD_", "DISPLAY", "WAYLAND", "PATH", "PYTHON", "MESA", "LIBGL", "EGL", "HOME")


@contextmanager
def drawn_by_copies(folder):
    """Within this block, and in copies of this process, make processes that draw by copying one."""
    place, original, begun = folder / "socket", process.fresh, _deciding(os.environ)
    command = [sys.executable, "-P", "-c", f"from drawn_by_copies import main; main({str(place)!r})"]
    path = os.pathsep.join(each or str(Path.cwd()) for each in sys.path)
    environment = {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"}

    def fresh(environment, *, messages):
        environment = {**os.environ, **environment}
        if not place.exists() or _deciding(environment) != begun or _limited():
            return original(environment, messages=messages)
        said = TemporaryFile()  # noqa: SIM115 - it goes with the process
        (jobs, ours_out), (ours_in, answers) = os.pipe(), os.pipe()
        asking = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        asking.connect(str(place))
        text = json.dumps([str(Path.cwd()), environment]).encode()
        socket.send_fds(asking, [text], [jobs, answers, said.fileno()])
        os.close(jobs)
        os.close(answers)
        return IsolatedProcess(Started(asking), os.fdopen(ours_out, "wb"), os.fdopen(ours_in, "rb"), said)

    with (
        subprocess.Popen(command, env=environment, stdin=subprocess.PIPE) as model,
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setattr(process, "fresh", fresh)
        yield
        model.kill()


def _deciding(environment):
    known = {key: value for key, value in environment.items() if key.startswith(_DECIDES)}
    return known, sys.executable, list(sys.path)


def _limited():
    import resource

    kinds = (resource.RLIMIT_AS, resource.RLIMIT_FSIZE)
    return any(resource.getrlimit(kind)[0] != resource.RLIM_INFINITY for kind in kinds)


class Started:
    """The process behind a connection, as `subprocess.Popen`."""

    def __init__(self, asking):
        self.returncode, self._asking = None, asking
        self.pid = int(asking.recv(100))

    def wait(self, timeout=None):
        """Wait for its end; return its exit code, −n for an end by signal n."""
        if self.returncode is None:
            if not select.select([self._asking], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired("drawing", timeout)
            self.returncode = int(self._asking.recv(100) or -signal.SIGKILL)
            self._asking.close()
        return self.returncode

    def poll(self):
        """Return its exit code, None while it runs."""
        with suppress(subprocess.TimeoutExpired):
            return self.wait(0)

    def kill(self):
        """End it at once."""
        if self.poll() is None:
            os.kill(self.pid, signal.SIGKILL)


def main(place):
    """Load the libraries, then make a copy for each who asks."""
    for name in _LIBRARIES:
        import_module(name)
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as server:
        server.bind(f"{place}.new")
        server.listen()
        Path(f"{place}.new").rename(place)
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for those that wait
        while True:
            ready, _, _ = select.select([server, sys.stdin], [], [])
            if sys.stdin in ready:  # the tests have ended
                return
            asking, _ = server.accept()
            if not os.fork():
                _attend(asking)
            asking.close()


def _attend(asking):
    """In a copy: make another one, which draws, and say how it ends."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    text, streams, _, _ = socket.recv_fds(asking, 2**18, 3)
    child = os.fork()
    if not child:
        folder, environment = json.loads(text)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        for target, source in enumerate(streams):
            os.dup2(source, target)
            os.close(source)
        asking.close()
        serve(patient=False)
    for stream in streams:
        os.close(stream)
    asking.send(str(child).encode())
    _, status = os.waitpid(child, 0)
    with suppress(OSError):
        asking.send(str(os.waitstatus_to_exitcode(status)).encode())
    os._exit(0)
