"""What the two guided assessments share: the state of a task that plays no path."""

from __future__ import annotations

import numpy as np

from robot_iface.control import Goal, thesis_gains
from robot_iface.errors import Refused
from robot_iface.motion import PathState, Setpoint
from robot_iface.runtime.sweep_kernels import MULTIPLE, RATE, SET, TORQUE, free, lead
from robot_iface.runtime.task import Remark
from robot_iface.types import DeviceState, Float64, Plan, Sweep

STOP_SHARE = 0.48
"""Share of the interaction limit at which a joint is led no farther: just below the half above which a
stretch at rest is lowered."""
FEEDBACK = 0.8
_FEEDBACK_PER_S = 2.0
_STILL = PathState(0.0, 0.0, 0.0, False)
_NS = 1e-9


class SweepTask:
    """The part of ``Task`` that is alike in every run without a path. Arrays are (J,).

    Args:
        plan: What to do; its ``sweep`` says what.
        period_s: Control period.

    Raises:
        Refused: The plan has no sweep.
    """

    def __init__(self, plan: Plan, period_s: float) -> None:
        if plan.sweep is None:
            raise Refused("guided sweep", "without a sweep", "with a sweep", "plan a sweep")
        sweep, limits = plan.sweep, plan.limits
        joints = len(sweep.joint_names)
        self._sweep: Sweep = sweep
        self._period_s = period_s
        self._stiffness = thesis_gains(sweep.joint_names).stiffness_nm_rad
        self._bounds: Float64 = np.stack(
            (
                limits.q_min_rad,
                limits.q_max_rad,
                np.minimum(limits.flexion_speed_rad_s, sweep.speed_rad_s),
                np.minimum(limits.extension_speed_rad_s, sweep.speed_rad_s),
                STOP_SHARE * limits.tau_interaction_nm,
            )
        )
        self._zeros = np.zeros(joints)
        self._table = np.zeros((5, joints))
        self._measured = np.zeros((3, joints))
        self._goal = np.zeros(joints)
        self._way = np.ones(joints)
        self._pace = 1.0
        self._feedback = 0.0
        self._ticks = 0
        self._age_ticks = 0
        self.phase = "approach"
        self.repetition = -1
        self.started_by = ""
        self.path_state = _STILL
        self.reason = ""
        self.paused = False
        self.fault = ""
        self.assistance: tuple[tuple[float, ...], ...] = ()
        self._remark: Remark | None = None
        self._warm_up()

    @property
    def done(self) -> bool:
        """Whether there is nothing left to do."""
        return self.phase == "done"

    @property
    def reference_rad(self) -> Float64:
        """Where the hand is being led."""
        return self._goal.copy()

    @property
    def stiffness_multiple(self) -> Float64:
        """Stiffness of the last tick as a multiple of the thesis gains."""
        return self._table[MULTIPLE].copy()

    @property
    def repetition_age_ns(self) -> int:
        """How long this posture has been going on, pauses left out."""
        return round(self._age_ticks * self._period_s / _NS)

    @property
    def repetition_timeout_ns(self) -> int:
        """An active and a passive part, the way back, and ten seconds."""
        return round((3.0 * self._sweep.timeout_s + 10.0) / _NS)

    def resting_goal(self) -> Goal:
        """A goal without stiffness."""
        still = Setpoint(self._zeros, self._zeros, self._zeros)
        return Goal(still, self._zeros, self._zeros, _STILL)

    def pause(self) -> None:
        """Come to rest."""
        self.paused = True

    def resume(self) -> None:
        """Go on."""
        self.paused = False

    def take_remark(self) -> Remark | None:
        """What it has to say beside its phases, once."""
        remark, self._remark = self._remark, None
        return remark

    def slow_down_to(self, speed: float) -> None:
        """Lead at this share of the sweep's speed, 0.1 to 1."""
        self._pace = min(max(speed, 0.1), 1.0)

    def _take(self, state: DeviceState) -> None:
        """Take a reading, and count a tick unless paused."""
        self._measured[0], self._measured[1] = state.q_rad, state.dq_rad_s
        self._measured[2] = state.tau_interaction_nm
        if not self.paused:
            self._ticks += 1
            self._age_ticks += 1

    def _place(self, q_rad: Float64) -> None:
        """Begin with the set-point where the hand is, without stiffness."""
        self._table[:] = 0.0
        self._table[SET] = q_rad

    def _head_for(self, goal_rad: Float64) -> None:
        """Lead to another posture from now on."""
        self._goal = np.clip(goal_rad, self._bounds[0], self._bounds[1])
        self._way = np.where(self._goal >= self._table[SET], 1.0, -1.0)

    def _lead(self, multiple: float, *, held: bool = False) -> tuple[float, float]:
        """One tick on the way; returns the speeds of the set-point and of the hand."""
        pace = 0.0 if self.paused or held else self._pace
        return lead(
            *(self._table, self._measured, self._way, self._goal, self._bounds, self._stiffness),
            *(multiple, pace, self._period_s),
        )

    def _free(self) -> float:
        """One tick without leading; returns the speed of the hand."""
        return free(self._table, self._measured, self._bounds, self._period_s)

    def _asked(self, feedback: float) -> Goal:
        """The goal of this tick; feedback comes and goes smoothly."""
        most = _FEEDBACK_PER_S * self._period_s
        self._feedback += min(max(feedback - self._feedback, -most), most)
        rows = self._table.copy()
        setpoint = Setpoint(rows[SET], rows[RATE], self._zeros)
        return Goal(setpoint, rows[MULTIPLE], rows[TORQUE], _STILL, feedback=self._feedback)

    def _after(self, seconds: float) -> bool:
        """Whether the stage has lasted this long, unless it is paused."""
        return self._ticks * self._period_s >= seconds and not self.paused

    def _warm_up(self) -> None:
        """Compile before the first tick."""
        self._lead(0.0)
        self._free()
        self._table[:] = 0.0
