"""Whether the patient has started the movement that was cued."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from robot_iface.types import Float64

SETTLE_S = 1.0
CUTOFF_HZ = 2.0
START_RAD = float(np.deg2rad(1.0))
START_RAD_S = float(np.deg2rad(1.0))
DWELL_S = 0.2
EARLIEST_S, LATEST_S = 0.3, 5.0


class Start(IntEnum):
    """How far the start of a repetition has come."""

    SETTLING = 0
    CUED = 1
    PATIENT = 2
    ROBOT = 3


class StartTrigger:
    """Fires on 1 deg at 1 deg/s for 200 ms in the cued direction, 0.3-5 s after the cue.

    The signal is the weighted mean displacement of the exercise's joints along the cued direction, through
    a second-order 2 Hz Butterworth low-pass, against a baseline taken while the hand settles for 1 s. By
    kinematics alone a slow spasm or a drift of tone looks the same as intention: the false-start rate is
    reported, not denied.

    Args:
        direction: Cued direction in joint space, (J,): only signs and proportions count; 0 for joints of
            other digits.
        period_s: Control period.
        cue_timeout_s: After this time without a start the robot helps and the repetition counts as
            robot-started.
    """

    def __init__(self, direction: Float64, period_s: float, cue_timeout_s: float) -> None:
        total = float(np.abs(direction).sum())
        self._weights: Float64 = direction / total if total > 0.0 else np.zeros(direction.shape)
        self._period_s = period_s
        self._filter = _LowPass(CUTOFF_HZ, period_s)
        self._timeout_s = cue_timeout_s
        self.rearm()

    def rearm(self) -> None:
        """Begin anew: settle, then cue."""
        self._tick = 0
        self._settle_ticks = round(SETTLE_S / self._period_s)
        self._dwell_s = 0.0
        self._baseline_rad = 0.0
        self._last_rad = 0.0
        self._state = Start.SETTLING

    @property
    def state(self) -> Start:
        """Present state; PATIENT and ROBOT are final until ``rearm``."""
        return self._state

    def update(self, q_rad: Float64) -> Start:
        """Take one tick of measured angles, (J,), and say where the start stands."""
        if self._state >= Start.PATIENT:
            return self._state
        raw = float(self._weights @ q_rad)
        if self._tick == 0:
            self._filter.settle_at(raw)
            self._last_rad = raw
        here = self._filter.step(raw)
        speed = (here - self._last_rad) / self._period_s
        self._last_rad = here
        self._tick += 1
        if self._tick <= self._settle_ticks:
            self._baseline_rad = here
            if self._tick == self._settle_ticks:
                self._state = Start.CUED
            return self._state
        self._state = self._judge(here - self._baseline_rad, speed)
        return self._state

    def _judge(self, moved_rad: float, speed_rad_s: float) -> Start:
        """Decide on one tick after the cue."""
        since_cue_s = (self._tick - self._settle_ticks) * self._period_s
        counts = EARLIEST_S <= since_cue_s <= LATEST_S
        if counts and moved_rad > START_RAD and speed_rad_s > START_RAD_S:
            self._dwell_s += self._period_s
        else:
            self._dwell_s = 0.0
        if self._dwell_s >= DWELL_S - 1e-9:
            return Start.PATIENT
        return Start.ROBOT if since_cue_s >= self._timeout_s else Start.CUED


class _LowPass:
    """Second-order Butterworth low-pass by the bilinear transform, one scalar at a time."""

    def __init__(self, cutoff_hz: float, period_s: float) -> None:
        w = math.tan(math.pi * cutoff_hz * period_s)
        scale = 1.0 / (1.0 + math.sqrt(2.0) * w + w * w)
        self._b = w * w * scale
        self._a1 = 2.0 * (w * w - 1.0) * scale
        self._a2 = (1.0 - math.sqrt(2.0) * w + w * w) * scale
        self.settle_at(0.0)

    def settle_at(self, value: float) -> None:
        """Start as if the input had always been ``value``."""
        self._x1 = self._x2 = self._y1 = self._y2 = value

    def step(self, x: float) -> float:
        """Filter one sample."""
        y = self._b * (x + 2.0 * self._x1 + self._x2) - self._a1 * self._y1 - self._a2 * self._y2
        self._x2, self._x1 = self._x1, x
        self._y2, self._y1 = self._y1, y
        return y
