"""The one table: topic, record type, version. Units stand at each field's declaration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sessions.records import camera, hand, therapy


@dataclass(frozen=True, slots=True)
class Topic:
    """One stream of a session file.

    Attributes:
        name: Topic name, with its leading slash.
        record: Type of every record on it.
        version: Version of that type's layout.
        schema: Name of the protobuf schema in the file.
        needs_consent: Whether its records are images of people, which only consent admits to a file.
    """

    name: str
    record: type[Any]
    version: int
    schema: str
    needs_consent: bool = False


TRANSFORMS = Topic("/tf", hand.Transforms, 1, "foxglove.FrameTransforms")
MARKERS = Topic("/markers", hand.MarkerFrame, 1, "rehab.MarkerFrame")
HAND_JOINTS = Topic("/hand/joints", hand.JointStates, 1, "foxglove.JointStates")
HAND_POSE = Topic("/hand/pose", hand.HandPose, 1, "rehab.HandPose")
REFERENCE = Topic("/therapy/reference", therapy.ReferencePose, 1, "rehab.ReferencePose")
PATIENT_POSE = Topic("/patient/pose", therapy.PatientPose, 1, "rehab.PatientPose")
PHASE = Topic("/therapy/phase", therapy.TherapyPhase, 1, "rehab.TherapyPhase")
ROBOT_STATE = Topic("/robot/state", therapy.RobotStateBlock, 1, "rehab.RobotStateBlock")
ROBOT_COMMAND = Topic("/robot/command", therapy.RobotCommandBlock, 1, "rehab.RobotCommandBlock")
EVENTS = Topic("/events", therapy.Event, 1, "rehab.Event")
CAMERA_CALIBRATION = Topic("/camera/calibration", camera.CameraCalibration, 1, "foxglove.CameraCalibration")
CAMERA_COLOUR = Topic("/camera/color", camera.ColourImage, 1, "foxglove.CompressedImage", needs_consent=True)
CAMERA_DEPTH = Topic("/camera/depth", camera.DepthImage, 1, "foxglove.RawImage", needs_consent=True)

TOPICS: dict[str, Topic] = {
    topic.name: topic
    for topic in (
        TRANSFORMS,
        MARKERS,
        HAND_JOINTS,
        HAND_POSE,
        REFERENCE,
        PATIENT_POSE,
        PHASE,
        ROBOT_STATE,
        ROBOT_COMMAND,
        EVENTS,
        CAMERA_CALIBRATION,
        CAMERA_COLOUR,
        CAMERA_DEPTH,
    )
}
