"""The sentences in which an object store's failures are told."""

from __future__ import annotations

import re
from collections.abc import Generator
from contextlib import contextmanager

from sessions.errors import Refused

_STATUS = re.compile(r"status code: (\d{3})")
_KEPT = "what waits here is kept and goes up when it answers again"


class Unreachable(Refused):
    """The store did not do it now, for a reason that holds for every object: waiting may help."""


class Absent(Refused):
    """The store has no such object."""


@contextmanager
def telling(bucket: str, endpoint: str, key: str) -> Generator[None]:
    """Turn what the client raises into one sentence.

    Args:
        bucket: Bucket that was asked.
        endpoint: Address that was asked.
        key: Object that was asked for.

    Raises:
        Absent: There is no such object.
        Unreachable: The store cannot be reached, has no such bucket, or does not allow it.
    """
    from obstore.exceptions import BaseError

    try:
        yield
    except (BaseError, OSError) as error:
        raise _told(bucket, endpoint, key, error) from error


def corrupted(key: str, met: str, expected: str) -> Refused:
    """An object whose bytes are not those that its name promises."""
    remedy = "send it again from the clinic folder with rehab-app store push, or take the file from a backup"
    return Refused(f"SHA-256 of object {key!r}", met, f"{expected}, as its name says", remedy)


def resized(key: str, met: int, expected: int) -> Refused:
    """An object that is shorter or longer than the file."""
    return Refused(f"object {key!r}", f"{met} bytes", f"{expected} bytes, as the file", "send it again")


def shortened(key: str, met: int, wanted: int) -> Refused:
    """An answer that ended before all bytes had come."""
    return Unreachable(
        f"answer for object {key!r}",
        f"cut short after {met} bytes",
        f"{wanted} bytes",
        "check the network and try again",
    )


def _told(bucket: str, endpoint: str, key: str, error: Exception) -> Refused:
    """One sentence for what the store or the network said; the key of access is never part of it."""
    said, status = str(error), _STATUS.search(str(error))
    name, place = f"bucket {bucket!r}", endpoint or "the region's own address"
    if "NoSuchBucket" in said:
        return Unreachable(name, f"missing at {place}", "there", "make it, or correct store.bucket")
    if any(word in said for word in ("InvalidAccessKeyId", "SignatureDoesNotMatch")):
        remedy = "correct store.access_key and its secret"
        return Unreachable("access key of the object store", f"refused by {place}", "one it knows", remedy)
    if "AccessDenied" in said or (status and status[1] in ("401", "403")):
        remedy = f"give the access key the right to read, write and delete in it; {_KEPT}"
        return Unreachable(name, "closed to this access key", "readable and writable", remedy)
    if isinstance(error, FileNotFoundError):
        remedy = "check the bucket, or send the file again with rehab-app store push"
        return Absent(f"object {key!r}", f"not in {name}", "there", remedy)
    return Unreachable(
        "object store", f"not answering at {place}", "reachable", f"check the network; {_KEPT}"
    )
