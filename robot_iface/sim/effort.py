"""What the virtual patient's muscles do beyond passive stiffness: effort, reflex, clonus, tremor, spasm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot_iface.errors import Refused
from robot_iface.sim import muscles
from robot_iface.sim.kinds import VirtualPatient
from robot_iface.sim.model import DRIVEN, PERIOD_S
from robot_iface.sim.muscles import COMMAND_DELAY_TICKS, REFLEX_DELAY_TICKS, REFLEX_THRESHOLD_RAD_S
from robot_iface.types import Float64, Int64, Spasm

__all__ = [
    "COMMAND_DELAY_TICKS",
    "REFLEX_DELAY_TICKS",
    "REFLEX_THRESHOLD_RAD_S",
    "Nobody",
    "PatientEffort",
    "patient_spasms",
    "spasm_rows",
]

_SLACK_PER_REPETITION = 0.7
_ROUSED_PER_RAD = 1.0
_CLONUS_HZ = (5.0, 7.0)
_MCP: Float64 = np.array([1.0 if name.endswith("mcp_flexion") else 0.0 for name in DRIVEN])
_PROXIMAL: NDArray[np.bool_] = np.array(
    ["cmc" in name or (name.endswith("mcp_flexion") and "thumb" not in name) for name in DRIVEN]
)
# at the first joint of a digit (MCP, the thumb's CMC) and beyond it
_REFLEX_NM = (0.5, 0.3)  # largest stretch reflex (assumed)
_FLEXORS_NM = (2.0, 1.0)  # strength: about 25 N at the fingertip, half a healthy adult's (assumed)
_EXTENSORS_SHARE = 0.5
_FLEXES: Float64 = np.array([0.0 if name.endswith("abduction") else 1.0 for name in DRIVEN])


class PatientEffort:
    """Torque of the virtual patient's muscles on the driven joints, tick by tick.

    Args:
        patient: Who it is.
        rest_rad: Resting posture of the driven joints, (12,).
        rng: Source of the tremor's phases and of the clonus's frequency.
        spasms: Spasms, one row each (see ``spasm_rows``), (S, 16).
    """

    def __init__(
        self,
        patient: VirtualPatient,
        rest_rad: Float64,
        rng: np.random.Generator,
        spasms: Float64 | None = None,
    ) -> None:
        self._patient = patient
        self._spasms = np.zeros((0, 4 + len(DRIVEN))) if spasms is None else spasms
        self._goals = np.zeros((COMMAND_DELAY_TICKS, len(DRIVEN) + 1))
        self._goals[:, : len(DRIVEN)] = rest_rad
        self._speeds_rad_s = np.zeros((REFLEX_DELAY_TICKS, len(DRIVEN)))
        self._path_rad: Float64 = np.array(rest_rad, dtype=np.float64)[None, :]
        self._joints = _joint_rows(patient, rest_rad, rng.uniform(0.0, 2.0 * np.pi, len(DRIVEN)))
        beats_hz = float(rng.uniform(*_CLONUS_HZ)) if patient.clonus_nm else 0.0
        self._who: Float64 = np.array(
            [patient.ability, patient.spasticity_nms_rad, patient.tires_j, patient.clonus_nm, beats_hz]
        )
        self._state = np.zeros(muscles.STATE_PLACES)
        self._state[muscles.WILLINGNESS] = self._state[muscles.STEP_S] = 1.0
        self._state[muscles.WANTS] = float(patient.will == "resist")
        self._torque_nm = np.zeros(len(DRIVEN))
        self._own: Int64 = np.arange(len(DRIVEN))
        self._compile()

    def _compile(self) -> None:
        """Have the machine code ready before the first tick; the call leaves no trace."""
        kept = [array.copy() for array in (self._state, self._joints, self._goals, self._speeds_rad_s)]
        self.torque_nm(np.zeros(len(DRIVEN)), np.zeros(len(DRIVEN)))
        self._state, self._joints, self._goals, self._speeds_rad_s = kept

    @property
    def ability(self) -> float:
        """Present ability, 0 to 1: what fatigue has left of it."""
        tired = float(np.exp(-self._state[muscles.WORK_J] / self._patient.tires_j))
        return self._patient.ability * tired

    @property
    def willingness(self) -> float:
        """Share of the ability that is given when asked, 0 to 1: what slacking has left of it."""
        return float(self._state[muscles.WILLINGNESS])

    def cue(self, path_rad: Float64, step_s: float, speed: float) -> None:
        """Ask for the movement whose postures stand ``step_s`` apart in ``path_rad``, (M, 12)."""
        if self._patient.will in ("none", "resist"):
            return
        self._path_rad = np.ascontiguousarray(path_rad, dtype=np.float64)
        self._state[muscles.STEP_S] = step_s
        self._state[muscles.RATE_S] = speed * PERIOD_S
        self._state[muscles.OWN_S] = self._state[muscles.ROBOT_S] = 0.0
        self._state[muscles.WANTS] = 1.0
        if self._patient.will == "slack":
            self._slack()

    def _slack(self) -> None:
        """Effort falls from cue to cue and is kept up only by having been left behind.

        After Emken & Reinkensmeyer 2007, Wolbrecht 2008: u_{i+1} = f u_i + g e_i minimises effort and error
        together, so that a robot which removes the error removes the effort. The sizes are assumed.
        """
        state = self._state
        lag_rad = state[muscles.LAG_RAD] / max(state[muscles.LAG_TICKS], 1.0)
        kept = _SLACK_PER_REPETITION * state[muscles.WILLINGNESS] + _ROUSED_PER_RAD * lag_rad
        state[muscles.WILLINGNESS] = min(kept, 1.0)
        state[muscles.LAG_RAD] = state[muscles.LAG_TICKS] = 0.0

    def progress(self, path_s: float) -> None:
        """Let the patient see how far the movement has come."""
        self._state[muscles.ROBOT_S] = path_s

    def relax(self) -> None:
        """End the patient's intention."""
        self._state[muscles.WANTS] = float(self._patient.will == "resist")

    def pull(self, q_rad: Float64, dq_rad_s: Float64, at: Int64) -> Float64:
        """Muscle torque at this tick, flexion positive, (12,); the same array at every tick.

        Args:
            q_rad: All positions of the model, (nq,).
            dq_rad_s: All speeds, (nq,).
            at: Where the 12 joints stand in them, (12,).
        """
        muscles.muscle_torque(
            q_rad,
            dq_rad_s,
            at,
            self._who,
            self._state,
            self._joints,
            self._goals,
            self._speeds_rad_s,
            self._path_rad,
            self._spasms,
            self._torque_nm,
        )
        return self._torque_nm

    def torque_nm(self, q_rad: Float64, dq_rad_s: Float64) -> Float64:
        """Muscle torque at this tick for joints and speeds in their own order, (12,)."""
        return self.pull(q_rad, dq_rad_s, self._own).copy()


class Nobody:
    """The patient's side where no hand is in the device."""

    def cue(self, path_rad: Float64, step_s: float, speed: float) -> None:
        """Nothing: nobody is asked."""

    def progress(self, path_s: float) -> None:
        """Nothing."""

    def relax(self) -> None:
        """Nothing."""


def spasm_rows(spasms: tuple[Spasm, ...], names: tuple[str, ...], every: Float64) -> Float64:
    """Spasms as the compiled kernels read them.

    Args:
        spasms: The spasms.
        names: The J driven joints.
        every: Share of each joint in a spasm that names none, (J,).

    Returns:
        Start, duration, size, beats per second and the share of each joint, (S, 4 + J).

    Raises:
        Refused: A spasm names a joint that is not driven.
    """
    rows = np.zeros((len(spasms), 4 + len(names)))
    for row, spasm in zip(rows, spasms, strict=True):
        row[:4] = spasm.start_s, spasm.duration_s, spasm.size_nm, spasm.clonus_hz
        if spasm.joint and spasm.joint not in names:
            bound = "empty or one of " + ", ".join(names)
            raise Refused("joint of a spasm", repr(spasm.joint), bound, "choose one of these")
        row[4:] = every if not spasm.joint else [float(spasm.joint == name) for name in names]
    return rows


def patient_spasms(spasms: tuple[Spasm, ...]) -> Float64:
    """Spasms of the exoskeleton's patient; one that names no joint pulls at every flexion joint."""
    return spasm_rows(spasms, DRIVEN, _FLEXES)


def _joint_rows(patient: VirtualPatient, rest_rad: Float64, phase_rad: Float64) -> Float64:
    rows = np.zeros((muscles.JOINT_ROWS, len(DRIVEN)))
    rows[muscles.BLOCK_AT] = rest_rad - patient.block_rad
    rows[muscles.BLOCK_STIFFNESS] = patient.block_nm_rad * _FLEXES * float(patient.block_rad > 0.0)
    rows[muscles.TREMOR] = patient.tremor_nm * _MCP
    rows[muscles.PHASE] = phase_rad
    rows[muscles.REFLEX_CAP] = np.where(_PROXIMAL, *_REFLEX_NM)
    rows[muscles.FLEXOR_CAP] = np.where(_PROXIMAL, *_FLEXORS_NM)
    rows[muscles.EXTENSOR_CAP] = _EXTENSORS_SHARE * rows[muscles.FLEXOR_CAP]
    return rows
