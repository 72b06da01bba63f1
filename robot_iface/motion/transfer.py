"""A straight way between two postures: the approach to a path and the return from it."""

from __future__ import annotations

import math

import numpy as np

from robot_iface.errors import Refused
from robot_iface.motion.path import Setpoint
from robot_iface.motion.player import PathPlayer
from robot_iface.types import Float64, Limits

ACCELERATION_RAD_S2 = 4.0
"""Largest acceleration of the fastest joint."""
_JERK_PER_ACCELERATION_HZ = 10.0
_NOWHERE_S = 1e-6
_LONGEST_S = 600.0


def transfer_speeds(q_from_rad: Float64, q_to_rad: Float64, limits: Limits) -> Float64:
    """Speed limit of each joint for the direction in which a transfer moves it, (J,) rad/s."""
    flexing = q_to_rad >= q_from_rad
    return np.where(flexing, limits.flexion_speed_rad_s, limits.extension_speed_rad_s)


class Transfer:
    """A straight, jerk-limited way from rest to rest, one set-point a tick; every joint arrives together.

    One coordinate runs along the line as along a path, as fast as the joint that is bounded most may go, so
    that a pause or a resume at any time stays on the line and within every bound.

    Args:
        q_from_rad: Where it starts, (J,).
        q_to_rad: Where it ends, (J,).
        limits: Directed speed limits.
        period_s: Control period.

    Raises:
        Refused: An angle is not finite, a speed limit is not positive, or it would take over ten minutes.
    """

    def __init__(self, q_from_rad: Float64, q_to_rad: Float64, limits: Limits, period_s: float) -> None:
        if not (np.isfinite(q_from_rad).all() and np.isfinite(q_to_rad).all()):
            raise Refused("transfer", "not finite", "finite angles", "check the device's readings")
        way, speeds = q_to_rad - q_from_rad, transfer_speeds(q_from_rad, q_to_rad, limits)
        if not bool(np.all(speeds > 0.0)):
            raise Refused("transfer speed", "zero or less", "more than 0", "check the limits")
        seconds = float((np.abs(way) / speeds).max())
        if seconds > _LONGEST_S:
            raise Refused("transfer", f"{seconds:.0f} s long", "at most 600 s", "raise the speed limits")
        still = np.zeros(q_from_rad.size)
        self.start = Setpoint(q_from_rad, still, still)
        self._end = Setpoint(q_to_rad, still, still)
        self._player: PathPlayer | None = None
        self.seconds = period_s
        """How long it takes, without a pause."""
        if seconds > _NOWHERE_S:
            self._slope: Float64 = way / seconds
            acceleration = ACCELERATION_RAD_S2 / float(np.abs(self._slope).max())
            jerk = acceleration * _JERK_PER_ACCELERATION_HZ
            self._player = PathPlayer(seconds, period_s, 1.0, acceleration, jerk)
            self.seconds = _longest_s(seconds, acceleration, jerk)
        self._done = False

    @property
    def done(self) -> bool:
        """Whether the end has been given out."""
        return self._done

    @property
    def fault(self) -> str:
        """What the profile generator refused; empty while it goes on."""
        return "" if self._player is None else self._player.fault

    def skip(self) -> None:
        """Take it as done."""
        self._player = None
        self._done = True

    def step(self, *, paused: bool = False) -> Setpoint:
        """The set-point of the next tick; a pause slows it to rest on its way, at the end it stays there."""
        player = self._player
        if player is None or self._done:
            self._done = True
            return self._end
        if paused is not player.paused:
            (player.pause if paused else player.resume)()
        here = player.step()
        if here.at_end:
            self._done = True
            return self._end
        slope = self._slope
        return Setpoint(self.start.q_rad + slope * here.s, slope * here.s_dot, slope * here.s_ddot)


def _longest_s(seconds: float, acceleration: float, jerk: float) -> float:
    """Upper bound of the time that a coordinate takes from rest to rest."""
    cruise = seconds + 1.0 / acceleration + acceleration / jerk
    return max(cruise, 4.0 * (seconds / (2.0 * jerk)) ** (1.0 / 3.0), 4.0 * math.sqrt(seconds / acceleration))
