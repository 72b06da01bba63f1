"""One verb for both kinds of file."""

from __future__ import annotations

from sessions.metrics.recording import Recording
from sessions.metrics.separated import PassiveRun
from sessions.metrics.summary import Summary
from sessions.metrics.take import measure_take
from sessions.metrics.therapy import measure_therapy


def measure(recording: Recording, passive: PassiveRun | None = None) -> Summary:
    """All numbers of an opened file, by the kind that its header names.

    Args:
        recording: An opened file; ``measure_file`` opens one.
        passive: A passive run that is taken off a therapy session; None for the session's own.

    Raises:
        Refused: The file lacks what its kind needs.
    """
    if recording.header.kind == "take":
        return measure_take(recording)
    return measure_therapy(recording, passive)
