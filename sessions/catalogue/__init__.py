"""Who, what and when of a clinic: one SQLite file beside the recordings."""

from sessions.catalogue.catalogue import Catalogue
from sessions.catalogue.records import (
    ROLES,
    Approval,
    AuditRow,
    CameraCalibration,
    Exercise,
    Hand,
    Patient,
    PrescriptionRow,
    Take,
    TherapySession,
    User,
)

__all__ = [
    "ROLES",
    "Approval",
    "AuditRow",
    "CameraCalibration",
    "Catalogue",
    "Exercise",
    "Hand",
    "Patient",
    "PrescriptionRow",
    "Take",
    "TherapySession",
    "User",
]
