"""The whole of what the motion process is handed before anything moves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from robot_iface.errors import Refused
from robot_iface.types.hand import Float64, Side

Mode = Literal["passive", "assistive", "transparent", "resistive"]
MODES: tuple[Mode, ...] = ("passive", "assistive", "transparent", "resistive")


@dataclass(frozen=True, slots=True)
class ReferencePath:
    """An approved take, made playable for one patient on one robot.

    Attributes:
        joint_names: The J driven joints.
        t_s: Path coordinate of each knot: time at full speed, strictly increasing from 0, shape (N,).
        q_rad: Joint angles at the knots, shape (N, J).
        take_digest: SHA-256 of the take it was made from.
        side: Side of the patient's hand (already mirrored).
    """

    joint_names: tuple[str, ...]
    t_s: Float64
    q_rad: Float64
    take_digest: str
    side: Side

    def __post_init__(self) -> None:
        if self.q_rad.shape != (self.t_s.size, len(self.joint_names)):
            raise Refused(
                "reference path",
                f"of shape {self.q_rad.shape}",
                f"({self.t_s.size}, {len(self.joint_names)})",
                "give one row of angles per knot",
            )
        if self.t_s.size < 6 or self.t_s[0] != 0.0 or not bool(np.all(np.diff(self.t_s) > 0)):
            raise Refused(
                "reference path time",
                f"{self.t_s.size} knots from {self.t_s[0] if self.t_s.size else 'nothing'} s",
                "6 or more knots, increasing from 0 s",
                "rebuild the reference from its take",
            )
        if not bool(np.isfinite(self.q_rad).all()):
            raise Refused(
                "reference path", "not finite everywhere", "finite", "fill the gaps of the take or trim it"
            )


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds that the lowest layer enforces. Arrays are (J,) over the driven joints.

    Attributes:
        q_min_rad: Lower end of today's range.
        q_max_rad: Upper end of today's range.
        flexion_speed_rad_s: Highest commanded speed into flexion.
        extension_speed_rad_s: Highest commanded speed into extension.
        tau_interaction_nm: Highest torque between device and patient.
        tau_nm: Highest commanded motor torque.
        tau_rate_nm_s: Highest change of commanded torque.
        power_w: Highest mechanical power per joint.
        trip_speed_rad_s: Measured speed that trips the supervisor.
        margin_rad: How far outside the range a joint may be seen before it trips.
    """

    q_min_rad: Float64
    q_max_rad: Float64
    flexion_speed_rad_s: Float64
    extension_speed_rad_s: Float64
    tau_interaction_nm: Float64
    tau_nm: Float64
    tau_rate_nm_s: float = 60.0
    power_w: float = 2.0
    trip_speed_rad_s: float = float(np.deg2rad(200.0))
    margin_rad: float = float(np.deg2rad(2.0))


@dataclass(frozen=True, slots=True)
class Prescription:
    """What the therapist ordered.

    Attributes:
        mode: Therapy mode.
        speed: Path speed, 0.1 to 1 of the therapist's own.
        repetitions: How many times the movement is made.
        stiffness_multiple: Stiffness as a multiple n of the thesis gains (damping scales with sqrt n).
        assist_forgetting: f of the feed-forward learning between repetitions, 1 passive, 0.7-0.9 assistive.
        ramp_s: Time in which stiffness rises from zero.
        hold_s: Time held at the end of each repetition.
        rest_s: Rest between repetitions.
        cue_timeout_s: How long the patient is waited for before the robot helps (assistive).
    """

    mode: Mode
    speed: float = 0.5
    repetitions: int = 3
    stiffness_multiple: float = 3.0
    assist_forgetting: float = 0.8
    ramp_s: float = 1.0
    hold_s: float = 0.5
    rest_s: float = 0.5
    cue_timeout_s: float = 8.0

    def __post_init__(self) -> None:
        checks = (
            ("mode", self.mode, self.mode in MODES, "one of " + ", ".join(MODES)),
            ("speed", self.speed, 0.1 <= self.speed <= 1.0, "0.1 to 1"),
            ("repetitions", self.repetitions, 1 <= self.repetitions <= 500, "1 to 500"),
            (
                "stiffness multiple",
                self.stiffness_multiple,
                0.1 <= self.stiffness_multiple <= 10.0,
                "0.1 to 10",
            ),
            ("assist forgetting", self.assist_forgetting, 0.0 <= self.assist_forgetting <= 1.0, "0 to 1"),
            ("ramp", self.ramp_s, 1.0 <= self.ramp_s <= 30.0, "1 to 30 s"),
            ("hold", self.hold_s, 0.0 <= self.hold_s <= 60.0, "0 to 60 s"),
            ("rest", self.rest_s, 0.0 <= self.rest_s <= 600.0, "0 to 600 s"),
            ("cue time-out", self.cue_timeout_s, 1.0 <= self.cue_timeout_s <= 60.0, "1 to 60 s"),
        )
        for name, value, allowed, bound in checks:
            if not allowed:
                raise Refused(f"prescription {name}", str(value), bound, "change the prescription")


VirtualKind = Literal[
    "healthy", "flaccid", "weak", "mas1+", "mas2", "mas3", "tremor", "slacking", "resisting"
]
VIRTUAL_KINDS: tuple[VirtualKind, ...] = (
    "healthy",
    "flaccid",
    "weak",
    "mas1+",
    "mas2",
    "mas3",
    "tremor",
    "slacking",
    "resisting",
)


@dataclass(frozen=True, slots=True)
class PatientTwin:
    """The virtual patient in a simulated device; also the twin on which a path is rehearsed.

    Attributes:
        kind: Impairment, one of VIRTUAL_KINDS.
        side: Side of the hand.
        hand_length_m: Wrist crease to middle fingertip.
    """

    kind: VirtualKind = "healthy"
    side: Side = "right"
    hand_length_m: float = 0.189


@dataclass(frozen=True, slots=True)
class Certificate:
    """What a rehearsal attests, and for what exactly.

    Attributes:
        digest: SHA-256 over the parts below and everything else in this certificate.
        accepted: Whether the rehearsal kept within every bound.
        summary: One sentence: the first violation (joint, time, value, bound), or what was found.
        peak_interaction_nm: Largest interaction torque met, by driven joint, shape (J,).
        simulated_s: How long the dry run lasted.
        parts: ``name:SHA-256`` of path, prescription, limits, twin, device and software version, so that a
            refusal can name what differs.
    """

    digest: str
    accepted: bool
    summary: str
    peak_interaction_nm: tuple[float, ...]
    simulated_s: float
    parts: tuple[str, ...] = field(default=())


@dataclass(frozen=True, slots=True)
class Plan:
    """Everything the motion process needs; it is handed over whole before the first tick.

    Attributes:
        device: Device name, "exoskeleton".
        path: Reference path.
        prescription: What the therapist ordered.
        limits: Bounds of the lowest layer.
        twin: Virtual patient, of the simulated device and of the rehearsal.
        seed: Seed of everything random in the simulation.
        software_version: Version that is going to run.
        realtime: Run on the wall clock; otherwise as fast as it can.
        stop_at_s: Simulated times at which a scripted stop is pressed (headless runs and tests).
    """

    device: str
    path: ReferencePath
    prescription: Prescription
    limits: Limits
    twin: PatientTwin
    seed: int
    software_version: str
    realtime: bool = False
    stop_at_s: tuple[float, ...] = field(default=())
