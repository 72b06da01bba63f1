"""The thread of the server that keeps the object store up with what was sealed."""

from __future__ import annotations

import random
import threading
from collections.abc import Callable

from rehab_app.access import CONSOLE
from rehab_app.errors import Refused
from rehab_app.services.uploads import Uploads

_REST_S = 20.0
_FIRST_WAIT_S = 2.0
_LONGEST_WAIT_S = 600.0
_LAST_WAIT_S = 2.0


class UploadWorker:
    """Pushes now and then; after a failure it waits, longer each time, and by chance a little less.

    Args:
        uploads: What it pushes.
        rng: Source of the chance that keeps several stations from knocking at the same moment.
        told: Given each outcome: whether it went well, and the sentence if not.
    """

    def __init__(
        self,
        uploads: Uploads,
        rng: random.Random,
        told: Callable[[bool, str], None] | None = None,
    ) -> None:
        self._uploads = uploads
        self._rng = rng
        self._told = told
        self._end = threading.Event()
        self._failures = 0
        self._thread = threading.Thread(target=self._work, name="object store", daemon=True)

    def start(self) -> None:
        """Begin, where there is an object store."""
        if self._uploads.configured:
            self._thread.start()

    def close(self) -> None:
        """End; an upload that takes longer ends with the process and is done again at the next start."""
        self._end.set()
        if self._thread.is_alive():
            self._thread.join(_LAST_WAIT_S)

    def step(self) -> float:
        """One pass; how long to wait before the next, in s."""
        try:
            self._uploads.push(CONSOLE)
        except (Refused, OSError) as error:
            self._failures += 1
            self._tell(False, str(error))
            return wait_s(self._failures, self._rng)
        self._failures = 0
        self._tell(True, "")
        return _REST_S

    def _tell(self, good: bool, sentence: str) -> None:
        if self._told is not None:
            self._told(good, sentence)

    def _work(self) -> None:
        while not self._end.wait(self.step()):
            pass


def wait_s(failures: int, rng: random.Random) -> float:
    """How long to wait after so many failures in a row, in s: doubling, bounded, with jitter.

    Args:
        failures: 1 or more.
        rng: Chance; the wait lies between half and all of the doubled time.
    """
    longest = min(_FIRST_WAIT_S * 2.0 ** min(failures - 1, 30), _LONGEST_WAIT_S)
    return longest * rng.uniform(0.5, 1.0)
