"""What the supervisor commands by itself: hold and lower, or yield damped."""

from __future__ import annotations

import dataclasses

import numpy as np

from robot_iface.types import CommandMode, DeviceCommand, DeviceState, Float64

BRAKE_NMS_RAD = 0.15
"""Damping of brake and yielding: a released spastic hand moves at about 150 deg/s instead of 530, and with
one
tick of delay the rotor inertia of 3e-4 kg m^2 stays stable (bound 0.7 M / T = 0.21)."""
LOWER_RAD_S = float(np.deg2rad(20.0))
LOWERED_SHARE = 0.1
_FULL_RATE_SHARE = 0.3
_FORGET_S = 0.5


def damped(damping_nms_rad: Float64, seq: int) -> DeviceCommand:
    """Damping without a position goal: the hand is followed, never pushed. Arrays (J,)."""
    zeros = np.zeros(damping_nms_rad.size)
    return DeviceCommand(CommandMode.IMPEDANCE, zeros, zeros, zeros, zeros, damping_nms_rad, seq)


def nothing(joints: int, seq: int) -> DeviceCommand:
    """No torque at all. Arrays (J,)."""
    zeros = np.zeros(joints)
    return DeviceCommand(CommandMode.IMPEDANCE, zeros, zeros, zeros, zeros, zeros, seq)


class Holding:
    """Category 2: the last command stands still with power; lowered where it holds a stretch.

    Lowering moves the held posture to where the load pulls it, at most 20 deg/s, until every joint carries
    less than 10 % of its limit: no rest posture has to be known.

    Args:
        last: Last applied command, whose torque is carried on.
        tau_interaction_nm: Interaction limits, (J,).
        period_s: Control period.
    """

    def __init__(self, last: DeviceCommand, tau_interaction_nm: Float64, period_s: float) -> None:
        self.lowering = False
        """Whether the held posture gives way to the load."""
        self._command = dataclasses.replace(last, dq_rad_s=np.zeros_like(last.q_rad))
        self._limit_nm = tau_interaction_nm
        self._period_s = period_s

    def command(self, state: DeviceState, seq: int) -> DeviceCommand:
        """The command of the next tick."""
        if self.lowering:
            self._command = self._lowered(state)
        return dataclasses.replace(self._command, seq=seq)

    def _lowered(self, state: DeviceState) -> DeviceCommand:
        """One tick of giving way; joints with little load stay."""
        share = state.tau_interaction_nm / self._limit_nm
        loaded = np.abs(share) > LOWERED_SHARE
        rate = -np.clip(share / _FULL_RATE_SHARE, -1.0, 1.0) * LOWER_RAD_S * loaded
        keep = 1.0 - loaded * (self._period_s / _FORGET_S)
        return dataclasses.replace(
            self._command,
            q_rad=self._command.q_rad + rate * self._period_s,
            dq_rad_s=rate,
            tau_ff_nm=self._command.tau_ff_nm * keep,
        )
