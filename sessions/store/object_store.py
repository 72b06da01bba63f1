"""An S3-compatible object store that holds sealed files under the digest of their bytes."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path
from typing import Any

from sessions.errors import Refused
from sessions.store.object_trouble import Absent, corrupted, resized, shortened, telling

_SINGLE_BYTES_MAX = 8 * 1024 * 1024
"""Up to here one request, which the store refuses where the object is there; above, parts of this size."""
_PIECE_BYTES = 4 * 1024 * 1024
"""Whole objects come in pieces of this size, each a request with a time limit and repeats of its own."""
_PARTS_AT_ONCE = 2
_RETRIES = 2
_CONNECT_S = 5.0


@dataclass(frozen=True, slots=True)
class ObjectPlace:
    """Where objects lie and how they are reached.

    Attributes:
        bucket: Name of the bucket.
        prefix: What every key begins with, without slashes at its ends; "" for none.
        endpoint: Address of the service, "" for that of the region.
        region: Region that requests are signed for.
        access_key: Name of the access key, "" for that of the environment.
        secret_key: Its secret.
        timeout_s: Longest wait for one answer.
        retries: How often one request is repeated before it is given up.
    """

    bucket: str
    prefix: str = ""
    endpoint: str = ""
    region: str = "us-east-1"
    access_key: str = ""
    secret_key: str = field(default="", repr=False)
    timeout_s: float = 30.0
    retries: int = _RETRIES

    def key(self, kind: str, sha256: str) -> str:
        """Key of a sealed file: its kind and its digest, and nothing about a person.

        Args:
            kind: "sessions" or "takes".
            sha256: Digest of the file, hexadecimal.
        """
        return "/".join(part for part in (self.prefix.strip("/"), kind, f"{sha256}.mcap") if part)


class ObjectStore:
    """Puts, proves, reads and deletes objects.

    Args:
        place: Where they lie.

    Raises:
        Refused: The client is not installed, or the place makes no sense to it.
    """

    def __init__(self, place: ObjectPlace) -> None:
        self.place = place
        self._store = _client(place)

    def put(self, path: Path, key: str) -> None:
        """Send a file; one that is there already stays as it is.

        Raises:
            Unreachable: The store does not take it.
            Refused: The file cannot be read.
        """
        import obstore
        from obstore.exceptions import AlreadyExistsError, PreconditionError

        length = _length(path)
        whole = length <= _SINGLE_BYTES_MAX
        with self._telling(key):
            try:
                if whole:
                    obstore.put(self._store, key, path, mode="create", use_multipart=False)
                else:
                    obstore.put(
                        self._store,
                        key,
                        path,
                        chunk_size=_SINGLE_BYTES_MAX,
                        max_concurrency=_PARTS_AT_ONCE,
                    )
            except (AlreadyExistsError, PreconditionError):
                return

    def replace(self, path: Path, key: str) -> None:
        """Send a file over an object that proved to be corrupted.

        Raises:
            Unreachable: The store does not take it.
        """
        import obstore

        with self._telling(key):
            obstore.put(self._store, key, path, chunk_size=_SINGLE_BYTES_MAX, max_concurrency=_PARTS_AT_ONCE)

    def size(self, key: str) -> int | None:
        """Length of an object in bytes, None where there is none.

        Raises:
            Unreachable: The store does not answer.
        """
        import obstore

        try:
            with self._telling(key):
                return int(obstore.head(self._store, key)["size"])
        except Absent:
            return None

    def length(self, key: str) -> int:
        """Length of an object that must be there, in bytes.

        Raises:
            Absent: There is no such object.
            Unreachable: The store does not answer.
        """
        met = self.size(key)
        if met is None:
            remedy = "check the bucket, or send the file again with rehab-app store push"
            raise Absent(f"object {key!r}", f"not in bucket {self.place.bucket!r}", "there", remedy)
        return met

    def read(self, key: str, start: int, length: int) -> bytes:
        """Exactly these bytes of an object.

        Raises:
            Absent: There is no such object.
            Unreachable: The store does not answer, or not with all bytes.
        """
        import obstore

        with self._telling(key):
            data = bytes(obstore.get_range(self._store, key, start=start, length=length))
        if len(data) != length:
            raise shortened(key, len(data), length)
        return data

    def chunks(self, key: str) -> Iterator[bytes]:
        """The whole object, some megabytes at a time.

        Raises:
            Absent: There is no such object.
            Unreachable: The store does not answer, or not with all bytes.
        """
        length = self.length(key)
        for start in range(0, length, _PIECE_BYTES):
            yield self.read(key, start, min(_PIECE_BYTES, length - start))

    def prove(self, key: str, sha256: str, length: int) -> None:
        """Read an object again and compare it with its file.

        Args:
            key: Object.
            sha256: Digest of the file.
            length: Its length in bytes.

        Raises:
            Absent: There is no such object.
            Unreachable: The store does not answer.
            Refused: It is another length, or its bytes have another digest.
        """
        met = self.length(key)
        if met != length:
            raise resized(key, met, length)
        digest = hashlib.sha256()
        for chunk in self.chunks(key):
            digest.update(chunk)
        if digest.hexdigest() != sha256:
            raise corrupted(key, digest.hexdigest(), sha256)

    def delete(self, key: str) -> None:
        """Delete an object; one that is not there is deleted already.

        Raises:
            Unreachable: The store does not do it.
        """
        import obstore

        try:
            with self._telling(key):
                obstore.delete(self._store, key)
        except Absent:
            return

    def _telling(self, key: str) -> Any:
        return telling(self.place.bucket, self.place.endpoint, key)


def _length(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError as error:
        why = (error.strerror or str(error)).lower()
        raise Refused(f"file {path.name!r}", f"not readable ({why})", "a sealed file", "check it") from error


def _client(place: ObjectPlace) -> Any:
    try:
        from obstore.exceptions import BaseError
        from obstore.store import S3Store
    except ImportError as error:
        raise Refused(
            "object store", "not available", "installed", "install rehab-app with the extra s3"
        ) from error
    named = {"access_key_id": place.access_key, "secret_access_key": place.secret_key}
    known: dict[str, Any] = {name: value for name, value in named.items() if value}
    if place.endpoint:
        known |= {"endpoint": place.endpoint, "virtual_hosted_style_request": False}
    try:
        return S3Store(
            place.bucket,
            region=place.region,
            client_options={
                "allow_http": place.endpoint.startswith("http://"),
                "timeout": timedelta(seconds=max(place.timeout_s, 0.1)),
                "connect_timeout": timedelta(seconds=min(place.timeout_s, _CONNECT_S)),
            },
            retry_config={
                "max_retries": place.retries,
                "retry_timeout": timedelta(seconds=2.0 * place.timeout_s),
            },
            **known,
        )
    except (BaseError, ValueError) as error:
        raise Refused("settings of the object store", str(error), "usable", "correct [store]") from error
