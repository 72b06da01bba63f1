"""The viewport's page: fetched once from loopback, with a policy that lets exactly its own scripts run."""

from __future__ import annotations

import base64
import gzip
import hashlib
import http.client
import re
import threading
from dataclasses import dataclass

import numpy as np
import zstandard

from rehab_app.errors import Refused
from rehab_app.web.policy import viewport_policy
from rehab_app.web.viewport import LOOPBACK

_ALPHABET = "".join(chr(code) for code in range(0x21, 0x7F) if chr(code) not in "\"&<>'`")
_PATIENCE_S = 20.0
_STYLE = '<link rel="stylesheet" href="/static/viewport.css">'
_LOADER = re.compile(
    r'<script data-p="(?P<packed>[^"]*)" data-ss="(?P<styles>\d+)" data-cs="(?P<code>\d+)">'
    r"(?P<loader>.*?)</script>",
    re.DOTALL,
)


@dataclass(frozen=True, slots=True)
class ClientPage:
    """The page, compressed, and what it may do.

    Attributes:
        gzipped: The page.
        plain: The same, not compressed.
        policy: Its Content-Security-Policy.
        tag: Its entity tag.
    """

    gzipped: bytes
    plain: bytes
    policy: str
    tag: str


class ClientPages:
    """Fetches the viewport's page on first use and keeps it: it is the same for every viewport."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._page: ClientPage | None = None

    def get(self, port: int) -> ClientPage:
        """The page, by way of the viewport at this loopback port.

        Raises:
            Refused: The viewport does not answer, or its page is not the one that this version knows, so that
                no safe policy can be given.
        """
        with self._lock:
            if self._page is None:
                self._page = _client_page(_fetch(port))
            return self._page


def _fetch(port: int) -> bytes:
    connection = http.client.HTTPConnection(LOOPBACK, port, timeout=5.0)
    try:
        connection.request("GET", "/")
        return connection.getresponse().read()
    finally:
        connection.close()


def _client_page(plain: bytes) -> ClientPage:
    text = plain.decode("utf-8")
    found = _LOADER.search(text)
    if found is None or text.count("<script") != 1:
        raise Refused("3-D viewport", "an unknown version", "viser 1.1", "install the version that fits")
    styled = text.replace("</head>", f"{_STYLE}</head>", 1).encode("utf-8")
    tag = hashlib.sha256(styled).hexdigest()[:20]
    return ClientPage(gzip.compress(styled, 6), styled, viewport_policy(_script_hashes(found)), f'"{tag}"')


def _script_hashes(found: re.Match[str]) -> tuple[str, str]:
    """Digests of the loader and of the module that it unpacks and adds to the page."""
    styles, code = int(found["styles"]), int(found["code"])
    unpacked = zstandard.ZstdDecompressor().decompress(unpack_88(found["packed"]), styles + code)
    module = unpacked[styles : styles + code]
    return _digest(found["loader"].encode("utf-8")), _digest(module)


def _digest(script: bytes) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(script).digest()).decode("ascii")


def unpack_88(text: str) -> bytes:
    """Bytes of a base-88 text: five characters make four bytes, the rest r characters make r - 1.

    Args:
        text: Printable ASCII without quotes, angle brackets, ampersand and backtick.
    """
    digits = np.full(128, -1, dtype=np.int64)
    digits[[ord(letter) for letter in _ALPHABET]] = np.arange(88)
    values = digits[np.frombuffer(text.encode("ascii"), dtype=np.uint8)]
    rest = values.size % 5
    groups = values[: values.size - rest].reshape(-1, 5) @ 88 ** np.arange(4, -1, -1)
    whole = groups.astype(">u4").tobytes()
    if rest < 2:
        return whole
    last = int(values[values.size - rest :] @ 88 ** np.arange(rest - 1, -1, -1))
    return whole + last.to_bytes(rest - 1, "big")
