"""What the supervisor makes of spasms, stops, faults and doubled gains, beside no supervisor at all."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from robot_iface.control import FingertipLaw, ImpedanceLaw, hand_chain, thesis_gains
from robot_iface.errors import Refused
from robot_iface.kinematics import average_hand
from robot_iface.safety import Watch
from robot_iface.sim import DRIVEN
from robot_iface.types import CommandMode, DeviceCommand, SafetyState, Space, VirtualKind
from tests.bench.motion.table import Row, at_most, beside
from tests.hazards import test_flexor_spasm as spasms
from tests.hazards import test_stop as stops
from tests.robot_iface.control import test_stability as stability
from tests.robot_iface.safety import rigid_hand as rigid
from tests.robot_iface.safety import test_fault_table as faults

HANDS: tuple[VirtualKind, ...] = ("healthy", "flaccid", "mas2")
STIFF: tuple[VirtualKind, ...] = ("mas2", "mas3", "contracture")
NOISE_RAD_S = 0.05
_ZEROS = np.zeros(12)
_STILL = DeviceCommand(CommandMode.IMPEDANCE, _ZEROS, _ZEROS, _ZEROS, _ZEROS, _ZEROS, 0)


def spasm_rows() -> list[Row]:
    """Worst ratios of peak speed and torque over the map of spasms, opening and closing, rigid hand."""
    speeds, torques, opens = [], [], 0
    module: Any = rigid
    for size_nm, duration_s, clonus_hz in spasms.MAP:
        for phase in (spasms.OPENING, spasms.CLOSING):
            effort = spasms.spasm(size_nm, duration_s, clonus_hz)
            rig = spasms.supervised(rigid, effort, phase, duration_s)
            after = [
                (state, outcome)
                for state, outcome in zip(
                    rig.states[rig.spasm_tick :], rig.outcomes[rig.spasm_tick :], strict=True
                )
                if outcome.powered
            ]
            speed, torque = spasms.unsupervised(module, size_nm, duration_s, clonus_hz, phase)
            speeds.append(float(np.abs([state.dq_rad_s for state, _ in after]).max()) / speed)
            torques.append(float(np.abs([state.tau_interaction_nm for state, _ in after]).max()) / torque)
            opens += sum(_opens(state, outcome) for state, outcome in after)
    count = f"{len(speeds)} spasms, opening and closing"
    return [
        at_most(f"{count}: worst peak speed / unsupervised", max(speeds), 1.0),
        at_most(f"{count}: worst peak torque / unsupervised", max(torques), 1.0),
        beside("the same, median speed / torque", f"{np.median(speeds):.2f} / {np.median(torques):.2f}"),
        Row(
            "ticks in which a spring opens a closing hand once the supervisor acts",
            "0",
            "",
            f"{opens}",
            not opens,
        ),
    ]


def _opens(state: Any, outcome: Any) -> bool:
    if not outcome.reversing and outcome.safety_state < SafetyState.COMPLIANT:
        return False
    command = outcome.applied
    spring = command.stiffness_nm_rad * (command.q_rad - state.q_rad) + command.tau_ff_nm
    closes = state.dq_rad_s > np.deg2rad(5.0)
    clamped = np.abs(outcome.applied_tau_nm) < np.abs(outcome.requested_tau_nm)
    return bool((spring[closes & ~clamped] < -1e-9).any())


def stop_rows() -> list[Row]:
    """Peak speed of a held-open stiff hand after a stop, beside that of power off."""
    rows = [_mujoco_stop(kind) for kind in STIFF]
    braked = rigid.stretch()
    braked.button.down = True
    stopped = rigid.peak_speed_deg_s(braked, 600)
    cut = rigid.stretch()
    cut.hand.power_off()
    peak = 0.0
    for _ in range(600):
        cut.hand.step()
        peak = max(peak, float(np.rad2deg(np.abs(cut.hand.dq).max())))
    return [*rows, at_most("e-stop of a held-open hand / power off, rigid hand", stopped / peak, 0.5, 0.25)]


def _mujoco_stop(kind: VirtualKind) -> Row:
    button = rigid.Button()
    robot, supervisor = stops.held_open(kind, button)
    button.down = True
    supervisor.read(robot.read().t_ns)
    supervisor.write(_STILL, Watch())
    braked = stops.snap_rad_s(robot, 600)
    robot, _ = stops.held_open(kind, rigid.Button())
    robot.power_off()
    free = stops.snap_rad_s(robot, 600)
    return at_most(f"e-stop of a held-open hand / power off, {kind}, MuJoCo", braked / free, 0.5, 0.25)


def fault_row() -> Row:
    """Rows of the fault table that reach their state in time, and the worst share of a deadline taken."""
    passed, worst = 0, 0.0
    for _, spoil, state, deadline in faults.ROWS:
        ticks = _ticks_to(spoil, state, deadline)
        passed += ticks is not None
        worst = max(worst, (ticks or np.inf) / deadline)
    measured = f"{passed} of {len(faults.ROWS)}, worst takes {worst:.2f} of its deadline"
    return Row("fault table: rows that reach their state in time", "all", "", measured, worst <= 1.0)


def _ticks_to(spoil: Any, state: SafetyState, deadline: int) -> int | None:
    limits = rigid.Rig().limits
    if spoil is faults.too_strong:
        limits = dataclasses.replace(limits, power_w=0.01)
    rig = rigid.Rig(ramp_s=0.05, limits=limits, stiffness=0.1)
    rig.go_active()
    rig.glide(-0.2, 0.6)
    rig.speed = np.full(3, -0.2)
    spoil(rig)
    try:
        return rig.ticks_until(state, deadline)
    except (AssertionError, Refused):
        return None


def stability_rows() -> list[Row]:
    """Speed that is left of a kick at twice and three times the shipped gains with an extra tick of delay."""
    return [_kicked(times, space) for times in (2.0, 3.0) for space in ("joint", "fingertip")]


def _kicked(times: float, space: Space) -> Row:
    left = 0.0
    worn_or_not: list[tuple[VirtualKind, bool]] = [*((kind, True) for kind in HANDS), ("flaccid", False)]
    for kind, worn in worn_or_not:
        tip = FingertipLaw(hand_chain(DRIVEN, average_hand()), stability.LIMITS)
        law = tip if space == "fingertip" else ImpedanceLaw(thesis_gains(DRIVEN), stability.LIMITS)
        speeds = stability.speeds_after_a_kick(law, kind, stability.SHIPPED * times, 1, worn=worn)
        left = max(left, float(np.abs(speeds[-300:]).max()))
    what = f"speed left 1.1 s after a kick, {times:g}x the shipped gains, one extra tick, {space}"
    return Row(
        what, "stable" if times == 2.0 else "", "stable", f"{left:.3f} rad/s (noise)", left < NOISE_RAD_S
    )


def guard_rows() -> list[Row]:
    """All of them."""
    return [*spasm_rows(), *stability_rows(), *stop_rows(), fault_row()]
