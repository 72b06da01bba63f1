"""What was asked of the patient's hand and what it did: reference, patient, phase, robot, events."""

from __future__ import annotations

from dataclasses import dataclass

from sessions.records.fields import ROWS, Float64, Int64, UInt8, column


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferencePose:
    """The therapist's movement, made playable for this patient, at the present path coordinate."""

    t_ns: int = column("int64", (), "ns", "time, monotonic; equal to that of the PatientPose it belongs to")
    path_s: float = column("float64", (), "s", "path coordinate: time within the reference at full speed")
    joints_rad: Float64 = column("float64", (21,), "rad", "joint angles in the order of JOINTS")
    fingertips_palm_m: Float64 = column("float64", (5, 3), "m", "fingertips in the palm frame")


@dataclass(frozen=True, slots=True, kw_only=True)
class PatientPose:
    """Where the patient's hand was, and how surely."""

    t_ns: int = column("int64", (), "ns", "time, monotonic")
    source: str = column("string", (), "1", "what measured the angles: encoder or camera")
    joints_rad: Float64 = column("float64", (21,), "rad", "joint angles in the order of JOINTS")
    joint_std_rad: Float64 = column("float32", (21,), "rad", "standard deviation of each joint angle")
    joint_status: UInt8 = column("uint8", (21,), "1", "0 lost, 1 estimated, 2 measured, by joint")
    fingertips_palm_m: Float64 = column("float64", (5, 3), "m", "fingertips in the palm frame")
    fingertip_std_m: Float64 = column("float32", (5,), "m", "standard deviation of each fingertip, per axis")


@dataclass(frozen=True, slots=True, kw_only=True)
class TherapyPhase:
    """Where the session stands; written at every change and at 10 Hz."""

    t_ns: int = column("int64", (), "ns", "time, monotonic")
    repetition: int = column("int64", (), "1", "repetition index from 0, -1 outside one")
    phase: str = column("string", (), "1", "approach, ramp, cue, move, hold, return, rest, stopped or done")
    mode: str = column("string", (), "1", "passive, assistive, transparent or resistive")
    started_by: str = column("string", (), "1", "patient, robot or empty: who started this repetition")
    path_s: float = column("float64", (), "s", "path coordinate")
    path_speed: float = column("float64", (), "1", "path speed, 1 is the therapist's own")
    assistance: Float64 = column("float64", (5,), "1", "stiffness by digit as a multiple of the thesis gains")


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotStateBlock:
    """Up to 50 ticks of what the robot measured. Joints follow ``SessionHeader.robot_joints``."""

    t_ns: Int64 = column("int64", (ROWS,), "ns", "time of each tick, monotonic")
    q_rad: Float64 = column("float64", (ROWS, ROWS), "rad", "joint positions, tick by joint")
    dq_rad_s: Float64 = column("float64", (ROWS, ROWS), "rad/s", "joint velocities")
    tau_nm: Float64 = column("float64", (ROWS, ROWS), "Nm", "motor torques")
    tau_interaction_nm: Float64 = column(
        "float64", (ROWS, ROWS), "Nm", "torque of the robot on the patient's joint, flexion positive"
    )
    path_s: Float64 = column("float64", (ROWS,), "s", "path coordinate")
    path_speed: Float64 = column("float64", (ROWS,), "1", "path speed")
    safety_state: UInt8 = column("uint8", (ROWS,), "1", "supervisor state, see docs/hazards.md")


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotCommandBlock:
    """Up to 50 ticks of what was requested of the robot and what the supervisor let through."""

    t_ns: Int64 = column("int64", (ROWS,), "ns", "time of each tick, monotonic")
    q_rad: Float64 = column("float64", (ROWS, ROWS), "rad", "requested positions, tick by joint")
    dq_rad_s: Float64 = column("float64", (ROWS, ROWS), "rad/s", "requested velocities")
    stiffness_nm_rad: Float64 = column("float64", (ROWS, ROWS), "Nm/rad", "requested stiffness")
    damping_nms_rad: Float64 = column("float64", (ROWS, ROWS), "Nm s/rad", "requested damping")
    tau_ff_nm: Float64 = column("float64", (ROWS, ROWS), "Nm", "requested feed-forward torque")
    tau_requested_nm: Float64 = column("float64", (ROWS, ROWS), "Nm", "torque that the law asked for")
    tau_applied_nm: Float64 = column("float64", (ROWS, ROWS), "Nm", "torque that the supervisor let through")


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """A safety event, stop, note or pain entry."""

    t_ns: int = column("int64", (), "ns", "time, monotonic")
    kind: str = column("string", (), "1", "stop, violation, note, pain, recording or session")
    severity: str = column("string", (), "1", "info, caution or alarm")
    cause: str = column("string", (), "1", "short stable code, such as e-stop or heartbeat-lost")
    category: str = column("string", (), "1", "resulting supervisor state or stop category, empty if none")
    subject: str = column("string", (), "1", "joint or digit concerned, empty if none")
    value: float = column("float64", (), "SI", "value met, NaN if none")
    bound: float = column("float64", (), "SI", "bound that applied, NaN if none")
    text: str = column("string", (), "1", "one sentence for a person; never a patient's name")
