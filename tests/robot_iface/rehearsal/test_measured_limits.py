"""What shipped limits refuse to a spastic hand, measured ones allow: it is led no farther than it goes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from robot_iface.motion.limits import clamp, limits_of
from robot_iface.rehearsal import rehearse, simulated_rig
from robot_iface.runtime import ScriptedInbox, Surroundings, perform
from robot_iface.runtime.sweep_reading import measured_range
from robot_iface.safety import shipped_limits
from robot_iface.sim import DRIVEN, device_capabilities
from robot_iface.types import (
    Float64,
    Limits,
    PatientTwin,
    PhaseChange,
    Plan,
    Prescription,
    ReferencePath,
    Sweep,
    TickBlock,
)

DEVICE = device_capabilities()
SHIPPED = shipped_limits(DRIVEN, DEVICE.q_min_rad, DEVICE.q_max_rad, spastic=True)
TWIN = PatientTwin("mas2")
POSTURES_DEG = {"open": (0.0, 0.0), "tabletop": (80.0, 0.0), "hook": (0.0, 95.0), "fist": (80.0, 95.0)}
DAY_NS = 86_400_000_000_000
FAR_NS = 4_000_000_000_000_000_000


class NeverPressed:
    def pressed(self) -> bool:
        return False


def posture(mcp_deg: float, pip_deg: float) -> Float64:
    of = {"mcp_flexion": mcp_deg, "pip": pip_deg}
    return np.deg2rad([10.0 if name.startswith("thumb") else of[name.split("_", 1)[1]] for name in DRIVEN])


def measured() -> Limits:
    goals = np.stack([posture(*angles) for angles in POSTURES_DEG.values()])
    sweep = Sweep("range", DRIVEN, "right", tuple(POSTURES_DEG), goals, speed_rad_s=0.35, active=False)
    plan = Plan("exoskeleton", None, Prescription("passive"), SHIPPED, TWIN, 1, "0", sweep=sweep)
    messages: list[Any] = []
    perform(plan, simulated_rig(plan), Surroundings(NeverPressed(), messages.append, ScriptedInbox()))
    blocks = [message for message in messages if isinstance(message, TickBlock)]
    phases = [message for message in messages if isinstance(message, PhaseChange)]
    result = measured_range(blocks, phases, sweep, SHIPPED, DEVICE)
    return limits_of(result, SHIPPED, measured_utc_ns=FAR_NS, expires_utc_ns=FAR_NS + DAY_NS, wrist_rad=0.0)


def opening(rest: Float64, opened: Float64) -> ReferencePath:
    """8 s to the open hand, 5 s there, 4 s back: slower than any limit."""
    t_s = np.linspace(0.0, 17.0, 171)
    u = np.clip(np.minimum(t_s / 8.0, (17.0 - t_s) / 4.0), 0.0, 1.0)[:, None]
    share = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
    return ReferencePath(DRIVEN, t_s, rest + share * (opened - rest), "0" * 64, "right")


def test_a_held_opening_is_refused_within_shipped_limits_and_plays_within_measured_ones() -> None:
    rest, wanted = posture(42.0, 48.0), posture(8.0, 12.0)
    ordered = Prescription("passive", speed=1.0, repetitions=1, hold_s=0.0)
    plan = Plan("exoskeleton", opening(rest, wanted), ordered, SHIPPED, TWIN, 1, "0")
    refused = rehearse(plan)
    assert not refused.accepted
    assert "held-stretch" in refused.summary

    limits = measured()
    inner = replace(limits, q_min_rad=limits.q_min_rad + 0.01, q_max_rad=limits.q_max_rad - 0.01)
    ends = clamp(np.stack([rest, wanted]), DRIVEN, inner)
    today = rehearse(replace(plan, path=opening(ends[0], ends[1]), limits=limits))
    assert today.accepted, today.summary
    share = np.array(today.peak_interaction_nm) / limits.tau_interaction_nm
    assert share.max() < 0.5
    assert ends[1][DRIVEN.index("index_mcp_flexion")] < rest[DRIVEN.index("index_mcp_flexion")] - 0.1
