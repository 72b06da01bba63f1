"""What the virtual patient's muscles do beyond passive stiffness: voluntary effort, reflex, tremor."""

from __future__ import annotations

import numpy as np

from robot_iface.sim.kinds import VirtualPatient
from robot_iface.sim.model import DRIVEN, PERIOD_S
from robot_iface.types import Float64

COMMAND_DELAY_TICKS = 80  # on the command only; a delay on the feedback would make the servo shake
REFLEX_DELAY_TICKS = 30
REFLEX_THRESHOLD_RAD_S = float(np.deg2rad(30.0))
_SERVO_STIFFNESS_NM_RAD = 0.4
_SERVO_DAMPING_NMS_RAD = 0.01
_EFFORT_RISE_S = 0.3
_ANTICIPATION_S = 0.1
_LEAD_RAD = float(np.deg2rad(15.0))  # how far ahead a patient reaches before the robot has started
_SLACK_PER_REPETITION = 0.85
_TREMOR_HZ = 5.0
_MCP = np.array([1.0 if name.endswith("mcp_flexion") else 0.0 for name in DRIVEN])


class PatientEffort:
    """Torque of the virtual patient's muscles on the driven joints, tick by tick.

    Args:
        patient: Who it is.
        rest_rad: Resting posture of the driven joints, (12,).
        rng: Source of the tremor's phases.
    """

    def __init__(self, patient: VirtualPatient, rest_rad: Float64, rng: np.random.Generator) -> None:
        self._patient = patient
        self._rest_rad = rest_rad
        self._goals_rad = np.tile(rest_rad, (COMMAND_DELAY_TICKS, 1))
        self._efforts = np.zeros(COMMAND_DELAY_TICKS)
        self._speeds_rad_s = np.zeros((REFLEX_DELAY_TICKS, len(DRIVEN)))
        self._phase_rad = rng.uniform(0.0, 2.0 * np.pi, len(DRIVEN))
        self._tick = 0
        self._effort = 0.0
        self._willingness = 1.0
        self._path_rad: Float64 | None = None
        self._step_s = 1.0
        self._rate = 0.0
        self._own_s = 0.0
        self._robot_s = 0.0
        resists = patient.will == "resist"
        self._wants = resists
        self._idle = not (resists or patient.spasticity_nms_rad or patient.tremor_nm)

    def cue(self, path_rad: Float64, step_s: float, speed: float) -> None:
        """Ask for the movement whose postures stand ``step_s`` apart in ``path_rad``, (M, 12)."""
        if self._patient.will in ("none", "resist"):
            return
        self._path_rad, self._step_s, self._rate = path_rad, step_s, speed * PERIOD_S
        self._own_s = self._robot_s = 0.0
        self._wants = True
        if self._patient.will == "slack":
            self._willingness *= _SLACK_PER_REPETITION

    def progress(self, path_s: float) -> None:
        """Let the patient see how far the movement has come."""
        self._robot_s = path_s

    def relax(self) -> None:
        """End the patient's intention."""
        self._wants = self._patient.will == "resist"

    def torque_nm(self, q_rad: Float64, dq_rad_s: Float64) -> Float64 | None:
        """Muscle torque at this tick, flexion positive, (12,); None while there is none."""
        if self._idle and not self._wants and self._effort < 1e-6:
            return None
        tick, patient = self._tick, self._patient
        self._tick = tick + 1
        torque = self._voluntary_nm(tick, q_rad, dq_rad_s)
        if patient.spasticity_nms_rad:
            row = tick % REFLEX_DELAY_TICKS
            late = self._speeds_rad_s[row].copy()
            self._speeds_rad_s[row] = dq_rad_s
            torque += patient.spasticity_nms_rad * np.maximum(-REFLEX_THRESHOLD_RAD_S - late, 0.0)
        if patient.tremor_nm:
            turn = 2.0 * np.pi * _TREMOR_HZ * PERIOD_S * tick
            torque += patient.tremor_nm * _MCP * np.sin(turn + self._phase_rad)
        return torque

    def _voluntary_nm(self, tick: int, q_rad: Float64, dq_rad_s: Float64) -> Float64:
        wanted = self._willingness * self._patient.ability if self._wants else 0.0
        self._effort += (wanted - self._effort) * (PERIOD_S / _EFFORT_RISE_S)
        row = tick % COMMAND_DELAY_TICKS
        goal, effort = self._goals_rad[row].copy(), float(self._efforts[row])
        self._goals_rad[row] = self._goal_rad()
        self._efforts[row] = self._effort
        pull = _SERVO_STIFFNESS_NM_RAD * (goal - q_rad) - _SERVO_DAMPING_NMS_RAD * dq_rad_s
        return effort * pull

    def _goal_rad(self) -> Float64:
        """The posture that the patient now strives for: a little ahead of the robot, or of its start."""
        path = self._path_rad
        if path is None:
            return self._rest_rad
        last, here = path.shape[0] - 1, int(self._robot_s / self._step_s)
        own = int(self._own_s / self._step_s)
        ahead = path[min(own, last)]
        if float(np.abs(ahead - path[min(here, last)]).max()) < _LEAD_RAD:
            self._own_s += self._rate
        return path[min(max(own, int((self._robot_s + _ANTICIPATION_S) / self._step_s)), last)]
