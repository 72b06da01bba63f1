"""Numeric heart of the control laws, compiled: one call a tick, no array made on the way.

Every function fills rows of ``out``, (5, J): desired position, desired speed, feed-forward torque, stiffness,
damping of the command. What both laws share on top of their spring and damper is ``dress``: torque feedback
(transparent) and opposition (resistive).
"""

from __future__ import annotations

import math

from robot_iface.compiled import compiled
from robot_iface.types import Float64

SMALL_NM_RAD = 1e-9
"""Keeps a spring without stiffness from being divided by."""
SLOW_RAD_S = 0.1
"""Speed at which opposition has three quarters of its size, if its damping can be that high."""


@compiled
def dress(
    out: Float64,
    dq_rad_s: Float64,
    tau_interaction_nm: Float64,
    table: Float64,
    asked: tuple[float, float, float, float, float],
) -> None:
    """Add feedback and opposition to a command.

    Feedback takes a share of the low-passed interaction torque off the patient, bounded in size and rate.
    Opposition is a damper D(dq) = o tanh(|dq| / v0) / |dq|: its torque never has the sign of the speed.

    Args:
        out: The command, (5, J), with spring, damper and feed-forward filled in.
        dq_rad_s: Measured speeds, (J,).
        tau_interaction_nm: Measured interaction torques, (J,).
        table: ``Coupling.table``, (8, J); the last two rows are updated.
        asked: ramp, feedback, opposition, share kept by the low-pass, most change of feedback in a tick.
    """
    ramp, feedback, opposition, keep, step = asked
    for joint in range(dq_rad_s.size):
        load, felt, given = tau_interaction_nm[joint], table[6, joint], table[7, joint]
        if math.isfinite(load):
            felt = keep * felt + (1.0 - keep) * load
            table[6, joint] = felt
        most = table[3, joint]
        wanted = min(max(-feedback * felt, -most), most)
        given += min(max(wanted - given, -step), step)
        table[7, joint] = given
        out[2, joint] += given * ramp
    if opposition > 0.0:
        for joint in range(dq_rad_s.size):
            oppose_nm = opposition * ramp * table[4, joint]
            v0 = max(SLOW_RAD_S, oppose_nm / table[5, joint])
            turn = abs(dq_rad_s[joint]) / v0
            extra = oppose_nm / v0 * (math.tanh(turn) / turn if turn > 1e-6 else 1.0)
            before = out[4, joint]
            out[4, joint] = before + extra
            out[1, joint] *= before / (before + extra + SMALL_NM_RAD)


@compiled
def saturated(error_rad: float, stiffness_nm_rad: float, most_nm: float) -> float:
    """The error at which a spring gives at most ``most_nm``; the error itself where it does not give more."""
    tau_nm = stiffness_nm_rad * error_rad
    if tau_nm > most_nm:
        return most_nm / stiffness_nm_rad
    if tau_nm < -most_nm:
        return -most_nm / stiffness_nm_rad
    return error_rad


@compiled
def joint_impedance(
    out: Float64,
    q_rad: Float64,
    dq_rad_s: Float64,
    tau_interaction_nm: Float64,
    q_desired_rad: Float64,
    dq_desired_rad_s: Float64,
    multiple: Float64,
    tau_ff_nm: Float64,
    table: Float64,
    asked: tuple[float, float, float, float, float],
) -> None:
    """Joint spring and damper, the spring saturated.

    Args:
        out: The command, (5, J).
        q_rad: Measured positions, (J,).
        dq_rad_s: Measured speeds, (J,).
        tau_interaction_nm: Measured interaction torques, (J,).
        q_desired_rad: Desired positions, (J,).
        dq_desired_rad_s: Desired speeds, (J,).
        multiple: Stiffness multiples, (J,).
        tau_ff_nm: Feed-forward, (J,).
        table: See ``dress``.
        asked: See ``dress``.
    """
    ramp = asked[0]
    for joint in range(q_rad.size):
        share = multiple[joint] * ramp
        stiffness = table[0, joint] * share
        error = q_desired_rad[joint] - q_rad[joint]
        out[0, joint] = q_rad[joint] + saturated(error, stiffness, table[2, joint])
        out[1, joint] = dq_desired_rad_s[joint]
        out[2, joint] = tau_ff_nm[joint] * ramp
        out[3, joint] = stiffness
        out[4, joint] = table[1, joint] * math.sqrt(share)
    dress(out, dq_rad_s, tau_interaction_nm, table, asked)
