"""False starts of the trigger over strength and length of a spasm, on a small joint model.

Each joint is one inertia (rotor, link, finger) between the device's spring and damper while it cues and the
patient's passive ones; a disturbance pushes it. ``tests/robot_iface/control/test_trigger.py`` holds it
against the simulated exoskeleton. The map of docs/trigger.md is printed by
``python -m tests.bench.motion.trigger_map``.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Literal

import numpy as np

from robot_iface.compiled import compiled
from robot_iface.control import Start, StartTrigger, thesis_gains
from robot_iface.control.trigger import judge
from robot_iface.types import FINGERS, Float64

NAMES: tuple[str, ...] = (
    *("thumb_cmc_flexion", "thumb_cmc_abduction", "thumb_mcp_flexion", "thumb_ip"),
    *(f"{finger}_{joint}" for finger in FINGERS for joint in ("mcp_flexion", "pip")),
)
PERIOD_S = 1e-3
SETTLE_S = 1.0
CUE_MULTIPLE = 0.3
INERTIA_KG_M2 = 3.6e-4
DAMPING_NMS_RAD = 2.1e-3
ENCODER_STD_RAD = 2e-4
STIFFNESS_NM_RAD = {"flaccid": 0.015, "healthy": 0.04, "mas1+": 0.09, "mas2": 0.52, "mas3": 0.64}

Kind = Literal["rest", "tremor", "clonus", "beats", "spasm", "one finger"]
KINDS: tuple[Kind, ...] = ("rest", "tremor", "clonus", "beats", "spasm", "one finger")
"""Clonus pushes both ways, beats are spasms that come and go 5 to 7 times a second."""


@dataclass(frozen=True, slots=True)
class Push:
    """A disturbance of one trial.

    Attributes:
        size_nm: Torque on each joint concerned; positive in the cued direction.
        start_s: Since the cue.
        duration_s: How long.
        rate_hz: Frequency of what comes and goes, 0 for none.
        both_ways: Whether it swings about zero.
        joints: Share of the torque on each joint, (J,).
        phase_rad: Phase of each joint, (J,).
    """

    size_nm: float
    start_s: float
    duration_s: float
    rate_hz: float
    both_ways: bool
    joints: Float64
    phase_rad: Float64


@compiled
def trial(
    push_nm: Float64,
    stiffness: Float64,
    damping: Float64,
    noise_rad: Float64,
    weights: Float64,
    posts: Float64,
    past: Float64,
    kept: Float64,
    times: tuple[int, int, int, int, int],
    keep: float,
) -> tuple[int, int]:
    """Advance joints and trigger through torques (ticks, J); returns the start and its tick."""
    q, dq, read = np.zeros(weights.size), np.zeros(weights.size), np.zeros(weights.size)
    now = 0
    for tick in range(push_nm.shape[0]):
        for joint in range(q.size):
            tau = push_nm[tick, joint] - stiffness[joint] * q[joint]
            dq[joint] = (dq[joint] + PERIOD_S / INERTIA_KG_M2 * tau) / (
                1.0 + PERIOD_S / INERTIA_KG_M2 * damping[joint]
            )
            q[joint] += PERIOD_S * dq[joint]
            read[joint] = q[joint] + noise_rad[tick % noise_rad.shape[0], joint]
        now = judge(read, weights, posts, past, kept, times, keep)
        if now >= 2:
            return now, tick
    return now, push_nm.shape[0]


def torques(push: Push, seconds: float) -> Float64:
    """What a push does to each joint from the begin of settling on, (ticks, J)."""
    ticks = round((SETTLE_S + seconds) / PERIOD_S)
    t_s: Float64 = np.arange(ticks, dtype=np.float64) * PERIOD_S - SETTLE_S
    there = (t_s >= push.start_s) & (t_s < push.start_s + push.duration_s)
    shape: Float64 = np.ones((ticks, push.joints.size))
    if push.rate_hz > 0.0:
        turns_rad: Float64 = 2.0 * np.pi * push.rate_hz * (t_s - push.start_s)
        swing: Float64 = np.sin(turns_rad[:, None] + push.phase_rad)
        shape = swing if push.both_ways else np.where(swing > 0.0, 1.0, 0.0)
    return push.size_nm * there[:, None] * shape * push.joints


def start_under(
    push: Push, stiffness_nm_rad: float, rng: np.random.Generator, seconds: float = 6.0
) -> tuple[Start, float]:
    """How a cue ends for a hand that wants nothing, and when, in seconds since the cue.

    Args:
        push: What disturbs it.
        stiffness_nm_rad: Passive stiffness of each of its joints.
        rng: Source of the sensors' noise.
        seconds: How long after the cue it is watched.
    """
    gains = thesis_gains(NAMES).scaled(CUE_MULTIPLE)
    trigger = StartTrigger(np.ones(len(NAMES)), PERIOD_S, 2.0 * seconds)
    state = trigger.arrays()
    noise = rng.normal(0.0, ENCODER_STD_RAD, (997, len(NAMES)))
    stiffness, damping = gains.stiffness_nm_rad + stiffness_nm_rad, gains.damping_nms_rad + DAMPING_NMS_RAD
    now, tick = trial(torques(push, seconds), stiffness, damping, noise, *state)
    return Start(now), (tick + 1) * PERIOD_S - SETTLE_S


def short_push(kind: Kind, rng: np.random.Generator) -> Push:
    """A disturbance that must never be a start: at most 0.05 Nm, a spasm at most 0.2 s long."""
    every = np.ones(len(NAMES))
    phase = rng.uniform(0.0, 2.0 * np.pi, len(NAMES))
    size, start_s = rng.uniform(0.005, 0.05), rng.uniform(-0.6, 5.0)
    if kind == "rest":
        return Push(0.0, 0.0, 0.0, 0.0, False, every, phase)
    if kind == "tremor":
        mcp = np.array([1.0 if name.endswith("mcp_flexion") else 0.0 for name in NAMES])
        return Push(size, -1.0, 9.0, rng.uniform(4.0, 8.0), True, mcp, phase)
    if kind in ("clonus", "beats"):
        together = np.full(len(NAMES), phase[0])
        way = 1.0 if rng.random() < 0.7 else -1.0
        return Push(
            way * size,
            start_s,
            rng.uniform(0.3, 3.0),
            rng.uniform(5.0, 7.0),
            kind == "clonus",
            every,
            together,
        )
    way = 1.0 if rng.random() < 0.7 else -1.0
    if kind == "one finger":
        finger = FINGERS[int(rng.integers(4))]
        alone = np.array([1.0 if name.startswith(finger) else 0.0 for name in NAMES])
        return Push(way * 10.0 * size, start_s, rng.uniform(0.1, 3.0), 0.0, False, alone, phase)
    return Push(way * size, start_s, rng.uniform(0.02, 0.2), 0.0, False, every, phase)


def false_starts(kind: Kind, trials: int, seed: int) -> int:
    """How many of the trials with such a disturbance end in a start that nobody intended."""
    rng = np.random.default_rng(seed)
    hands = list(STIFFNESS_NM_RAD.values())
    count = 0
    for _ in range(trials):
        push, hand = short_push(kind, rng), hands[int(rng.integers(len(hands)))]
        count += start_under(push, hand, rng)[0] is Start.PATIENT
    return count


SIZES_NM = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.9)
DURATIONS_S = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.6, 1.0, 3.0)


def share_of_false_starts(hand: str, size_nm: float, duration_s: float, trials: int, seed: int) -> float:
    """Share of spasms of all joints, at a random time 0 to 4 s after the cue, that are taken for a start."""
    rng = np.random.default_rng(seed)
    every, still = np.ones(len(NAMES)), np.zeros(len(NAMES))
    count = 0
    for _ in range(trials):
        push = Push(size_nm, rng.uniform(0.0, 4.0), duration_s, 0.0, False, every, still)
        count += start_under(push, STIFFNESS_NM_RAD[hand], rng)[0] is Start.PATIENT
    return count / trials


def map_lines(hand: str, trials: int, seed: int) -> list[str]:
    """The map of one hand as the rows of a table."""
    head = f"| {hand}: Nm \\ s | " + " | ".join(f"{duration:g}" for duration in DURATIONS_S) + " |"
    lines = [head, "|---" * (len(DURATIONS_S) + 1) + "|"]
    for size in SIZES_NM:
        shares = [share_of_false_starts(hand, size, duration, trials, seed) for duration in DURATIONS_S]
        lines.append(f"| {size:g} | " + " | ".join(f"{100 * share:.0f}" for share in shares) + " |")
    return lines


def main() -> None:
    """Print the maps of docs/trigger.md."""
    for kind in KINDS:
        sys.stdout.write(f"{kind}: {false_starts(kind, 1000, 7100)} false starts in 1000 trials\n")
    for hand in ("healthy", "mas2"):
        sys.stdout.write("\n" + "\n".join(map_lines(hand, 40, 7200)) + "\n")


if __name__ == "__main__":
    main()
