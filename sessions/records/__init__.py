"""Frozen record types, the vocabulary of the hand, and the table of topics."""

from sessions.records.camera import CameraCalibration, ColourImage, DepthImage
from sessions.records.fields import ROWS, Column, columns_of
from sessions.records.hand import HandPose, JointStates, MarkerFrame, Status, Transforms
from sessions.records.header import FORMAT_VERSION, SessionHeader
from sessions.records.names import (
    DIGITS,
    FINGERS,
    FINGERTIPS,
    FRAMES,
    JOINTS,
    LANDMARKS,
    PALM_LANDMARKS,
    SIDES,
    Side,
    digit_of,
)
from sessions.records.therapy import (
    Event,
    PatientPose,
    ReferencePose,
    RobotCommandBlock,
    RobotStateBlock,
    TherapyPhase,
)
from sessions.records.topics import TOPICS, Topic

__all__ = [
    "DIGITS",
    "FINGERS",
    "FINGERTIPS",
    "FORMAT_VERSION",
    "FRAMES",
    "JOINTS",
    "LANDMARKS",
    "PALM_LANDMARKS",
    "ROWS",
    "SIDES",
    "TOPICS",
    "CameraCalibration",
    "ColourImage",
    "Column",
    "DepthImage",
    "Event",
    "HandPose",
    "JointStates",
    "MarkerFrame",
    "PatientPose",
    "ReferencePose",
    "RobotCommandBlock",
    "RobotStateBlock",
    "SessionHeader",
    "Side",
    "Status",
    "TherapyPhase",
    "Topic",
    "Transforms",
    "columns_of",
    "digit_of",
]
