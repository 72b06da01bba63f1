"""The viewports of a running clinic: started when somebody first looks."""

from __future__ import annotations

import threading

from rehab_app.services.clinic import Clinic
from rehab_app.web.language import spoken
from rehab_app.web.viewport import LiveViewport, ReviewViewports


class Screens:
    """The live viewports, one for each language that is asked for, and those of reviews.

    Args:
        clinic: The clinic.
    """

    def __init__(self, clinic: Clinic) -> None:
        self._clinic = clinic
        self._starting = threading.Lock()
        self._live: dict[str, LiveViewport] = {}
        self._reviews: ReviewViewports | None = None

    def live_port(self) -> int:
        """Loopback port of the live picture."""
        with self._starting:
            language = spoken()
            if language not in self._live:
                self._live[language] = LiveViewport(self._clinic)
            return self._live[language].port

    def review_port(self, recording: str) -> int:
        """Loopback port of the picture that replays a recording.

        Raises:
            Refused: There is no such recording, or it is damaged.
        """
        with self._starting:
            if self._reviews is None:
                self._reviews = ReviewViewports(self._clinic)
            return self._reviews.port_for(recording)

    def close(self) -> None:
        """End them all."""
        with self._starting:
            while self._live:
                self._live.popitem()[1].close()
            if self._reviews is not None:
                self._reviews.close()
            self._reviews = None
