"""A real S3 server over HTTP on a loopback port, with a gate in front that fails as it is told."""

from __future__ import annotations

import http.client
import threading
from collections.abc import Generator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Literal, TypeAlias
from urllib.parse import urlsplit

import pytest

Fault: TypeAlias = Literal["", "read-only", "wrong key", "cut", "hang up"]
BUCKET = "clinic-bucket"


class Gate:
    """Passes requests on to the server, or fails them as it is told.

    Attributes:
        url: Its address.
        fault: "read-only" refuses changes, "wrong key" all, "cut" halves downloads, "hang up" answers none.
        passes: Requests that are still answered before the fault begins.
        changes: Methods of the changing requests that came through.
    """

    def __init__(self, behind: str) -> None:
        self.behind = urlsplit(behind)
        self.fault: Fault = ""
        self.passes = 0
        self.changes: list[str] = []
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), _handler(self))
        self._server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self._server.server_port}"
        threading.Thread(
            target=self._server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True
        ).start()

    def now(self) -> Fault:
        """The fault that the next request meets."""
        if self.fault and self.passes > 0:
            self.passes -= 1
            return ""
        return self.fault

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()


def _handler(gate: Gate) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def log_message(self, format: str, *args: object) -> None:
            del format, args

        def _pass(self) -> None:
            body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
            fault = gate.now()
            if fault == "hang up":
                self.close_connection = True
                return
            if fault == "read-only" and self.command not in ("GET", "HEAD"):
                self._answer(403, {}, b"<Error><Code>AccessDenied</Code></Error>")
                return
            if fault == "wrong key":
                self._answer(403, {}, b"<Error><Code>InvalidAccessKeyId</Code></Error>")
                return
            status, headers, data = self._behind(body)
            if self.command not in ("GET", "HEAD"):
                gate.changes.append(self.command)
            self._answer(status, headers, data, cut=fault == "cut" and self.command == "GET")

        def _behind(self, body: bytes) -> tuple[int, dict[str, str], bytes]:
            there = http.client.HTTPConnection(str(gate.behind.hostname), gate.behind.port, timeout=30)
            sent = {name: value for name, value in self.headers.items() if name.lower() != "connection"}
            there.request(self.command, self.path, body or None, sent)
            answer = there.getresponse()
            data = answer.read()
            headers = {name: value for name, value in answer.getheaders()}
            there.close()
            return answer.status, headers, data

        def _answer(self, status: int, headers: dict[str, str], data: bytes, cut: bool = False) -> None:
            self.send_response_only(status)
            length = headers.get("Content-Length", str(len(data)))
            for name, value in headers.items():
                if name.lower() not in ("content-length", "connection", "transfer-encoding"):
                    self.send_header(name, value)
            self.send_header("Content-Length", length if self.command == "HEAD" else str(len(data)))
            self.end_headers()
            if self.command != "HEAD":
                self.wfile.write(data[: len(data) // 2] if cut else data)
            self.close_connection = self.close_connection or cut

        do_GET = do_HEAD = do_PUT = do_POST = do_DELETE = _pass

    return Handler


@contextmanager
def s3_server() -> Generator[str]:
    """Address of a server without buckets."""
    from moto.server import ThreadedMotoServer

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    try:
        yield f"http://{host}:{port}"
    finally:
        server.stop()


def make_bucket(url: str, bucket: str = BUCKET) -> None:
    """Make a bucket, empty where it was there."""
    place = urlsplit(url)
    there = http.client.HTTPConnection(str(place.hostname), place.port, timeout=10)
    there.request("POST", "/moto-api/reset")
    there.getresponse().read()
    there.request("PUT", f"/{bucket}")
    answer = there.getresponse()
    answer.read()
    there.close()
    if answer.status != 200:
        pytest.fail(f"the S3 server of the tests refuses a bucket: {answer.status}")
