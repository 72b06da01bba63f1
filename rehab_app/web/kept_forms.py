"""Forms that were sent after the sign-in had ended: kept for their sender, so that nothing typed is lost."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

_KEEP_S = 30 * 60.0
_MOST = 64
_SECRETS = ("password", "passphrase")
_TOKEN = "form_token"


@dataclass(frozen=True, slots=True)
class KeptForm:
    """A form that waits for its sender.

    Attributes:
        name: Account whose sign-in had ended; nobody else gets it.
        path: Where it was sent.
        back: Page that it came from.
        fields: What was typed.
    """

    name: str
    path: str
    back: str
    fields: tuple[tuple[str, str], ...]


class KeptForms:
    """Keeps forms in memory for half an hour, by a secret that only the sender's browser holds.

    Args:
        now_s: Monotonic clock, s.
    """

    def __init__(self, now_s: Callable[[], float] = time.monotonic) -> None:
        self._now_s = now_s
        self._forms: dict[str, tuple[float, KeptForm]] = {}
        self._lock = threading.Lock()

    def keep(self, name: str, path: str, back: str, sent: Mapping[str, str]) -> str:
        """Keep a form; a form with a password in it, or with nothing in it, is not kept.

        Returns:
            The secret that gives it back, "" where nothing was kept.
        """
        fields = tuple((key, value) for key, value in sent.items() if key != _TOKEN)
        secret = any(part in key.lower() for key, _ in fields for part in _SECRETS)
        if not name or secret or not any(value.strip() for _, value in fields):
            return ""
        key = secrets.token_urlsafe(32)
        with self._lock:
            self._forget_old()
            self._forms[key] = (self._now_s(), KeptForm(name, path, back, fields))
        return key

    def find(self, key: str, name: str) -> KeptForm | None:
        """What is kept under a secret for this account."""
        with self._lock:
            self._forget_old()
            held = self._forms.get(key)
        return held[1] if held is not None and held[1].name == name else None

    def drop(self, key: str) -> None:
        """Forget one: it was sent, or its sender does not want it."""
        with self._lock:
            self._forms.pop(key, None)

    def _forget_old(self) -> None:
        oldest_s = self._now_s() - _KEEP_S
        kept = [(key, held) for key, held in self._forms.items() if held[0] > oldest_s]
        self._forms = dict(kept[-_MOST:])
