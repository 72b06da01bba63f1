"""Writes what the motion process reports into a session file."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from rehab_app.therapy.run_causes import sentence_of
from rehab_app.therapy.run_poses import Poses, RunHand
from robot_iface.types import (
    DIGITS,
    LANDMARKS,
    Float64,
    Int64,
    PhaseChange,
    SafetyEvent,
    SafetyState,
    TickBlock,
)
from sessions.records import (
    Event,
    PatientPose,
    ReferencePose,
    RobotCommandBlock,
    RobotStateBlock,
    TherapyPhase,
    Transforms,
    digit_of,
)
from sessions.records.topics import (
    EVENTS,
    PATIENT_POSE,
    PHASE,
    REFERENCE,
    ROBOT_COMMAND,
    ROBOT_STATE,
    TRANSFORMS,
    Topic,
)

Message: TypeAlias = TickBlock | PhaseChange | SafetyEvent
Write: TypeAlias = Callable[[Topic, object], None]

POSE_PERIOD_NS = 10_000_000  # 100 Hz
TRANSFORM_PERIOD_NS = 34_000_000  # at most 30 Hz
_UNAIDED = ("transparent", "resistive")  # here the robot neither starts nor helps


class RunRecorder:
    """Turns messages of the motion process into records.

    Args:
        write: Takes a topic and its record (``SessionWriter.write``).
        hand: What moves: the patient's hand in the robot, or a robot that nobody wears.
        driven_joints: Names of the driven joints, in the order of the blocks.
        mode: Therapy mode, for the phase rows.
        follows: Whether there is a reference; a guided sweep has none.
    """

    def __init__(
        self,
        write: Write,
        hand: RunHand,
        driven_joints: tuple[str, ...],
        mode: str,
        *,
        follows: bool = True,
    ) -> None:
        self._follows = follows
        self._write = write
        self._hand = hand
        self._digit = np.array([DIGITS.index(digit_of(joint)) for joint in driven_joints])
        self._mode = mode
        self._next_pose_ns: int | None = None
        self._next_transform_ns = 0

    def take(self, message: Message) -> None:
        """Write one message."""
        if isinstance(message, TickBlock):
            self._block(message)
        elif isinstance(message, PhaseChange):
            self._phase(message)
        else:
            self._event(message)

    def _block(self, block: TickBlock) -> None:
        self._write(ROBOT_STATE, _state(block))
        self._write(ROBOT_COMMAND, _command(block))
        rows = self._pose_rows(block.t_ns)
        if rows.size:
            self._poses(block, rows)

    def _pose_rows(self, t_ns: Int64) -> Int64:
        """Rows of a block that fall on the 100 Hz grid; the grid begins with the first tick."""
        if self._next_pose_ns is None:
            self._next_pose_ns = self._next_transform_ns = int(t_ns[0])
        rows: list[int] = []
        for row, t in enumerate(t_ns.tolist()):
            if t >= self._next_pose_ns:
                rows.append(row)
                missed = (t - self._next_pose_ns) // POSE_PERIOD_NS
                self._next_pose_ns += (missed + 1) * POSE_PERIOD_NS
        return np.array(rows, dtype=np.int64)

    def _poses(self, block: TickBlock, rows: Int64) -> None:
        patient = self._hand.poses(block.q_rad[rows])
        hands = {"patient": patient, "robot": self._hand.poses(block.q_command_rad[rows])}
        if self._follows:
            hands = {"reference": self._hand.poses(block.q_reference_rad[rows]), **hands}
        std_m = self._hand.fingertip_std_m(patient.joints_rad)
        for index, row in enumerate(rows.tolist()):
            t_ns = int(block.t_ns[row])
            if self._follows:
                self._write(REFERENCE, _reference(t_ns, float(block.path_s[row]), hands["reference"], index))
            self._write(PATIENT_POSE, self._patient(t_ns, patient, std_m, index))
            if t_ns >= self._next_transform_ns:
                self._next_transform_ns = t_ns + TRANSFORM_PERIOD_NS
                landmarks = {name: poses.landmarks_m[index] for name, poses in hands.items()}
                self._write(TRANSFORMS, _transforms(t_ns, landmarks))

    def _patient(self, t_ns: int, poses: Poses, std_m: Float64, index: int) -> PatientPose:
        return PatientPose(
            t_ns=t_ns,
            source="encoder",
            joints_rad=poses.joints_rad[index],
            joint_std_rad=self._hand.std_rad,
            joint_status=self._hand.status,
            fingertips_palm_m=poses.fingertips_m[index],
            fingertip_std_m=std_m[index],
        )

    def _phase(self, phase: PhaseChange) -> None:
        unaided = self._mode in _UNAIDED
        self._write(
            PHASE,
            TherapyPhase(
                t_ns=phase.t_ns,
                repetition=phase.repetition,
                phase=phase.phase,
                mode=self._mode,
                started_by="" if unaided and phase.started_by == "robot" else phase.started_by,
                path_s=phase.path_s,
                path_speed=phase.path_speed,
                assistance=np.full(5, np.nan) if unaided else by_digit(phase.stiffness_multiple, self._digit),
            ),
        )

    def _event(self, event: SafetyEvent) -> None:
        self._write(EVENTS, _event_record(event))


def by_digit(values: Float64, digit: Int64) -> Float64:
    """Means over the joints of each digit, shape (5,); NaN for a digit that is not driven."""
    count = np.bincount(digit, minlength=5).astype(np.float64)
    count[count == 0.0] = np.nan
    return np.bincount(digit, weights=values, minlength=5) / count


def _state(block: TickBlock) -> RobotStateBlock:
    return RobotStateBlock(
        t_ns=block.t_ns,
        q_rad=block.q_rad,
        dq_rad_s=block.dq_rad_s,
        tau_nm=block.tau_nm,
        tau_interaction_nm=block.tau_interaction_nm,
        path_s=block.path_s,
        path_speed=block.path_speed,
        safety_state=block.safety_state,
    )


def _command(block: TickBlock) -> RobotCommandBlock:
    return RobotCommandBlock(
        t_ns=block.t_ns,
        q_rad=block.q_command_rad,
        dq_rad_s=block.dq_command_rad_s,
        stiffness_nm_rad=block.stiffness_nm_rad,
        damping_nms_rad=block.damping_nms_rad,
        tau_ff_nm=block.tau_ff_nm,
        tau_requested_nm=block.tau_requested_nm,
        tau_applied_nm=block.tau_applied_nm,
    )


def _reference(t_ns: int, path_s: float, poses: Poses, index: int) -> ReferencePose:
    return ReferencePose(
        t_ns=t_ns,
        path_s=path_s,
        joints_rad=poses.joints_rad[index],
        fingertips_palm_m=poses.fingertips_m[index],
    )


def _transforms(t_ns: int, hands: dict[str, Float64]) -> Transforms:
    """Landmarks of each hand, (25, 3) in its palm frame, under that hand's own prefix."""
    parents: list[str] = []
    children: list[str] = []
    for name in hands:
        parents += ["robot_base", *([f"{name}/palm"] * len(LANDMARKS))]
        children += [f"{name}/palm", *(f"{name}/{landmark}" for landmark in LANDMARKS)]
    origin = np.zeros((1, 3))
    points = np.concatenate([part for landmarks in hands.values() for part in (origin, landmarks)])
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(points), 1))
    return Transforms(
        t_ns=t_ns,
        parents=tuple(parents),
        children=tuple(children),
        p_parent_child_m=points,
        q_parent_child_wxyz=rotations,
    )


def _event_record(event: SafetyEvent) -> Event:
    stopped = event.state in (SafetyState.CAT1, SafetyState.CAT0)
    severity = "alarm" if stopped else "caution" if event.state >= SafetyState.HOLD else "info"
    return Event(
        t_ns=event.t_ns,
        kind="stop" if stopped else "violation" if event.state >= SafetyState.HOLD else "session",
        severity=severity,
        cause=event.cause,
        category=event.state.name,
        subject=event.joint,
        value=event.value if math.isfinite(event.value) else math.nan,
        bound=event.bound,
        text=sentence_of(event),
    )
