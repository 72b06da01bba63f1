"""Movements for the virtual camera: postures at instants, minimum jerk between them, and a swaying hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rehab_app.hand.exercise_postures import MOVEMENTS, posture_rad
from robot_iface.kinematics import couple_dip
from robot_iface.types import FINGERS, JOINTS
from sessions.errors import Refused
from sessions.records.fields import Float64

OPEN_S = 1.2
"""How long every movement begins open and still: labels and bone lengths are read there."""

_OPEN_DEG = {
    **{f"{finger}_mcp_flexion": 5.0 for finger in FINGERS},
    **{f"{finger}_pip": 6.0 for finger in FINGERS},
    "index_mcp_abduction": 5.0,
    "ring_mcp_abduction": -4.0,
    "little_mcp_abduction": -8.0,
}
_CLOSE_DEG = {
    **{f"{finger}_mcp_flexion": 40.0 for finger in FINGERS},
    **{f"{finger}_pip": 50.0 for finger in FINGERS},
    **{f"{finger}_mcp_abduction": 0.0 for finger in FINGERS},
    "thumb_cmc_flexion": 12.0,
    "thumb_mcp_flexion": 18.0,
    "thumb_ip": 20.0,
}
_PINCH_DEG = {
    "thumb_cmc_abduction": 12.0,
    "thumb_cmc_flexion": 18.0,
    "thumb_mcp_flexion": 20.0,
    "thumb_ip": 25.0,
    "index_mcp_flexion": 45.0,
    "index_pip": 45.0,
}
_SPREAD_DEG = {
    "thumb_cmc_abduction": -15.0,
    "index_mcp_abduction": 14.0,
    "ring_mcp_abduction": -11.0,
    "little_mcp_abduction": -18.0,
}
MOTIONS = ("still", "open_close", "index_pip", "tapping", "pinch", "spread", *MOVEMENTS)
"""Names that ``scripted_motion`` knows."""


@dataclass(frozen=True, slots=True)
class Sway:
    """How a held-up hand wanders: peak displacement and rotation, begun once the still second is over.

    Attributes:
        amplitude_m: Peak displacement along each axis, m.
        amplitude_rad: Peak rotation about each axis, rad.
        rate_hz: Frequency of the fastest of its three sines.
    """

    amplitude_m: float = 0.004
    amplitude_rad: float = 0.03
    rate_hz: float = 0.45


@dataclass(frozen=True, slots=True)
class Tremor:
    """A fine shaking of every joint, begun once the still second is over.

    Attributes:
        amplitude_rad: Peak of each joint's sine, rad.
        rate_hz: Frequency of each joint, shape (21,).
        phase_rad: Phase of each joint, shape (21,).
    """

    amplitude_rad: float
    rate_hz: Float64
    phase_rad: Float64

    def at(self, t_s: Float64) -> Float64:
        """Displacement of the joints at times (N,), shape (N, 21), rad."""
        begun = np.clip(t_s - OPEN_S, 0.0, 1.0)[:, None]
        turn = 2.0 * np.pi * self.rate_hz * t_s[:, None] + self.phase_rad
        return self.amplitude_rad * begun * np.sin(turn)


@dataclass(frozen=True, slots=True)
class ScriptedMotion:
    """Joint angles over time by minimum jerk from one posture to the next.

    Attributes:
        name: Name of the movement.
        t_s: Instants of the postures, rising, shape (K,).
        joints_rad: Postures at those instants, shape (K, 21).
        sway: Wandering of the whole hand.
        tremor: Shaking of the joints, if any.

    Raises:
        Refused: Fewer than two postures, times that do not rise or values that are not finite.
    """

    name: str
    t_s: Float64
    joints_rad: Float64
    sway: Sway = Sway()
    tremor: Tremor | None = None

    def __post_init__(self) -> None:
        good = len(self.t_s) >= 2 and self.joints_rad.shape == (len(self.t_s), len(JOINTS))
        if not good or not bool((np.diff(self.t_s) > 0).all() and np.isfinite(self.joints_rad).all()):
            raise Refused(
                f"motion {self.name}",
                f"{len(self.t_s)} postures of shape {self.joints_rad.shape}",
                "two or more finite postures of 21 joints at rising times",
                "mend the script",
            )

    @property
    def duration_s(self) -> float:
        """Time of the last posture, s; the hand holds it afterwards."""
        return float(self.t_s[-1])

    def joints_at(self, t_s: Float64) -> Float64:
        """Joint angles at times (N,) in s, shape (N, 21)."""
        time = np.clip(t_s, self.t_s[0], self.t_s[-1])
        after = np.clip(np.searchsorted(self.t_s, time, side="right"), 1, len(self.t_s) - 1)
        share = (time - self.t_s[after - 1]) / (self.t_s[after] - self.t_s[after - 1])
        blend = (share**3 * (10.0 - 15.0 * share + 6.0 * share**2))[:, None]
        before = self.joints_rad[after - 1]
        smooth = before + blend * (self.joints_rad[after] - before)
        return smooth if self.tremor is None else smooth + self.tremor.at(t_s)


def posture(**angles_deg: float) -> Float64:
    """The open hand with some joints put elsewhere, degrees; DIP follows PIP unless named. Shape (21,)."""
    chosen = {**_OPEN_DEG, **angles_deg}
    angles = np.zeros(len(JOINTS))
    for name, value in chosen.items():
        if name not in JOINTS:
            raise Refused(
                "joint", repr(name), "one of the 21 joints", "name it as in sessions.records.JOINTS"
            )
        angles[JOINTS.index(name)] = np.deg2rad(value)
    coupled = couple_dip(angles)
    for name in angles_deg:
        coupled[JOINTS.index(name)] = angles[JOINTS.index(name)]
    return coupled


def scripted_motion(
    name: str,
    *,
    cycles: int = 3,
    period_s: float = 3.0,
    amplitude: float = 1.0,
    angle_deg: float = 40.0,
    sway: Sway | None = None,
) -> ScriptedMotion:
    """A movement by name.

    Args:
        name: One of MOTIONS.
        cycles: How often the hand goes there and back.
        period_s: Time of one cycle: out, a short hold, back, a short hold.
        amplitude: Share of the whole movement, 0 to 1.5 (``index_pip`` states its angle instead).
        angle_deg: For ``index_pip``: by how much the joint flexes from the open hand.
        sway: Wandering of the whole hand; by default small.

    Raises:
        Refused: Unknown name, or a value out of its bound.
    """
    _check(name, cycles, period_s, amplitude)
    home = posture()
    legs = [home + amplitude * (target - home) for target in _targets(name, angle_deg)]
    if name == "index_pip":
        legs = _targets(name, angle_deg)
    step_s = period_s / len(legs)
    times, postures = [0.0, OPEN_S], [home, home]
    for _ in range(cycles):
        for leg in legs:
            start = times[-1]
            times += [start + 0.4 * step_s, start + 0.5 * step_s, start + 0.9 * step_s, start + step_s]
            postures += [leg, leg, home, home]
    return ScriptedMotion(name, np.array(times), np.array(postures), sway or Sway())


def _targets(name: str, angle_deg: float) -> list[Float64]:
    """Postures that one cycle visits, each from the open hand and back."""
    if name == "open_close":
        return [posture(**_CLOSE_DEG)]
    if name == "index_pip":
        return [posture(index_pip=_OPEN_DEG["index_pip"] + angle_deg)]
    if name == "tapping":
        return [posture(**{f"{finger}_mcp_flexion": 40.0}) for finger in FINGERS]
    if name == "pinch":
        return [posture(**_PINCH_DEG)]
    if name == "spread":
        return [posture(**_SPREAD_DEG)]
    if name in MOVEMENTS:
        return [posture_rad(visited) for visited in MOVEMENTS[name]]
    return [posture()]


def _check(name: str, cycles: int, period_s: float, amplitude: float) -> None:
    if name not in MOTIONS:
        raise Refused("motion", repr(name), "one of " + ", ".join(MOTIONS), "choose one of them")
    if not 1 <= cycles <= 1000:
        raise Refused("cycles", str(cycles), "1 to 1000", "choose a number in that range")
    if not 0.5 <= period_s <= 60.0:
        raise Refused("cycle period", f"{period_s:g} s", "0.5 to 60 s", "choose a period in that range")
    if not 0.0 <= amplitude <= 1.5:
        raise Refused("amplitude", f"{amplitude:g}", "0 to 1.5", "choose a share in that range")
