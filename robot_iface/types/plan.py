"""The whole of what the motion process is handed before anything moves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from robot_iface.errors import Refused
from robot_iface.types.hand import DIGITS, Float64, Side
from robot_iface.types.limits import Limits
from robot_iface.types.patient import PatientTwin

Mode = Literal["passive", "assistive", "transparent", "resistive"]
MODES: tuple[Mode, ...] = ("passive", "assistive", "transparent", "resistive")
Space = Literal["joint", "fingertip"]
SPACES: tuple[Space, ...] = ("joint", "fingertip")
SweepKind = Literal["range", "fit", "tone"]
FASTEST_STRETCH_RAD_S = 1.6
"""Just above 90 deg/s, the fastest of the three speeds at which tone is tested."""


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
        space: Where the impedance acts: at the joints, or at the fingertips (with a weak joint spring).
        warm_up_repetitions: First repetitions whose range is less: it ends 10 degrees before today's limits
            in the first one and 2 degrees nearer in each that follows.
        minutes: Time after which no new repetition begins, 0 for none.
        resistance: Resistive: share of the interaction limit with which motion is opposed.
        assistance: Assistance carried over from the last session: stiffness multiples by digit (order of
            DIGITS), a row for extension and one for flexion; empty to begin with ``stiffness_multiple``.
        skin_check_s: Motion time after which a person must have looked at the skin, 0 for never.
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
    space: Space = "joint"
    warm_up_repetitions: int = 0
    minutes: float = 0.0
    resistance: float = 0.3
    assistance: tuple[tuple[float, ...], ...] = ()
    skin_check_s: float = 0.0

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
            ("space", self.space, self.space in SPACES, "one of " + ", ".join(SPACES)),
            ("warm-up", self.warm_up_repetitions, 0 <= self.warm_up_repetitions <= 50, "0 to 50 repetitions"),
            ("minutes", self.minutes, 0.0 <= self.minutes <= 120.0, "0 to 120"),
            ("resistance", self.resistance, 0.05 <= self.resistance <= 0.8, "0.05 to 0.8"),
            (
                "assistance",
                self.assistance,
                _is_assistance(self.assistance),
                "2 rows of 5, 0.1 to 4",
            ),
            ("skin check", self.skin_check_s, self.skin_check_s >= 0.0, "0 s or more"),
        )
        for name, value, allowed, bound in checks:
            if not allowed:
                raise Refused(f"prescription {name}", str(value), bound, "change the prescription")


def _is_assistance(rows: tuple[tuple[float, ...], ...]) -> bool:
    if not rows:
        return True
    return len(rows) == 2 and all(
        len(row) == len(DIGITS) and all(0.1 <= value <= 4.0 for value in row) for row in rows
    )


@dataclass(frozen=True, slots=True)
class Sweep:
    """A run without a path: a guided assessment of the hand in the device.

    Attributes:
        kind: "range" measures today's range at named postures, "fit" checks the fit and the sign of every
            joint after donning, "tone" stretches the fingers at several speeds.
        joint_names: The J joints of the device.
        side: Side of the patient's hand.
        postures: Names of the postures in order, such as open, tabletop, hook, fist; empty for "fit",
            "stretch" once for each stretch of "tone".
        goals_rad: Where the robot helps towards in each posture, (P, J).
        speed_rad_s: Highest speed of the help.
        active: Whether the patient is first asked to make each posture alone (transparent); the robot then
            goes on slowly and gently from there (passive).
        dwell_s: How long the hand must rest at the end of a posture.
        timeout_s: Longest time of one posture's active or passive part.
        stretch_rad_s: Of "tone": speed of each stretch, (P,); the limits of the hand may make it slower.
        start_rad: Of "tone": where each stretch begins, (J,); else empty.
    """

    kind: SweepKind
    joint_names: tuple[str, ...]
    side: Side
    postures: tuple[str, ...]
    goals_rad: Float64
    speed_rad_s: float = 0.17
    active: bool = True
    dwell_s: float = 1.0
    timeout_s: float = 20.0
    stretch_rad_s: tuple[float, ...] = ()
    start_rad: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.goals_rad.shape != (len(self.postures), len(self.joint_names)):
            bound = f"({len(self.postures)}, {len(self.joint_names)})"
            raise Refused("sweep goals", f"of shape {self.goals_rad.shape}", bound, "give one row a posture")
        if not 0.0 < self.speed_rad_s <= 0.35:
            raise Refused("sweep speed", f"{self.speed_rad_s:g} rad/s", "above 0, at most 0.35", "go slower")
        if self.kind == "tone":
            self._check_tone()

    def _check_tone(self) -> None:
        if len(self.stretch_rad_s) != len(self.postures) or len(self.start_rad) != len(self.joint_names):
            value = f"{len(self.stretch_rad_s)} speeds and {len(self.start_rad)} starting angles"
            bound = f"{len(self.postures)} speeds and {len(self.joint_names)} angles"
            raise Refused("tone test", value, bound, "give one speed a stretch, one angle a joint")
        for speed in self.stretch_rad_s:
            if not 0.0 < speed <= FASTEST_STRETCH_RAD_S:
                bound = f"above 0, at most {FASTEST_STRETCH_RAD_S}"
                raise Refused("speed of a stretch", f"{speed:g} rad/s", bound, "go slower")


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

    Exactly one of ``path`` and ``sweep`` is given.

    Attributes:
        device: Device name, one of ``robot_iface.build.DEVICES`` or a real one.
        path: Reference path; None in a run without a path.
        prescription: What the therapist ordered.
        limits: Bounds of the lowest layer.
        twin: Virtual patient, of the simulated device and of the rehearsal.
        seed: Seed of everything random in the simulation.
        software_version: Version that is going to run.
        realtime: Run on the wall clock; otherwise as fast as it can.
        stop_at_s: Simulated times at which a scripted stop is pressed (headless runs and tests).
        sweep: Guided assessment; None where a path is played.
        wrist_rad: Wrist extension at which the hand is held today.
        confirmed_device: Name of the real device that a person has confirmed; must equal ``device`` where
            that is not a simulation.
    """

    device: str
    path: ReferencePath | None
    prescription: Prescription
    limits: Limits
    twin: PatientTwin
    seed: int
    software_version: str
    realtime: bool = False
    stop_at_s: tuple[float, ...] = field(default=())
    sweep: Sweep | None = None
    wrist_rad: float = 0.0
    confirmed_device: str = ""

    def __post_init__(self) -> None:
        if (self.path is None) == (self.sweep is None):
            both = "both" if self.path is not None else "neither"
            raise Refused("plan", f"with {both} of path and sweep", "exactly one", "plan it again")

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The J joints that are moved."""
        return self._task.joint_names

    @property
    def side(self) -> Side:
        """Side of the patient's hand."""
        return self._task.side

    @property
    def path_s(self) -> float:
        """Length of the path at full speed, s; 0 without a path."""
        return 0.0 if self.path is None else float(self.path.t_s[-1])

    @property
    def _task(self) -> ReferencePath | Sweep:
        task = self.path or self.sweep
        assert task is not None  # refused at construction
        return task
