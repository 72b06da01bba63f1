"""What a real device is told each tick, as compiled arithmetic. Arrays are (J,) unless said otherwise."""

from __future__ import annotations

from robot_iface.compiled import compiled
from robot_iface.types import Float64


@compiled
def impedance_torque(
    goal: Float64,
    q_rad: Float64,
    dq_rad_s: Float64,
    cap_nm: Float64,
    torque_nm: Float64,
) -> bool:
    """Compute tau = K (q_d - q) + D (dq_d - dq) + tau_ff within the motor caps, into ``torque_nm``.

    Args:
        goal: Rows q_d rad, dq_d rad/s, tau_ff Nm, K Nm/rad, D Nms/rad, (5, J).
        q_rad: Measured positions.
        dq_rad_s: Measured velocities.
        cap_nm: Motor caps.
        torque_nm: Result; zero wherever the sum is no number.

    Returns:
        Whether every torque is a number.
    """
    sound = True
    for joint in range(torque_nm.size):
        torque = goal[3, joint] * (goal[0, joint] - q_rad[joint])
        torque += goal[4, joint] * (goal[1, joint] - dq_rad_s[joint]) + goal[2, joint]
        cap = cap_nm[joint]
        if torque != torque:
            sound = False
            torque = 0.0
        torque_nm[joint] = min(max(torque, -cap), cap)
    return sound
