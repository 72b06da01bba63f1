"""Whether the patient has started the movement that was cued."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np

from robot_iface.compiled import compiled
from robot_iface.types import Float64

SETTLE_S = 1.0
BASELINE_S = 0.6
"""The baseline is the farthest that the hand went in the cued direction over the last part of settling."""
EARLIEST_S, LATEST_S = 0.3, 5.0
START_RAD = float(np.deg2rad(0.5))
DWELL_S = 0.3
"""For so long the hand must go on: longer than a spasm that is not to count (0.2 s)."""
FALL_SHARE = 0.15
"""A rise that falls back by this share of its height was no start; the dwell begins anew."""
FALL_RAD = float(np.deg2rad(0.15))
START_RAD_S = float(np.deg2rad(3.0))
"""Mean speed over the dwell: above what a drift of tone does (0.02 Nm in 6 s: 1.5 deg/s)."""
SWING_SHARE = 0.25
"""This much of the rise must be older than a third of the dwell: a stiff hand that a spasm the other way lets
go of swings beyond its rest, but all at once."""
TAKES_PART_SHARE = 0.25
"""A joint takes part if it has risen by this share of the mean rise ..."""
TOGETHER_SHARE = 1.0 / 3.0
"""... and so many joints, by weight, must take part: a spasm of one finger is not the hand's start."""
SMOOTH_HZ = 25.0
# what the compiled step keeps: ticks, displacement, baseline; of the present rise its low point, peak and age
_TICKS, _MOVED, _BASE, _LOW, _PEAK, _DWELL = range(6)


class Start(IntEnum):
    """How far the start of a repetition has come."""

    SETTLING = 0
    CUED = 1
    PATIENT = 2
    ROBOT = 3


class StartTrigger:
    """Fires when the hand goes on in the cued direction and keeps what it has gained.

    The signal is the weighted mean displacement of the exercise's own joints along the cued direction. From
    its low point it must rise for 0.3 s without falling back by 15 % of its height, at 3 deg/s or more, to
    beyond any point that it reached in the 0.6 s before the cue; a third of the joints (by weight) must take
    part; all of it 0.3 to 5 s after the cue. A tremor or clonus falls back every half period, a short spasm
    when it ends, and a hand that springs back from a spasm the other way ends where it was: none is a start.
    By kinematics alone a longer spasm looks the same as intention: ``docs/trigger.md`` shows which.

    Args:
        direction: Cued direction in joint space, (J,): only signs and proportions count; 0 for joints of
            other digits.
        period_s: Control period.
        cue_timeout_s: After this time without a start the robot helps and the repetition counts as
            robot-started.
    """

    def __init__(self, direction: Float64, period_s: float, cue_timeout_s: float) -> None:
        total = float(np.abs(direction).sum())
        joints = direction.size
        self._weights: Float64 = np.array(direction / total if total > 0.0 else np.zeros(joints))
        self._posts: Float64 = np.zeros((2, joints))
        self._past: Float64 = np.zeros(max(round(DWELL_S / period_s), 1))
        self._kept: Float64 = np.zeros(6)
        settle = round(SETTLE_S / period_s)
        self._times = (
            settle - round(BASELINE_S / period_s),
            settle,
            settle + round(EARLIEST_S / period_s),
            settle + round(LATEST_S / period_s),
            settle + math.ceil(cue_timeout_s / period_s - 1e-9),
        )
        self._keep = math.exp(-2.0 * math.pi * SMOOTH_HZ * period_s)
        self.rearm()
        self.update(np.zeros(joints))  # compiles it
        self.rearm()

    def rearm(self) -> None:
        """Begin anew: settle, then cue."""
        self._kept[:] = 0.0
        self._state = Start.SETTLING

    @property
    def state(self) -> Start:
        """Present state; PATIENT and ROBOT are final until ``rearm``."""
        return self._state

    def arrays(
        self,
    ) -> tuple[Float64, Float64, Float64, Float64, tuple[int, int, int, int, int], float]:
        """What ``judge`` works on, for a simulation that is compiled as a whole."""
        return self._weights, self._posts, self._past, self._kept, self._times, self._keep

    def update(self, q_rad: Float64) -> Start:
        """Take one tick of measured angles, (J,), and say where the start stands."""
        if self._state < Start.PATIENT:
            now = judge(q_rad, *self.arrays())
            if now != self._state:
                self._state = Start(now)
        return self._state


@compiled
def judge(
    q_rad: Float64,
    weights: Float64,
    posts: Float64,
    past: Float64,
    kept: Float64,
    times: tuple[int, int, int, int, int],
    keep: float,
) -> int:
    """One tick of ``StartTrigger``.

    Args:
        q_rad: Measured angles, (J,).
        weights: Cued direction, absolute sum 1, (J,).
        posts: Angles at the begin of the baseline, from which displacement is measured, and at the last low
            point, (2, J); updated.
        past: Ring of displacements over the dwell; updated.
        kept: See the names above, (6,); updated.
        times: Ticks at which the baseline begins, settling ends, counting begins, counting ends, and the
            robot helps.
        keep: Share kept by the smoothing.

    Returns:
        A ``Start``.
    """
    baseline, settle, earliest, latest, timeout = times
    kept[_TICKS] += 1.0
    tick = int(kept[_TICKS])
    if tick <= baseline:
        posts[0] = q_rad
        kept[_MOVED] = kept[_BASE] = 0.0
        return 0
    raw = 0.0
    for joint in range(weights.size):
        raw += weights[joint] * (q_rad[joint] - posts[0, joint])
    kept[_MOVED] = moved = keep * kept[_MOVED] + (1.0 - keep) * raw
    place = tick % past.size
    before, past[place] = past[place], moved
    if tick <= settle:
        kept[_BASE] = max(kept[_BASE], moved)
    if tick < earliest or tick > latest or moved < kept[_LOW]:
        kept[_LOW] = kept[_PEAK] = moved
        kept[_DWELL] = 0.0
        posts[1] = q_rad
    elif _rises(moved, kept) >= past.size and moved > kept[_BASE] + START_RAD:
        rise, recent = moved - kept[_LOW], past[(tick - past.size // 3) % past.size]
        gained = moved - before >= START_RAD_S * DWELL_S and recent - kept[_LOW] >= SWING_SHARE * rise
        if gained and _together(q_rad, weights, posts[1], rise):
            return 2
    if tick < settle:
        return 0
    return 3 if tick >= timeout else 1


@compiled
def _rises(moved_rad: float, kept: Float64) -> int:
    """Ticks for which the hand has kept what it gained since its low point; a fall begins them anew."""
    low, peak = kept[_LOW], max(kept[_PEAK], moved_rad)
    kept[_PEAK] = peak
    if peak - moved_rad > max(FALL_SHARE * (peak - low), FALL_RAD):
        kept[_PEAK] = moved_rad
        kept[_DWELL] = 0.0
    elif kept[_DWELL] > 0.0 or moved_rad - low > FALL_RAD:
        kept[_DWELL] += 1.0
    return int(kept[_DWELL])


@compiled
def _together(q_rad: Float64, weights: Float64, low_rad: Float64, rise_rad: float) -> bool:
    """Whether enough joints, by weight, rise in their cued direction."""
    part = 0.0
    for joint in range(weights.size):
        way = 1.0 if weights[joint] > 0.0 else -1.0
        if way * (q_rad[joint] - low_rad[joint]) > TAKES_PART_SHARE * rise_rad:
            part += abs(weights[joint])
    return part >= TOGETHER_SHARE
