"""Sign-ins that the server remembers: ended everywhere at once, held for ten hours, covered when idle."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from rehab_app.errors import NoAnswer, Refused
from sessions.catalogue import Catalogue, Setting

LIFETIME_S = 10 * 3600
IDLE_KEY = "idle-lock-s"
IDLE_S = 15 * 60
SHORTEST_IDLE_S, LONGEST_IDLE_S = 60, 3600
_SECOND_NS = 1_000_000_000
_FRESH_NS = 2 * _SECOND_NS  # how long the catalogue is not asked again; another process may have ended it
_SEEN_NS = 60 * _SECOND_NS  # use is written to the minute: a write a click would be an fsync a click
_MOST = 1024


@dataclass(frozen=True, slots=True)
class Presence:
    """A sign-in that holds.

    Attributes:
        user: Whose.
        idle_s: How long nobody has used it.
        locked: Whether that is too long, so that the password is asked for again.
    """

    user: str
    idle_s: float
    locked: bool


@dataclass(slots=True)
class _Known:
    user: str
    issued_ns: int
    seen_ns: int
    written_ns: int
    ended: bool
    read_ns: int


class SignIns:
    """Sign-ins by the SHA-256 of their secret. Thread-safe.

    Args:
        catalogue: The clinic's catalogue.
        clock_ns: UTC in ns.
    """

    def __init__(self, catalogue: Catalogue, clock_ns: Callable[[], int] = time.time_ns) -> None:
        self._catalogue = catalogue
        self._clock_ns = clock_ns
        self._known: dict[str, _Known] = {}
        self._lock = threading.Lock()
        self._idle: tuple[int, int] = (0, 0)

    def begin(self, user: str, digest: str) -> None:
        """Remember a new sign-in."""
        now_ns = self._clock_ns()
        self._catalogue.forget_sign_ins(now_ns - 2 * LIFETIME_S * _SECOND_NS)
        self._catalogue.add_sign_in(digest, user)
        with self._lock:
            self._known[digest] = _Known(user, now_ns, now_ns, now_ns, ended=False, read_ns=now_ns)

    def look(self, user: str, digest: str) -> Presence | None:
        """The sign-in, None where it is unknown, ended, expired, or somebody else's."""
        now_ns = self._clock_ns()
        known = self._fresh(digest, now_ns)
        if known is None or known.ended or known.user != user:
            return None
        if not 0 <= now_ns - known.issued_ns < LIFETIME_S * _SECOND_NS:
            return None
        idle_s = max(0, now_ns - known.seen_ns) / _SECOND_NS
        return Presence(user, idle_s, idle_s >= self.idle_s())

    def touch(self, digest: str) -> None:
        """Somebody used it now."""
        now_ns = self._clock_ns()
        with self._lock:
            known = self._known.get(digest)
            if known is None:
                return
            known.seen_ns = now_ns
            write = now_ns - known.written_ns >= _SEEN_NS
            if write:
                known.written_ns = now_ns
        if write:
            self._catalogue.see_sign_in(digest)

    def end(self, user: str, digest: str) -> None:
        """End one."""
        self._catalogue.end_sign_ins(user, digest)
        with self._lock:
            self._known.pop(digest, None)

    def end_all(self, user: str) -> None:
        """End all of a user, wherever they are."""
        self._catalogue.end_sign_ins(user)
        with self._lock:
            self._known = {key: one for key, one in self._known.items() if one.user != user}

    def idle_s(self) -> int:
        """Seconds without use after which a page is covered."""
        now_ns = self._clock_ns()
        value, read_ns = self._idle
        if value and now_ns - read_ns < 5 * _FRESH_NS:
            return value
        try:
            kept = self._catalogue.setting(IDLE_KEY)
        except NoAnswer:  # somebody who is here goes on as before
            return value or IDLE_S
        value = IDLE_S if kept is None else int(json.loads(kept.content))
        self._idle = (value, now_ns)
        return value

    def set_idle_s(self, seconds: int, by: str) -> None:
        """Change it.

        Raises:
            Refused: It is out of bounds.
        """
        if not SHORTEST_IDLE_S <= seconds <= LONGEST_IDLE_S:
            bound = f"{SHORTEST_IDLE_S // 60} to {LONGEST_IDLE_S // 60} minutes"
            raise Refused("idle lock", f"{seconds / 60:g} minutes", bound, "choose within it")
        self._catalogue.set(Setting(key=IDLE_KEY, content=json.dumps(seconds), by=by))
        self._idle = (seconds, self._clock_ns())

    def _fresh(self, digest: str, now_ns: int) -> _Known | None:
        with self._lock:
            known = self._known.get(digest)
            if known is not None and 0 <= now_ns - known.read_ns < _FRESH_NS:
                return known
        try:
            kept = self._catalogue.sign_in(digest)
        except NoAnswer:
            if known is None:
                raise
            return known
        with self._lock:
            if kept is None:
                self._known.pop(digest, None)
                return None
            seen_ns = max(kept.seen_utc_ns, known.seen_ns if known else 0)
            ended = kept.ended_utc_ns != 0
            fresh = _Known(kept.user, kept.issued_utc_ns, seen_ns, kept.seen_utc_ns, ended, now_ns)
            if len(self._known) >= _MOST:
                self._known.clear()
            self._known[digest] = fresh
            return fresh
