"""Trajectories out of a recording: detections, a video or an RGB-D session to a take or plain arrays."""

from __future__ import annotations

from rehab_app.recording.markerless import asks_for_bare_hand, track_bare_hand
from rehab_app.recording.progress import Progress, untold
from rehab_app.recording.track_frames import track_frames
from rehab_app.recording.track_order import TrackOrder, TrackResult
from rehab_app.recording.track_points import track_points

POINTS_SUFFIX = ".npz"


def track(order: TrackOrder, progress: Progress = untold) -> TrackResult:
    """Track a recording; the file is whole or absent.

    Raises:
        Refused: The recording cannot be tracked; one sentence says why.
    """
    if order.inputs[0].suffix.lower() == POINTS_SUFFIX:
        return track_points(order, progress)
    if asks_for_bare_hand(order):
        return track_bare_hand(order, progress)
    return track_frames(order, progress)
