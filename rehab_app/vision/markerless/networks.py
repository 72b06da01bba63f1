"""The two networks behind markerless tracking: which they are, where they lie, and that they are whole."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

from sessions.errors import Refused

INSTALL = "rehab-app camera models install"
"""The command that obtains the networks."""

_MOST_BYTES = 64 << 20


@dataclass(frozen=True, slots=True)
class Network:
    """One network, by content.

    Attributes:
        name: What it finds.
        file: Its file name, in the cache as in the wheel.
        sha256: Digest of the file.
        bytes: Its size.
    """

    name: str
    file: str
    sha256: str
    bytes: int


PALM = Network(
    "palm detection",
    "palm_detection_full.tflite",
    "1b14e9422c6ad006cde6581a46c8b90dd573c07ab7f3934b5589e7cea3f89a54",
    2_339_846,
)
LANDMARKS = Network(
    "hand landmarks",
    "hand_landmark_full.tflite",
    "11c272b891e1a99ab034208e23937a8008388cf11ed2a9d776ed3d01d0ba00e3",
    5_478_917,
)
NETWORKS = (PALM, LANDMARKS)
"""Both, published by MediaPipe under Apache-2.0; none is part of this application."""


def cache_folder() -> Path:
    """Where the networks lie: ``rehab-app/models`` in the user's cache (``XDG_CACHE_HOME``)."""
    named = os.environ.get("XDG_CACHE_HOME", "")
    cache = Path(named) if named else Path.home() / ".cache"
    return (cache / "rehab-app" / "models").absolute()


def is_whole(network: Network, content: bytes) -> bool:
    """Whether these bytes are the network, by its digest."""
    return hashlib.sha256(content).hexdigest() == network.sha256


def is_installed(network: Network, folder: Path) -> bool:
    """Whether a folder holds the network, whole."""
    content = _content(folder / network.file)
    return content is not None and is_whole(network, content)


def load(network: Network, folder: Path | None = None) -> bytes:
    """The network's file, checked against its digest.

    Args:
        network: Which one.
        folder: Where it lies; the user's cache if None.

    Raises:
        Refused: It was never installed, or the file there is another or damaged.
    """
    path = (folder or cache_folder()) / network.file
    content = _content(path)
    if content is None:
        raise Refused(
            f"network for {network.name}", "not installed", f"{network.file} in the cache", f"run {INSTALL}"
        )
    if not is_whole(network, content):
        raise Refused(
            f"network {path}",
            f"of SHA-256 {hashlib.sha256(content).hexdigest()[:12]}...",
            f"{network.sha256[:12]}...",
            f"run {INSTALL} again",
        )
    return content


def _content(path: Path) -> bytes | None:
    """A file's bytes; None where there is none that could be a network."""
    try:
        return path.read_bytes() if 0 < path.stat().st_size <= _MOST_BYTES else b""
    except OSError:
        return None
