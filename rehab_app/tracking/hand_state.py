"""The hand as a filter knows it: palm pose, joints, their rates, and the covariance of all of it.

The 27 positions are a small turn of the palm in the camera frame (3), the palm's origin (3) and the joints
(21), as in ``rehab_app.hand.pose_problem``; the 27 rates follow. Rates decay (an Ornstein-Uhlenbeck process,
integrated exactly), so that the same time passes the same way in one step or in many.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rehab_app.geometry.rotation import turn
from sessions.records.fields import Float64
from sessions.records.names import FINGERS, JOINTS

POSITIONS = 27
JOINT_ROWS = slice(6, 27)

_PERIOD_S = 1.0 / 30.0
_DECAY_HZ = -np.log(0.85) / _PERIOD_S  # what 0.85 a period of 30 Hz is per second
_FLEXION_JOLT = 0.05  # rad per period gained or lost within one period, one standard deviation
_ABDUCTION_SHARE = 0.35
_FLEXIONS = ("mcp_flexion", "pip", "dip")
_ALIKE = 0.7
_WITHIN = 0.6
_TURN_JOLT = 0.020  # rad per period, about the middle of the hand
_SHIFT_JOLT_M = 0.0025  # m per period
_MIDDLE_PALM_M = np.array([0.0, 0.0, 0.09])
_WANDER = 0.02  # of a jolt's variance: what goes straight into the position
_LONGEST_S = 0.25  # beyond this gap the rates say nothing any more; uncertainty grows on
_MOST_STD = np.concatenate([np.full(3, 1.0), np.full(3, 0.5), np.full(21, 0.9)])


def _jolts() -> Float64:
    joints = np.full(len(JOINTS), _FLEXION_JOLT)
    joints[[joint.endswith("abduction") for joint in JOINTS]] *= _ABDUCTION_SHARE
    joints[JOINTS.index("thumb_cmc_abduction")] = 0.6 * _FLEXION_JOLT
    joints[JOINTS.index("thumb_cmc_flexion")] = 0.6 * _FLEXION_JOLT
    return np.concatenate([np.full(3, _TURN_JOLT), np.full(3, _SHIFT_JOLT_M), joints])


def _together() -> Float64:
    """How joints are jolted alike: correlation of the 27 positions.

    Fingers close and open together, neighbours more than others, and so do the joints of one finger. It is
    what tells of a finger that is hidden while its neighbours are seen.
    """
    result = np.eye(POSITIONS)
    rows = [
        (6 + JOINTS.index(f"{finger}_{part}"), place)
        for place, finger in enumerate(FINGERS)
        for part in _FLEXIONS
    ]
    parts = [part for _ in FINGERS for part in _FLEXIONS]
    for (a, here), part_a in zip(rows, parts, strict=True):
        for (b, there), part_b in zip(rows, parts, strict=True):
            if a != b:
                result[a, b] = _ALIKE ** abs(here - there) * (1.0 if part_a == part_b else _WITHIN)
    return result


# spectral density of the accelerations of the positions, unit^2/s^3
_DENSITY = np.outer(_jolts(), _jolts()) * _together() / _PERIOD_S**3


@dataclass(frozen=True, slots=True)
class HandState:
    """A hand in motion at one instant.

    Attributes:
        t_ns: Capture time, monotonic, ns.
        rotation: Palm to camera, shape (3, 3).
        p_m: Palm origin in the camera frame, shape (3,).
        joints_rad: Joint angles, shape (21,).
        rate: Time derivative of the 27 positions, shape (27,), rad/s and m/s.
        covariance: Of positions and rates, shape (54, 54).
    """

    t_ns: int
    rotation: Float64
    p_m: Float64
    joints_rad: Float64
    rate: Float64
    covariance: Float64

    @property
    def position_covariance(self) -> Float64:
        """Covariance of the 27 positions."""
        return self.covariance[:POSITIONS, :POSITIONS]

    @property
    def joint_covariance_rad2(self) -> Float64:
        """Covariance of the joints, shape (21, 21)."""
        return self.covariance[JOINT_ROWS, JOINT_ROWS]

    def moved(self, step: Float64) -> HandState:
        """The hand after a step in the 27 positions; rates and covariance as they were."""
        return replace(
            self,
            rotation=turn(step[:3]) @ self.rotation,
            p_m=self.p_m + step[3:6],
            joints_rad=self.joints_rad + step[JOINT_ROWS],
        )


def at_rest(
    t_ns: int, rotation: Float64, p_m: Float64, joints_rad: Float64, position_covariance: Float64
) -> HandState:
    """A hand of which one capture is known: its rates are zero, give or take a usual movement."""
    covariance = np.zeros((2 * POSITIONS, 2 * POSITIONS))
    covariance[:POSITIONS, :POSITIONS] = position_covariance
    covariance[POSITIONS:, POSITIONS:] = 0.5 * _DENSITY / (2.0 * _DECAY_HZ)
    return HandState(t_ns, rotation, p_m, joints_rad, np.zeros(POSITIONS), covariance)


def predicted(state: HandState, t_ns: int) -> HandState:
    """The hand at a later time, by its decaying rates alone."""
    span_s = max(1e-9 * (t_ns - state.t_ns), 0.0)
    left = float(np.exp(-_DECAY_HZ * span_s))
    reach_s = (1.0 - left) / _DECAY_HZ if span_s < _LONGEST_S else 0.0
    old, size = state.covariance, POSITIONS
    mixed = old[:size, size:] + reach_s * old[size:, size:]
    noise_xx, noise_xv, noise_vv = _noise(state.rotation, span_s)
    new = np.empty_like(old)
    new[:size, :size] = old[:size, :size] + reach_s * (mixed + old[size:, :size]) + noise_xx
    new[:size, size:] = left * mixed + noise_xv
    new[size:, :size] = new[:size, size:].T
    new[size:, size:] = left**2 * old[size:, size:] + noise_vv
    ahead = state.moved(reach_s * state.rate)
    return replace(ahead, t_ns=t_ns, rate=left * state.rate, covariance=_bounded(new))


def _noise(rotation: Float64, span_s: float) -> tuple[Float64, Float64, Float64]:
    """What a stretch of time adds to the covariance of positions, of both, and of rates, each (27, 27)."""
    rate, left = _DECAY_HZ, float(np.exp(-_DECAY_HZ * span_s))
    position = (span_s - 2.0 * (1.0 - left) / rate + (1.0 - left**2) / (2.0 * rate)) / rate**2
    position += _WANDER * span_s * _PERIOD_S**2
    both = (1.0 - left) ** 2 / (2.0 * rate**2)
    speed = (1.0 - left**2) / (2.0 * rate)
    density = _turned_about_the_middle(rotation)
    return position * density, both * density, speed * density


def _turned_about_the_middle(rotation: Float64) -> Float64:
    """Density of the accelerations when the palm is jolted about the middle of the hand, (27, 27)."""
    x, y, z = rotation @ _MIDDLE_PALM_M
    # the origin moves by minus turn x arm when the hand turns about the arm's end
    lever = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    density = _DENSITY.copy()
    turns = density[:3, :3]
    density[3:6, 3:6] += lever @ turns @ lever.T
    density[3:6, :3] = lever @ turns
    density[:3, 3:6] = density[3:6, :3].T
    return density


def _bounded(covariance: Float64) -> Float64:
    """The same with no position less certain than a hand can be: rows and columns shrink together."""
    std = np.sqrt(np.diagonal(covariance)[:POSITIONS])
    shrink = np.ones(2 * POSITIONS)
    shrink[:POSITIONS] = np.minimum(1.0, _MOST_STD / np.maximum(std, 1e-12))
    if bool((shrink == 1.0).all()):
        return covariance
    return covariance * shrink[:, None] * shrink
