"""Tracking: names for detections, capture after capture, by a model of the hand."""

from rehab_app.tracking.kinematic import KinematicTracker
from rehab_app.tracking.tracked import TrackedHand, Tracker, TrackingState

__all__ = ["KinematicTracker", "TrackedHand", "Tracker", "TrackingState"]
