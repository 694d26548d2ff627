"""A real browser without a window, spoken to by WebDriver BiDi (W3C), the same for Chromium and Firefox."""

import base64
import json
import os
import re
import shutil
import subprocess
import tempfile
import time
import urllib.request
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

PATIENCE = 60  # seconds
# WebGL by the processor, and no traffic of the browser's own.
_CHROMIUM = (
    "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--disable-background-networking", "--disable-component-update",
    "--no-first-run", "--hide-scrollbars",
)  # fmt: skip
_FIREFOX = {
    "webgl.force-enabled": True,
    "webgl.disable-fail-if-major-performance-caveat": True,
    "gfx.webrender.software": True,
    "app.normandy.enabled": False,
    "app.update.disabledForTesting": True,
    "browser.shell.checkDefaultBrowser": False,
    "datareporting.policy.dataSubmissionEnabled": False,
    "network.captive-portal-service.enabled": False,
    "network.connectivity-service.enabled": False,
    "browser.safebrowsing.malware.enabled": False,
    "browser.safebrowsing.phishing.enabled": False,
    "extensions.update.enabled": False,
    "services.settings.server": "",
    "toolkit.startup.max_resumed_crashes": -1,
}


def missing(name):
    """Why there is no such browser here; empty where there is one."""
    needed = {"chromium": ("chromium", "chromedriver"), "firefox": ("firefox-esr",)}[name]
    gone = [program for program in needed if shutil.which(program) is None]
    try:
        import websockets.sync.client  # noqa: F401
    except ImportError:
        gone.append("the Python package websockets")
    return f"{' and '.join(gone)} not installed" if gone else ""


class Browser:
    """A session with a page in it."""

    def __init__(self, socket, session):
        self._socket = socket
        self._number, self.events = 0, []
        if session:
            self.call("session.new", capabilities={})
        events = ["network.beforeRequestSent", "network.fetchError", "log.entryAdded", "browsingContext.load"]
        self.call("session.subscribe", events=events)
        self.page = self.call("browsingContext.getTree")["contexts"][0]["context"]

    def call(self, method, **parameters):
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self._socket.recv(timeout=PATIENCE))
            if message.get("id") == self._number:
                if message["type"] == "error":
                    raise RuntimeError(f"{method}: {message['error']}: {message['message']}")
                return message["result"]
            self.events.append(message)

    def open(self, path, width=1440, height=900):
        """Show a file or an address, and wait until it is loaded; what happened before is forgotten."""
        self.size(width, height)
        self.events.clear()
        url = path if str(path).startswith("http") else Path(path).as_uri()
        self.call("browsingContext.navigate", context=self.page, url=url, wait="complete")

    def size(self, width, height):
        self.call(
            "browsingContext.setViewport", context=self.page, viewport={"width": width, "height": height}
        )

    def run(self, code):
        """The value of an expression, awaited, as JSON carries it."""
        found = self.call(
            "script.evaluate",
            expression=f"(async () => JSON.stringify(await ({code})))()",
            target={"context": self.page},
            awaitPromise=True,
        )
        if found["type"] == "exception":
            raise AssertionError(found["exceptionDetails"]["text"])
        value = found["result"].get("value")
        return None if value is None else json.loads(value)

    def keys(self, *keys):
        actions = [{"type": kind, "value": key} for key in keys for kind in ("keyDown", "keyUp")]
        source = {"type": "key", "id": "keys", "actions": actions}
        self.call("input.performActions", context=self.page, actions=[source])

    def drag(self, start, end):
        """Press at a place of the window, move to another, and let go."""
        moves = [
            {"type": "pointerMove", "x": start[0], "y": start[1]},
            {"type": "pointerDown", "button": 0},
            {"type": "pointerMove", "x": end[0], "y": end[1], "duration": 50},
            {"type": "pointerUp", "button": 0},
        ]
        source = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": moves}
        self.call("input.performActions", context=self.page, actions=[source])

    def screenshot(self, path, *, whole=False):
        origin = "document" if whole else "viewport"
        data = self.call("browsingContext.captureScreenshot", context=self.page, origin=origin)["data"]
        Path(path).write_bytes(base64.b64decode(data))

    def print(self):
        """The first two pages on paper, as a PDF."""
        printed = self.call("browsingContext.print", context=self.page, background=True, pageRanges=["1-2"])
        return base64.b64decode(printed["data"])

    def requests(self):
        """The addresses that anything was asked of."""
        asked = (event for event in self.events if event.get("method") == "network.beforeRequestSent")
        return [event["params"]["request"]["url"] for event in asked]

    def complaints(self):
        """Errors and warnings of the page."""
        said = (event["params"] for event in self.events if event.get("method") == "log.entryAdded")
        return [entry.get("text") for entry in said if entry["level"] in {"error", "warn"}]


@contextmanager
def browser(name, *, webgl=True, dark=False):
    """A browser of a kind, as long as the block lasts."""
    from websockets.sync.client import connect

    start = {"chromium": _chromium, "firefox": _firefox}[name]
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as home,
        start(Path(home), webgl, dark) as (url, session),
        connect(url, max_size=None, open_timeout=PATIENCE) as socket,
    ):
        yield Browser(socket, session)


@contextmanager
def _chromium(home, webgl, dark):
    arguments = [*_CHROMIUM, f"--user-data-dir={home}"]
    if not webgl:
        arguments = [item for item in arguments if "gl=" not in item and "swiftshader" not in item]
        arguments += ["--disable-gpu", "--disable-3d-apis"]
    if dark:
        arguments.append("--blink-settings=preferredColorScheme=0")
    with _process(["chromedriver", "--port=0"], r"successfully on port (\d+)") as port:
        options = {"binary": shutil.which("chromium"), "args": arguments}
        wanted = {"capabilities": {"alwaysMatch": {"webSocketUrl": True, "goog:chromeOptions": options}}}
        request = urllib.request.Request(
            f"http://127.0.0.1:{port}/session",
            json.dumps(wanted).encode(),
            {"Content-Type": "application/json"},
        )
        with urllib.request.urlopen(request, timeout=PATIENCE) as answer:  # noqa: S310 - our own driver
            found = json.load(answer)["value"]
        try:
            yield found["capabilities"]["webSocketUrl"], False
        finally:
            address = f"http://127.0.0.1:{port}/session/{found['sessionId']}"
            with suppress(OSError):
                urllib.request.urlopen(urllib.request.Request(address, method="DELETE"), timeout=20).close()


@contextmanager
def _firefox(home, webgl, dark):
    """Firefox has WebGL on a display only: a virtual one."""
    colours = {"layout.css.prefers-color-scheme.content-override": 0 if dark else 1}
    lines = [
        f"user_pref({json.dumps(key)}, {json.dumps(value)});"
        for key, value in (_FIREFOX | {"webgl.disabled": not webgl} | colours).items()
    ]
    (home / "user.js").write_text("\n".join(lines))
    command = ["firefox-esr", "--profile", str(home), "--remote-debugging-port=0", "about:blank"]
    listening = r"BiDi listening on (ws://\S+)"
    with ExitStack() as stack:
        environment = {"HOME": str(home)}
        if shutil.which("Xvfb"):
            number = stack.enter_context(
                _process(["Xvfb", "-displayfd", "1", "-screen", "0", "1600x1200x24"], r"(\d+)\n")
            )
            environment["DISPLAY"] = f":{number}"
        else:
            command.insert(1, "--headless")
        yield f"{stack.enter_context(_process(command, listening, environment))}/session", True


@contextmanager
def _process(command, pattern, environment=None):
    """A process that says where it listens."""
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(
            command, stdout=said, stderr=subprocess.STDOUT, env=os.environ | (environment or {})
        )
        try:
            yield _told(process, said, pattern)
        finally:
            process.terminate()
            with suppress(subprocess.TimeoutExpired):
                process.wait(20)
            process.kill()


def _told(process, said, pattern):
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and process.poll() is None:
        said.seek(0)
        if found := re.search(pattern, said.read()):
            return found[1]
        time.sleep(0.05)
    said.seek(0)
    raise RuntimeError(f"{process.args[0]} did not start: {said.read()[-2000:]}")
