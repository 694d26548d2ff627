"""The job behind `fea studio`: a server of one page, which nobody else can open."""

import asyncio
import hmac
import logging
import secrets
from collections.abc import Callable
from dataclasses import dataclass, field
from http import HTTPStatus
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from fea.apps.studio.jobs import MODEL, Worker, open_live, open_worker
from fea.apps.studio.session import State, session
from fea.apps.studio.studio import Studio
from fea.machine.system import saying
from fea.output.folder import near
from fea.output.html import html_page, joined_script, page_file, policy
from fea.study.study import Study

SOCKET = "/socket"


@dataclass
class Access:
    """Answers every request: the page, the socket of the page, or a refusal."""

    port: int
    page: str  #: HTML
    policy: str  #: what the page may do, with {socket} for its socket
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))

    @property
    def host(self) -> str:
        """The only name of the server: others may be of a foreign page whose address leads here."""
        return f"127.0.0.1:{self.port}"

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{self.host}/?token={self.token}"

    def __call__(self, _connection: ServerConnection, request: Request) -> Response | None:
        """Answer a request; None lets the socket open."""
        path, asked = urlsplit(request.path).path, parse_qs(urlsplit(request.path).query)
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        token = asked.get("token", [""])[0]
        # Only browsers send an Origin: always for a socket, and for an address that is opened by hand never.
        sent = ([f"http://{self.host}"],) if path == SOCKET else ([], [f"http://{self.host}"])
        ours = hosts == [self.host] and origins in sent
        if not (ours and hmac.compare_digest(token.encode(), self.token.encode())):
            return self._response(HTTPStatus.FORBIDDEN, "Open the address that fea studio printed.\n")
        if path == SOCKET:
            return None
        if path == "/":
            return self._response(HTTPStatus.OK, self.page, "text/html")
        return self._response(HTTPStatus.NOT_FOUND, "There is nothing here.\n")

    def _response(self, status: HTTPStatus, body: str, kind: str = "text/plain") -> Response:
        policy = self.policy.format(socket=f"ws://{self.host}{SOCKET}")
        headers = {
            "Content-Type": f"{kind}; charset=utf-8",
            "Content-Length": str(len(body.encode())),
            "Content-Security-Policy": f"{policy}; frame-ancestors 'none'",
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Connection": "close",
        }
        return Response(status.value, status.phrase, Headers(headers), body.encode())


_LONGEST_MESSAGE = 2**16  # bytes, from the page


async def serve_studio(studio: Studio, access: Access, opened: Callable[[str], None]) -> None:
    """Serve the page until cancelled; `opened` is told its address. Raises `OSError`: the port is taken."""
    logging.getLogger("websockets").addHandler(logging.NullHandler())
    async with serve(
        studio.meet,
        "127.0.0.1",
        access.port,
        process_request=access,
        compression=None,
        server_header=None,
        max_size=_LONGEST_MESSAGE,
    ) as server:
        access.port = next(iter(server.sockets)).getsockname()[1]
        opened(access.address)
        await studio.run()


# In this order, as one script: each uses what stands before it.
_OF_REPORT = ("vectors", "numbers", "surface", "camera", "painter", "pick", "hands", "legend")
_OWN = ("wire", "stage", "sliders", "answer", "variants", "studio")


def studio_page(title: str) -> tuple[str, str]:
    """Return the page, and the policy of what it may do, with {socket} for the address of its socket."""
    style = page_file("report", "report.css") + page_file("studio", "studio.css")
    rooms = ("report", _OF_REPORT), ("studio", _OWN)
    script = joined_script(*((room, [f"{name}.js" for name in names]) for room, names in rooms))
    page = html_page("studio", "studio.html.jinja", style, script, title=title)
    return page, policy(style, script).replace("connect-src 'none'", "connect-src {socket}")


def run_studio(
    study: Study, folder: Path, port: int, opened: Callable[[str], None], model: str = MODEL
) -> None:
    """Serve the page of a study until an interrupt; `opened` is told its address.

    Raises `OccupiedError`, `StorageError`: the session cannot be kept in the folder; `OSError`: the port is
    taken.
    """
    page, policy = studio_page(study.name)
    said = f"the studio has ended; the same command resumes its session in {near(folder)}"
    first: State = {"design": {}, "operation": {}}  # of the study: nothing is changed
    with saying(said), session(study, first, folder) as kept:
        live, fresh = Worker(open_live, study, model), Worker(open_worker, study, model)
        served = Studio(kept, folder, live, fresh)
        asyncio.run(serve_studio(served, Access(port, page, policy), opened))
