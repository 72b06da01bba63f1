"""What a recording notes besides the hand: outages, lost captures, pictures and hands that are no good."""

from __future__ import annotations

from rehab_app.cameras import Outage
from rehab_app.recording.pipeline import Seen
from rehab_app.recording.writing import event
from sessions.records import Event

_MOST_SENTENCES = 20


class Noted:
    """Turns what goes wrong into events: once when it begins, once when it is over."""

    def __init__(self) -> None:
        self._outage = ""
        self._trouble = ""
        self._sentences: dict[str, None] = {}

    @property
    def sentences(self) -> tuple[str, ...]:
        """Every different sentence so far, oldest first."""
        return tuple(self._sentences)

    def of(self, seen: Seen) -> tuple[Event, ...]:
        """Events of one instant."""
        t_ns, found = seen.live.t_ns, list[Event]()
        if self._outage:
            self._outage = ""
            found.append(event(t_ns, "camera-back", "The camera gives pictures again.", "info"))
        if seen.instant.dropped:
            text = f"The camera lost {seen.instant.dropped} captures before this one."
            found.append(event(t_ns, "captures-lost", text))
        trouble = seen.live.trouble
        if trouble and trouble != self._trouble:
            self._say(trouble)
            found.append(event(t_ns, "picture" if seen.live.fault else "tracking", trouble))
        self._trouble = trouble
        return tuple(found)

    def of_outage(self, outage: Outage) -> tuple[Event, ...]:
        """Events of a camera that gives nothing: one when that begins or its reason changes."""
        if outage.reason == self._outage:
            return ()
        self._outage = outage.reason
        self._say(outage.reason)
        return (event(outage.t_ns, "outage", outage.reason),)

    def _say(self, sentence: str) -> None:
        if len(self._sentences) < _MOST_SENTENCES:
            self._sentences[sentence] = None
