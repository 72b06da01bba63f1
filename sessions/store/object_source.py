"""A sealed session in an object store, read in place: only the blocks that the index leads to."""

from __future__ import annotations

import hashlib
import os
from collections import OrderedDict
from itertools import groupby
from pathlib import Path

from sessions.store.container import Source
from sessions.store.diskfile import digest_path, sync_folder
from sessions.store.object_store import ObjectStore
from sessions.store.object_trouble import corrupted
from sessions.store.reader import SessionReader

BLOCK_BYTES = 256 * 1024
BLOCKS_KEPT = 64
_TAIL_SHARE = 100
_TAIL_BLOCKS_MAX = 16
"""Index and overview lie at the end: whoever asks for the last block gets a hundredth of the file."""


class ObjectSource(Source):
    """The bytes of one object, fetched in blocks of which the last used are kept.

    Args:
        store: The store.
        key: The object.
        block_bytes: Length of a block; a request fetches whole blocks.
        blocks_kept: How many blocks are kept.

    Attributes:
        size: Length of the object in bytes.
        fetched_bytes: How many bytes came over the network so far.
        requests: In how many requests.

    Raises:
        Refused: There is no such object, or the store does not answer.
    """

    def __init__(
        self, store: ObjectStore, key: str, block_bytes: int = BLOCK_BYTES, blocks_kept: int = BLOCKS_KEPT
    ) -> None:
        self._descriptor = -1
        self._store = store
        self._key = key
        self._block_bytes = block_bytes
        self._blocks_kept = blocks_kept
        self._blocks: OrderedDict[int, bytes] = OrderedDict()
        self.size = store.length(key)
        self.fetched_bytes = 0
        self.requests = 0
        self._tail = (self.size - 1) // block_bytes

    def close(self) -> None:
        """Forget the blocks."""
        self._blocks.clear()

    def _bytes(self, start: int, length: int) -> bytes:
        if length == 0:
            return b""
        first, last = start // self._block_bytes, (start + length - 1) // self._block_bytes
        if last == self._tail and last not in self._blocks:
            blocks = self.size // self._block_bytes // _TAIL_SHARE
            self._gathered(
                range(max(0, last - min(blocks, _TAIL_BLOCKS_MAX, self._blocks_kept - 1)), last + 1)
            )
        found = self._gathered(range(first, last + 1))
        begin = start - first * self._block_bytes
        return found[begin : begin + length]

    def _gathered(self, wanted: range) -> bytes:
        """Blocks in a row; neighbours that are missing come in one request."""
        held = {index: self._blocks[index] for index in wanted if index in self._blocks}
        missing = (index for index in wanted if index not in held)
        for _, group in groupby(enumerate(missing), lambda pair: pair[1] - pair[0]):
            run = [index for _, index in group]
            held |= self._fetched(run[0], run[-1])
        for index in wanted:
            self._blocks[index] = held[index]
            self._blocks.move_to_end(index)
        while len(self._blocks) > self._blocks_kept:
            self._blocks.popitem(last=False)
        return b"".join(held[index] for index in wanted)

    def _fetched(self, first: int, last: int) -> dict[int, bytes]:
        start = first * self._block_bytes
        data = self._store.read(self._key, start, min((last + 1) * self._block_bytes, self.size) - start)
        self.requests += 1
        self.fetched_bytes += len(data)
        size = self._block_bytes
        return {first + at: data[at * size : (at + 1) * size] for at in range(last - first + 1)}


def open_object(store: ObjectStore, key: str, path: Path) -> SessionReader:
    """A sealed session in the store as a reader; only what is asked for is fetched.

    Every chunk is proven by the CRC in it, the index by its own; the digest of the whole is proven by
    ``fetch_object``.

    Args:
        store: The store.
        key: The object.
        path: Name of the file that it is a copy of, for sentences.

    Raises:
        Refused: There is no such object, the store does not answer, or it is no sealed session.
    """
    return SessionReader(path, ObjectSource(store, key))


def fetch_object(store: ObjectStore, key: str, sha256: str, path: Path) -> int:
    """Bring an object back as a file with its digest beside it; the file is whole and proven, or absent.

    Args:
        store: The store.
        key: The object.
        sha256: Digest that its bytes must have.
        path: Where to put it.

    Returns:
        Its length in bytes.

    Raises:
        Refused: There is no such object, the store does not answer, or its bytes have another digest.
        OSError: The disk refuses.
    """
    working = path.with_name(f".{path.name}.fetching")
    digest = hashlib.sha256()
    try:
        with working.open("wb") as file:
            for chunk in store.chunks(key):
                digest.update(chunk)
                file.write(chunk)
            file.flush()
            os.fsync(file.fileno())
            length = file.tell()
        if digest.hexdigest() != sha256:
            raise corrupted(key, digest.hexdigest(), sha256)
        beside = digest_path(path)
        if not beside.exists():
            beside.write_text(f"{sha256}  {path.name}\n", encoding="utf-8")
        working.replace(path)
    finally:
        working.unlink(missing_ok=True)
    sync_folder(path.parent)
    return length
