"""The latched stop of the live desk: pressed without a lock, released by who looked at the patient."""

from __future__ import annotations

import threading

from rehab_app.errors import Refused

REST_WAIT_S = 5.0


class StopLatch:
    """Holds that stop was pressed, and by whom: single attribute accesses, so pressing waits for nothing.

    Attributes:
        source: Who or what pressed it, "" while it is released.
    """

    def __init__(self) -> None:
        self.source = ""
        self._pressed = object()

    def press(self, source: str) -> None:
        """Latch it, also where it is latched already: a release that is going on then fails."""
        self._pressed = object()
        self.source = source

    def take(self, cause: str) -> bool:
        """The supervisor stopped by itself; a stop that a person pressed keeps its name.

        Returns:
            Whether the cause is what it is named by now.
        """
        before = self.source
        if before and not cause.startswith(before):
            return False
        self.source = cause
        return True

    def release(self, run: threading.Thread | None) -> None:
        """Release it; waits a few seconds for a run that is still braking and being sealed.

        Args:
            run: The thread of the last run.

        Raises:
            Refused: It is still braking, or stop was pressed anew meanwhile.
        """
        pressed = self._pressed
        if run is not None:
            run.join(REST_WAIT_S)
            if run.is_alive():
                remedy = "the recording is being sealed, try again in a few seconds"
                raise Refused("stop", "still braking and sealing", "at rest", remedy)
        if self._pressed is not pressed:
            raise Refused("stop", "pressed anew", "pressed once", "look at the patient again, then clear it")
        self.source = ""
