"""Who may talk to the server: the page that it served itself, with the token of this start."""

import hmac
import secrets
from dataclasses import dataclass, field
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

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
