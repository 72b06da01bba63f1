"""How hard damping may take hold of a hand that something drives."""

from __future__ import annotations

import numpy as np

from robot_iface.safety.yielding import BRAKE_NMS_RAD
from robot_iface.types import DeviceCommand, DeviceState, Float64, Limits

LEAST_SHARE = 0.25
"""Of the interaction limit: so much torque is always allowed; a hand without any load is braked too."""
DRIVEN_SHARE = 0.5
"""Of the interaction limit: a loop whose sensors have the wrong sign seems to oppose its speed trip with 0.8
and more, a spasm that comes to the trip without being a load meets 0.33 at most."""
AHEAD_SHARE = 1.03
"""Of the law's torque: its path goes on from tick to tick, what takes its place stands still."""
_SPRING_SHARE = 0.9
_NEXT_SHARE = 0.5
_FAST_SHARE = 0.8
_SLOWEST_RAD_S = 1e-9


class Grip:
    """Damping that never loads the hand more than what it takes the place of.

    A brake that is there at once meets a hand that already moves with a blow: what stops it early loads it
    more than the law would have. So the torque of damping is bounded, joint by joint, by the larger of two:

    - what the last command of the law would give against the motion at this place and at the speed until the
      next reading, and 3 % more, because the law's path would go on: then the hand slows down along the same
      way as under the law alone, and is loaded by no more than that;
    - what the device gives now, and as much more as the load has fallen below the highest that there was.

    The first leaves the rise of a load as it would be, the second keeps it at its height from then on. Where
    both are above ``BRAKE_NMS_RAD`` times the speed, damping is that: a slow hand is always braked fully.

    Args:
        limits: Limits of the driven joints.
    """

    def __init__(self, limits: Limits) -> None:
        self._limit_nm = limits.tau_interaction_nm
        self._motor_nm = limits.tau_nm
        self._spring_nm: Float64 = _SPRING_SHARE * self._limit_nm
        self._least_nm: Float64 = LEAST_SHARE * self._limit_nm
        joints = self._limit_nm.size
        self._law: DeviceCommand | None = None
        self._seen: DeviceState | None = None
        self._highest_nm: Float64 = np.zeros(joints)
        self._allowed_nm: Float64 = np.full(joints, np.inf)
        self._slip_rad_s: Float64 = np.zeros(joints)
        self.damping_nms_rad: Float64 = np.full(joints, BRAKE_NMS_RAD)
        """Of the last tick, (J,)."""

    @property
    def common_nms_rad(self) -> float:
        """The one damping for all joints that no fast joint is loaded too much by."""
        speed = np.abs(self._slip_rad_s)
        return float(self.damping_nms_rad[speed >= _FAST_SHARE * speed.max()].min())

    def begin(self, replaced: DeviceCommand) -> None:
        """Take the place of a command; what was begun goes on."""
        if self._law is not None:
            return
        self._law = replaced
        self._seen = None
        self._highest_nm = np.zeros(self._limit_nm.size)
        self._allowed_nm = np.full(self._limit_nm.size, np.inf)

    def drop(self) -> None:
        """Requests pass again."""
        self._law = None
        self.damping_nms_rad = np.full(self._limit_nm.size, BRAKE_NMS_RAD)

    def update(self, state: DeviceState, along_rad_s: Float64 | float = 0.0) -> Float64:
        """Damping of this tick, Nms/rad, (J,); asked twice about one reading it answers alike.

        Args:
            state: Newest reading.
            along_rad_s: Speeds that are damped towards, (J,).
        """
        law = self._law
        if law is None or state is self._seen:
            return self.damping_nms_rad
        slip: Float64 = state.dq_rad_s - along_rad_s
        speed = np.abs(slip)
        gained = np.maximum(speed - np.abs(self._slip_rad_s), 0.0) if self._seen is not None else 0.0
        meant = np.maximum(speed + _NEXT_SHARE * gained, _SLOWEST_RAD_S)  # mean speed until the next tick
        most = self._most(law, state, slip, np.copysign(_NEXT_SHARE * gained, slip))
        self.damping_nms_rad = np.minimum(BRAKE_NMS_RAD, most / meant)
        self._seen, self._slip_rad_s = state, slip
        return self.damping_nms_rad

    def _most(self, law: DeviceCommand, state: DeviceState, slip: Float64, gaining: Float64) -> Float64:
        """The most torque that may act against a motion that gains so much meanwhile, (J,)."""
        load = np.abs(state.tau_interaction_nm)
        self._highest_nm = np.maximum(self._highest_nm, load)
        gives = np.minimum(_against(state.tau_nm, slip), self._allowed_nm) + self._highest_nm - load
        spring = np.clip(law.stiffness_nm_rad * (law.q_rad - state.q_rad), -self._spring_nm, self._spring_nm)
        damper = law.damping_nms_rad * (law.dq_rad_s - state.dq_rad_s - gaining)
        by_law = np.minimum(AHEAD_SHARE * _against(spring + damper + law.tau_ff_nm, slip), self._motor_nm)
        self._allowed_nm = np.maximum(np.maximum(gives, by_law), self._least_nm)
        return self._allowed_nm


def drives(state: DeviceState, limit_nm: Float64) -> bool:
    """Whether it is surely the patient who moves the fastest joint.

    A robot that runs away pushes along, or, where its position sensors have the wrong sign, seems to oppose
    with all that it drives the hand with.

    Args:
        state: Newest reading.
        limit_nm: Interaction limits, (J,).
    """
    joint = int(np.argmax(np.abs(state.dq_rad_s)))
    way = float(np.sign(state.dq_rad_s[joint]))
    opposing = -way * float(state.tau_nm[joint])
    return way * float(state.tau_interaction_nm[joint]) < 0.0 and opposing < DRIVEN_SHARE * float(
        limit_nm[joint]
    )


def _against(torque_nm: Float64, slip: Float64) -> Float64:
    """Size of a torque where it opposes a motion, else nothing, (J,)."""
    return np.where(torque_nm * slip < 0.0, np.abs(torque_nm), 0.0)
