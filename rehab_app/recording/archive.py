"""NumPy archives from elsewhere: plain numbers and texts only, sizes checked before anything is unpacked."""

from __future__ import annotations

import math
import tokenize
import zipfile
import zlib
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from sessions.errors import Refused
from sessions.records.fields import Float64

MOST_BYTES = 256 << 20
"""Largest sum of unpacked arrays."""


class Archive:
    """The arrays of one ``.npz``.

    Args:
        path: The file.

    Raises:
        Refused: It is no whole archive, is too large, or holds something else than numbers and texts.
    """

    def __init__(self, path: Path) -> None:
        self.thing = f"recording {path.name}"
        self._arrays = _arrays(path, self.thing)

    def __contains__(self, name: str) -> bool:
        """Whether there is an array of that name."""
        return name in self._arrays

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the arrays, sorted."""
        return tuple(sorted(self._arrays))

    def numbers(self, name: str) -> Float64:
        """An array as float64.

        Raises:
            Refused: There is none of that name, or it holds texts.
        """
        array = self._named(name)
        if array.dtype.kind not in "fiub":
            raise Refused(f"{self.thing}, {name}", "of texts", "of real numbers", "save numbers")
        return array.astype(np.float64)

    def texts(self, name: str) -> tuple[str, ...]:
        """A flat array of texts.

        Raises:
            Refused: There is none of that name, or it holds numbers.
        """
        array = self._named(name)
        if array.dtype.kind not in "US" or array.ndim > 1:
            raise Refused(f"{self.thing}, {name}", f"of {array.dtype}", "a list of texts", "save names")
        return tuple(
            item.decode("utf-8", "replace") if isinstance(item, bytes) else str(item)
            for item in np.atleast_1d(array).tolist()
        )

    def _named(self, name: str) -> NDArray[Any]:
        if name not in self._arrays:
            held = ", ".join(self.names) or "nothing"
            raise Refused(self.thing, f"holding {held}", f"with {name}", f"add {name}")
        return self._arrays[name]


def _arrays(path: Path, thing: str) -> dict[str, NDArray[Any]]:
    try:
        with zipfile.ZipFile(path) as archive:
            members = [item for item in archive.infolist() if item.filename.endswith(".npy")]
            total = sum(item.file_size for item in members)
            if total > MOST_BYTES:
                raise Refused(
                    thing, f"of {total} bytes", f"at most {MOST_BYTES} bytes", "export a part of it"
                )
            arrays: dict[str, NDArray[Any]] = {}
            for item in members:
                name = item.filename.removesuffix(".npy")
                with archive.open(item) as stream:
                    arrays[name] = _array(f"{thing}, {name}", stream, item.file_size)
            return arrays
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, RuntimeError) as error:
        raise Refused(thing, "no whole .npz", "a NumPy archive", "save it again with numpy.savez") from error


def _array(thing: str, stream: IO[bytes], size: int) -> NDArray[Any]:
    """One array; its header must agree with the bytes that follow it."""
    try:
        version = np.lib.format.read_magic(stream)
        if version == (1, 0):
            shape, fortran, kind = np.lib.format.read_array_header_1_0(stream)
        else:
            shape, fortran, kind = np.lib.format.read_array_header_2_0(stream)
    except (ValueError, EOFError, SyntaxError, tokenize.TokenError) as error:
        raise Refused(thing, "unreadable", "a plain NumPy array", "save it again") from error
    if kind.kind not in "fiubUS":
        raise Refused(
            thing, f"of kind {kind} (a pickle is never opened)", "numbers or texts", "save it as such"
        )
    count = math.prod(shape)
    if not 0 <= count * kind.itemsize <= size:
        raise Refused(thing, f"stating shape {shape}", f"{size} bytes of numbers", "save it again")
    raw = stream.read(count * kind.itemsize)
    if len(raw) != count * kind.itemsize:
        raise Refused(thing, "cut short", "whole", "save it again")
    return np.frombuffer(raw, dtype=kind).reshape(shape, order="F" if fortran else "C")
