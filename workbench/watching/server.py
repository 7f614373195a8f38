"""Server: the page about a running study, for this machine alone and to be read only.

It listens on 127.0.0.1. A name that somebody else's page makes point there (DNS rebinding) is seen by the Host header
and refused. Two paths are known, the page and its data; nothing that is asked for ever becomes the name of a file.
"""

from __future__ import annotations

from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from socketserver import TCPServer
from typing import ClassVar, cast

from instances.errors import InputError
from reports.pages.page import policy
from reports.pages.watched import WATCHED
from workbench.watching.standing import Observer

ADDRESS = "127.0.0.1"
NAMES = (ADDRESS, "localhost")
PATIENCE = 10
"""Seconds a client may take to say what it wants."""
HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class PageServer(ThreadingHTTPServer):
    """Serves what `observer` sees at `port`, 0 for any that is free; InputError where it is taken."""

    daemon_threads = True

    def __init__(self, observer: Observer, port: int = 0) -> None:
        self.observer = observer
        try:
            super().__init__((ADDRESS, port), _Handler)
        except OSError as error:
            raise InputError(f"--port: {port} cannot be used ({error.strerror or error})") from None

    def server_bind(self) -> None:
        """Bind without asking the network for the machine's name, as the library does."""
        TCPServer.server_bind(self)
        self.server_name, self.server_port = ADDRESS, self.socket.getsockname()[1]

    @property
    def url(self) -> str:
        """Where the page is."""
        return f"http://{ADDRESS}:{self.server_port}/"


class _Handler(BaseHTTPRequestHandler):
    timeout = PATIENCE
    server_version = "workbench"
    sys_version = ""
    protocol_version = "HTTP/1.1"
    kinds: ClassVar = {"/": "text/html; charset=utf-8", "/data.json": "application/json"}

    def parse_request(self) -> bool:
        """Refuse whatever is no GET or HEAD, and whoever asked for another name than this machine's."""
        if not super().parse_request():
            return False
        server = cast(PageServer, self.server)
        if self.headers.get_all("Host") not in [[f"{name}:{server.server_port}"] for name in NAMES]:
            return self._refuse(HTTPStatus.MISDIRECTED_REQUEST)
        if self.command not in ("GET", "HEAD"):
            return self._refuse(HTTPStatus.METHOD_NOT_ALLOWED)
        return True

    def do_GET(self) -> None:
        """Answer with the page or its data."""
        observer = cast(PageServer, self.server).observer
        if self.path not in self.kinds:
            self._refuse(HTTPStatus.NOT_FOUND)
            return
        try:
            text = observer.page() if self.path == "/" else observer.data()
            self._answer(HTTPStatus.OK, text, self.kinds[self.path])
        except InputError as error:
            self._answer(HTTPStatus.SERVICE_UNAVAILABLE, f"{error}\n")

    do_HEAD = do_GET  # noqa: N815

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""

    def _refuse(self, status: HTTPStatus) -> bool:
        self.close_connection = True  # what else was sent is not read
        self._answer(status, f"{status.value} {status.phrase}\n")
        return False

    def _answer(self, status: HTTPStatus, text: str, kind: str = "text/plain; charset=utf-8") -> None:
        content = text.encode("utf-8", "backslashreplace")
        self.send_response(status)
        self.send_header("Content-Security-Policy", f"{policy(WATCHED)}; frame-ancestors 'none'")
        for name, value in HEADERS.items():
            self.send_header(name, value)
        if status is HTTPStatus.METHOD_NOT_ALLOWED:
            self.send_header("Allow", "GET, HEAD")
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)
