"""The fingertip impedance law: springs and dampers at the fingertips, and a weak one at the joints."""

from __future__ import annotations

import math

import numpy as np

from robot_iface.compiled import compiled
from robot_iface.control.chain import Chain, digit_kinematics
from robot_iface.control.coupling import Coupling
from robot_iface.control.gains import DAMPING_RATIO, FINGERTIP_N_M, TIP_MASS_KG, weak_joint_gains
from robot_iface.control.goal import Goal
from robot_iface.control.kernels import dress, saturated
from robot_iface.types import CommandMode, DeviceCommand, DeviceState, Float64, Int64, Limits


class FingertipLaw:
    """tau = J'[Kx (x_d - x) + Dx J (dq_d - dq)] + Kq (q_d - q) + Dq (dq_d - dq) + tau_ff.

    Kx is 100 N/m at multiple 1, Dx = 2 zeta sqrt(0.06 kg Kx); Kq = 0.03 Nm/rad holds what the tip does not
    feel: the straight finger is singular. The spring's torque saturates per joint at 0.9 of the interaction
    limit.

    A device knows joint springs only. Each joint is given K = diag(J' Kx J) + Kq and D alike, which its own
    loop closes without delay, and a desired position and speed at which these give just the torque above:
    what couples the joints moves the set-point, tick by tick. So the command says at the present state what
    the motors will do, to the supervisor's clamp and to the record, and the feed-forward stays what it is.

    Args:
        chain: Which joint moves which fingertip.
        limits: Limits of the driven joints.
        period_s: Control period.
    """

    def __init__(self, chain: Chain, limits: Limits, period_s: float = 1e-3) -> None:
        joints = limits.tau_interaction_nm.size
        self._chain = chain
        self._coupling = Coupling(weak_joint_gains(joints), limits, period_s)
        self._shape = (5, joints)
        self._work: Float64 = np.zeros((2, 6, 3))
        still: Float64 = np.zeros(joints)
        self._fill(np.zeros(self._shape), (still,) * 7, (0.0, 0.0, 0.0))  # compiles it

    def command(self, state: DeviceState, goal: Goal, ramp: float, seq: int) -> DeviceCommand:
        """The request of one tick.

        Args:
            state: Newest reading.
            goal: What is asked for; a digit is as stiff as the softest of its joints.
            ramp: 0 to 1, from ``Supervisor.ramp``: gains and feed-forward rise with it.
            seq: Number of the command.

        Returns:
            An impedance command.
        """
        setpoint = goal.setpoint
        rows: Float64 = np.empty(self._shape)
        seen = (state.q_rad, state.dq_rad_s, state.tau_interaction_nm)
        wanted = (setpoint.q_rad, setpoint.dq_rad_s, goal.multiple, goal.tau_ff_nm)
        self._fill(rows, seen + wanted, (ramp, goal.feedback, goal.opposition))
        return DeviceCommand(CommandMode.IMPEDANCE, rows[0], rows[1], rows[2], rows[3], rows[4], seq)

    def _fill(self, rows: Float64, given: tuple[Float64, ...], asked: tuple[float, float, float]) -> None:
        chain, coupling = self._chain, self._coupling
        knobs = coupling.asked(*asked)
        q, dq, load, q_d, dq_d, multiple, tau_ff = given
        fingertip_impedance(
            rows, q, dq, q_d, dq_d, multiple, coupling.table, asked[0], chain.joint, chain.links, self._work
        )
        finish(rows, q, dq, load, tau_ff, coupling.table, knobs)


@compiled
def fingertip_impedance(
    out: Float64,
    q_rad: Float64,
    dq_rad_s: Float64,
    q_desired_rad: Float64,
    dq_desired_rad_s: Float64,
    multiple: Float64,
    table: Float64,
    ramp: float,
    joint: Int64,
    links: Float64,
    work: Float64,
) -> None:
    """Torques of the springs (row 0) and dampers (row 1), and each joint's K (row 3) and D (row 4).

    Args:
        out: The command, (5, J).
        q_rad: Measured positions, (J,).
        dq_rad_s: Measured speeds, (J,).
        q_desired_rad: Desired positions, (J,).
        dq_desired_rad_s: Desired speeds, (J,).
        multiple: Stiffness multiples, (J,).
        table: ``Coupling.table``; K and D are those of the weak joint spring.
        ramp: Share of everything.
        joint: ``Chain.joint``.
        links: ``Chain.links``.
        work: Room for the kinematics of a digit at both postures, (2, 6, 3).
    """
    for column in range(q_rad.size):
        scale = multiple[column] * ramp
        out[3, column] = table[0, column] * scale
        out[4, column] = table[1, column] * math.sqrt(scale)
        out[0, column] = out[3, column] * (q_desired_rad[column] - q_rad[column])
        out[1, column] = out[4, column] * (dq_desired_rad_s[column] - dq_rad_s[column])
    for digit in range(joint.shape[0]):
        lowest = math.inf
        for slot in range(5):
            if joint[digit, slot] >= 0:
                lowest = min(lowest, float(multiple[joint[digit, slot]]))
        if lowest < math.inf:
            digit_kinematics(q_rad, joint, links, digit, work[0])
            digit_kinematics(q_desired_rad, joint, links, digit, work[1])
            _add_digit(out, dq_rad_s, dq_desired_rad_s, lowest * ramp, joint[digit], work)


@compiled
def _add_digit(
    out: Float64, dq_rad_s: Float64, dq_desired_rad_s: Float64, scale: float, joint: Int64, work: Float64
) -> None:
    """Add the spring and the damper at the tip of a digit whose slots are driven by ``joint``, (5,)."""
    here, there = work[0], work[1]
    stiffness = FINGERTIP_N_M * scale
    damping = 2.0 * DAMPING_RATIO * math.sqrt(TIP_MASS_KG * stiffness)
    for axis in range(3):
        speed = 0.0
        for slot in range(5):
            if joint[slot] >= 0:
                speed += there[1 + slot, axis] * dq_desired_rad_s[joint[slot]]
                speed -= here[1 + slot, axis] * dq_rad_s[joint[slot]]
        spring_n = stiffness * (there[0, axis] - here[0, axis])
        for slot in range(5):
            if joint[slot] >= 0:
                arm = here[1 + slot, axis]
                out[0, joint[slot]] += arm * spring_n
                out[1, joint[slot]] += arm * damping * speed
                out[3, joint[slot]] += arm * stiffness * arm
                out[4, joint[slot]] += arm * damping * arm


@compiled
def finish(
    out: Float64,
    q_rad: Float64,
    dq_rad_s: Float64,
    tau_interaction_nm: Float64,
    tau_ff_nm: Float64,
    table: Float64,
    asked: tuple[float, float, float, float, float],
) -> None:
    """Saturate the springs, express torques as the position and speed at which K and D give them, and dress.

    Args:
        out: The command with torques in rows 0 and 1, (5, J).
        q_rad: Measured positions, (J,).
        dq_rad_s: Measured speeds, (J,).
        tau_interaction_nm: Measured interaction torques, (J,).
        tau_ff_nm: Feed-forward, (J,).
        table: See ``kernels.dress``.
        asked: See ``kernels.dress``.
    """
    for column in range(q_rad.size):
        stiffness, damping = out[3, column], out[4, column]
        error = out[0, column] / stiffness if stiffness > 0.0 else 0.0
        out[0, column] = q_rad[column] + saturated(error, stiffness, table[2, column])
        out[1, column] = dq_rad_s[column] + (out[1, column] / damping if damping > 0.0 else 0.0)
        out[2, column] = tau_ff_nm[column] * asked[0]
    dress(out, dq_rad_s, tau_interaction_nm, table, asked)
