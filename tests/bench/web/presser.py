"""A browser that presses stop when it is told to: the time of the press goes to stdout, in monotonic ns."""

from __future__ import annotations

import http.client
import sys
import time


def main() -> None:
    host, cookie = sys.stdin.readline().split(maxsplit=1)
    headers = {"Cookie": cookie.strip(), "Origin": f"http://{host}", "Accept": "application/json"}
    for _ in sys.stdin:
        line = http.client.HTTPConnection(host, timeout=30.0)
        line.connect()
        pressed_ns = time.monotonic_ns()
        line.request("POST", "/stop", "", headers)
        status = line.getresponse().status
        sys.stdout.write(f"{pressed_ns} {time.monotonic_ns()} {status}\n")
        sys.stdout.flush()
        line.close()


if __name__ == "__main__":
    main()
