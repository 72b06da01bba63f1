"""Tracking: names for detections, capture after capture."""

from rehab_app.tracking.choice import TRACKERS, TrackerName, make_tracker
from rehab_app.tracking.kinematic import KinematicTracker
from rehab_app.tracking.tracked import Labels, TrackedHand, Tracker, TrackingState

__all__ = [
    "TRACKERS",
    "KinematicTracker",
    "Labels",
    "TrackedHand",
    "Tracker",
    "TrackerName",
    "TrackingState",
    "make_tracker",
]
