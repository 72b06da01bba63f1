"""Who, what and when of a clinic: one SQLite file beside the recordings."""

from sessions.catalogue.audit_filter import AuditFilter
from sessions.catalogue.catalogue import Catalogue
from sessions.catalogue.clinic_records import ENTRY_KINDS, PatientEntry, Setting, SignIn
from sessions.catalogue.clinical_records import (
    MAS_GRADES,
    RANGE_HIGH,
    RANGE_LOW,
    TORQUE_LIMIT,
    AssistanceMemory,
    ClinicalRecord,
    DayLimits,
    FitCheck,
    LimitChange,
    LimitsRead,
    ModeUnlock,
)
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
from sessions.catalogue.stations_records import ClockTrip, PatientClaim, Station
from sessions.catalogue.take_filter import TakeFilter, TakeWord

__all__ = [
    "ENTRY_KINDS",
    "MAS_GRADES",
    "RANGE_HIGH",
    "RANGE_LOW",
    "ROLES",
    "TORQUE_LIMIT",
    "Approval",
    "AssistanceMemory",
    "AuditFilter",
    "AuditRow",
    "CameraCalibration",
    "Catalogue",
    "ClinicalRecord",
    "ClockTrip",
    "DayLimits",
    "Exercise",
    "FitCheck",
    "Hand",
    "LimitChange",
    "LimitsRead",
    "ModeUnlock",
    "Patient",
    "PatientClaim",
    "PatientEntry",
    "PrescriptionRow",
    "Setting",
    "SignIn",
    "Station",
    "Take",
    "TakeFilter",
    "TakeWord",
    "TherapySession",
    "User",
]
