"""One verb for both kinds of file."""

from __future__ import annotations

from sessions.metrics.recording import Recording
from sessions.metrics.summary import Summary
from sessions.metrics.take import measure_take
from sessions.metrics.therapy import measure_therapy


def measure(recording: Recording) -> Summary:
    """All numbers of an opened file, by the kind that its header names.

    Args:
        recording: An opened file; ``measure_file`` opens one.

    Raises:
        Refused: The file lacks what its kind needs.
    """
    return measure_take(recording) if recording.header.kind == "take" else measure_therapy(recording)
