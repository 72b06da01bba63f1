"""Browsers that look at the clinic from a process of their own: told whom to be on stdin, figures on stdout.

Each polls the state four times a second, and reads its live picture more slowly than it is sent.
"""

from __future__ import annotations

import http.client
import json
import sys
import threading
import time
import urllib.parse
from typing import Any

import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

POLL_S = 0.25
READ_S = 0.2


class Browser:
    """One signed-in page."""

    def __init__(self, host: str, cookie: str, token: str, read_s: float) -> None:
        self._read_s = read_s
        self._host = host
        self._cookie = cookie
        self._token = token
        self._ended = threading.Event()
        self._threads = [threading.Thread(target=work, daemon=True) for work in (self._poll, self._look)]
        self.polls_s: list[float] = []
        self.pictures = 0

    def start(self) -> None:
        for thread in self._threads:
            thread.start()

    def end(self) -> None:
        self._ended.set()
        for thread in self._threads:
            thread.join(5.0)

    def _poll(self) -> None:
        headers = {
            "Cookie": self._cookie,
            "X-Form-Token": self._token,
            "Origin": f"http://{self._host}",
            "Accept": "application/json",
            "Content-Type": "application/x-www-form-urlencoded",
        }
        line = http.client.HTTPConnection(self._host, timeout=30.0)
        fields = urllib.parse.urlencode({"page": "x" * 32})
        while not self._ended.wait(POLL_S):
            start_s = time.perf_counter()
            line.request("POST", "/live/beat", fields, headers)
            json.loads(line.getresponse().read())
            self.polls_s.append(time.perf_counter() - start_s)

    def _look(self) -> None:
        with connect(
            f"ws://{self._host}/live/view",
            origin=f"http://{self._host}",
            subprotocols=[f"viser-v{viser.__version__}"],
            additional_headers={"Cookie": self._cookie},
            compression=None,
            max_size=None,
            ping_interval=None,
        ) as line:
            while not self._ended.wait(self._read_s):
                try:
                    line.recv(timeout=1.0)
                except TimeoutError:
                    continue
                except ConnectionClosed:
                    return
                self.pictures += 1


def main() -> None:
    asked: dict[str, Any] = json.loads(sys.stdin.readline())
    read_s = float(asked.get("read_s", READ_S))
    browsers = [Browser(asked["host"], one["cookie"], one["token"], read_s) for one in asked["browsers"]]
    for browser in browsers:
        browser.start()
    sys.stdin.readline()
    for browser in browsers:
        browser.end()
    figures = [{"polls_s": one.polls_s, "pictures": one.pictures} for one in browsers]
    sys.stdout.write(json.dumps(figures))


if __name__ == "__main__":
    main()
