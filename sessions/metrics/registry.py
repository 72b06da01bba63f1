"""The one table of metric names: method version, unit, and what the number means in plain words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Definition:
    """One metric.

    Attributes:
        name: Name in files.
        version: Version of the method; it rises when the same file would give another number.
        unit: SI unit, "1" for what has none.
        title: Short heading for a person.
        meaning: One plain sentence.
        exact: Why it needs no interval, empty where a value without one must say why.
    """

    name: str
    version: str
    unit: str
    title: str
    meaning: str
    exact: str = ""


_ROWS = (
    ("fingertip_rmse", "m", "Fingertip error", "How far the fingertip was from the therapist's, on average."),
    ("joint_rmse", "rad", "Joint error", "How far the joint was from the therapist's angle, on average."),
    ("timing_delay", "s", "Behind by", "How late the fingertip was as a whole; negative when it was early."),
    ("timing_warp", "s", "Uneven timing", "By how much single instants were early or late besides."),
    (
        "shape_error",
        "m",
        "Error of shape",
        "How far the path itself was from the therapist's, timing left out.",
    ),
    (
        "offset_error",
        "m",
        "Constant offset",
        "How far the fingertip was beside the therapist's all the time.",
    ),
    ("range_of_motion", "rad", "Range of motion", "Largest less smallest angle that was held for 0.1 s."),
    ("angle_min", "rad", "Smallest angle", "Smallest angle that was held for 0.1 s; flexion is positive."),
    ("angle_max", "rad", "Largest angle", "Largest angle that was held for 0.1 s; flexion is positive."),
    (
        "total_active_motion",
        "rad",
        "Total active motion",
        "Flexion of MCP, PIP and DIP together in the fullest fist, less what is missing to straight.",
    ),
    ("sparc", "1", "Smoothness (SPARC)", "How smooth the fingertip's speed is; nearer to 0 is smoother."),
    ("sparc_floor", "1", "SPARC floor", "What a perfectly smooth movement would score in this measurement."),
    ("ldlj", "1", "Smoothness (log jerk)", "How jerky the fingertip's speed is; nearer to 0 is smoother."),
    (
        "ldlj_floor",
        "1",
        "Log jerk floor",
        "What a perfectly smooth movement would score in this measurement.",
    ),
    ("movement_time", "s", "Movement time", "Time of one opening or closing, from onset to offset."),
    ("peak_speed", "m/s", "Peak speed", "Highest speed of the fingertip relative to the palm."),
    (
        "path_ratio",
        "1",
        "Path ratio",
        "Length of the fingertip's path over the straight line; 1 is straight.",
    ),
    ("repetitions", "1", "Repetitions", "How many times the movement was made."),
    ("repetitions_by_patient", "1", "Started by the patient", "How many repetitions the patient started."),
    ("repetition_rate", "Hz", "Repetition rate", "Repetitions per second, from first to last."),
    ("assistance", "1", "Assistance", "Stiffness of the robot as a multiple of the thesis gains."),
    ("stiffness", "Nm/rad", "Stiffness", "How hard the robot pulled towards the therapist's angle."),
    ("robot_share", "1", "Robot's share", "Part of the mechanical work that the robot did: 1 all, 0 none."),
    ("robot_work", "J", "Robot's work", "Mechanical work that the robot did on the joint."),
    ("returned_work", "J", "Returned work", "Work that the hand did on the robot: effort, recoil or spasm."),
    ("interaction_torque", "Nm", "Interaction torque", "Largest torque between robot and hand."),
    ("dose_time", "s", "Time in movement", "Time spent moving and holding."),
    ("dose_completed", "1", "Dose", "Part of the prescribed repetitions that was completed."),
    (
        "range_share",
        "1",
        "Range over the norm",
        "Range of the joint over the normal range that is named beside it.",
    ),
    (
        "active_motion_share",
        "1",
        "Total active motion over 260 degrees",
        "Total active motion of the finger over that of a normal one.",
    ),
    (
        "extension_lag",
        "rad",
        "Extension lag",
        "What the patient lacks to straight beyond what the joint itself lacks.",
    ),
    (
        "contracture",
        "rad",
        "Passive extension deficit",
        "What the joint lacks to straight even when it is moved by somebody.",
    ),
    (
        "finger_to_palm",
        "m",
        "Finger to palm",
        "Smallest distance of the fingertip to the crease of the palm.",
    ),
    ("aperture", "m", "Aperture", "Largest distance of the tips of thumb and index finger."),
    ("span", "m", "Span", "Largest distance of the tips of thumb and little finger."),
    ("finger_spread", "m", "Spread", "Largest distance of the tips of index and little finger."),
    (
        "kapandji",
        "1",
        "Opposition (Kapandji)",
        "Farthest of ten places that the thumb's tip reached, from landmarks.",
    ),
    (
        "amplitude_decrement",
        "1",
        "Decrement",
        "Part of the first movement's size that was lost by the last; negative where it grew.",
    ),
    ("pauses", "1", "Pauses", "Rests of half a second or more within the repeated movement."),
    ("longest_pause", "s", "Longest pause", "Longest rest within the repeated movement."),
    ("trigger_latency", "s", "Time to start", "Time from the cue to the patient's own start."),
    (
        "assistance_opening",
        "1",
        "Assistance, opening",
        "Stiffness while the finger was to open, in thesis gains.",
    ),
    (
        "assistance_closing",
        "1",
        "Assistance, closing",
        "Stiffness while the finger was to close, in thesis gains.",
    ),
    (
        "work_share",
        "1",
        "Robot's share, recoil taken off",
        "Part of the work that the robot did beside the patient.",
    ),
    ("patient_work", "J", "Patient's work", "Work of the patient along the movement, recoil taken off."),
    (
        "resisting_work",
        "J",
        "Work against the movement",
        "Work of the patient against the movement; negative.",
    ),
    ("stops", "1", "Stops", "How often the session was stopped, by a person or by a safety rule."),
    ("valid_share", "1", "Seen", "Part of the frames in which the marker was measured."),
    ("longest_gap", "s", "Longest gap", "Longest time in which the marker was not measured."),
    ("fit_residual", "m", "Fit residual", "How far the fitted hand is from the markers, rms."),
)

VERSIONS: Mapping[str, str] = {
    "sparc_floor": "3",
    "ldlj": "3",
    "ldlj_floor": "4",
    "robot_share": "4",
    "repetitions": "2",
    "repetition_rate": "2",
    "dose_time": "2",
    **dict.fromkeys(("joint_rmse", "robot_work", "returned_work", "stiffness"), "2"),
    **dict.fromkeys(("sparc", "movement_time", "peak_speed", "path_ratio"), "2"),
    **dict.fromkeys(("aperture", "span"), "3"),
    **dict.fromkeys(("finger_spread", "finger_to_palm", "angle_min"), "2"),
    **dict.fromkeys(("total_active_motion", "active_motion_share"), "2"),
    **dict.fromkeys(("work_share", "patient_work", "resisting_work"), "3"),
}
"""Names whose method is no longer at version 1."""

_COUNTED, _DESCRIBES = "counted", "describes the recording itself"
_EXACT: Mapping[str, str] = {
    **dict.fromkeys(
        ("repetitions", "repetitions_by_patient", "stops", "pauses", "dose_time", "dose_completed"), _COUNTED
    ),
    **dict.fromkeys(("valid_share", "longest_gap", "fit_residual"), _DESCRIBES),
    **dict.fromkeys(("assistance", "assistance_opening", "assistance_closing", "stiffness"), "commanded"),
}
"""Numbers that carry no error of measurement, and why."""

DEFINITIONS: Mapping[str, Definition] = {
    name: Definition(name, VERSIONS.get(name, "1"), unit, title, meaning, _EXACT.get(name, ""))
    for name, unit, title, meaning in _ROWS
}


def definition(name: str) -> Definition:
    """The definition of a metric.

    Raises:
        KeyError: No metric has that name.
    """
    return DEFINITIONS[name]
