"""What assistance computes in every tick, compiled."""

from __future__ import annotations

from robot_iface.compiled import compiled
from robot_iface.types import Float64, Int64


@compiled
def aim(
    now: Float64,
    by_digit: Float64,
    digit: Int64,
    dq_desired_rad_s: Float64,
    turn: bool,
    moving_rad_s: float,
    slew: float,
    out: Float64,
) -> None:
    """Go one tick towards the multiple of the direction of movement.

    Args:
        now: Present multiple, its target, and whether a joint flexes, (3, J); updated.
        by_digit: Multiples into extension and flexion, (2, 5).
        digit: Digit of each joint, (J,).
        dq_desired_rad_s: Desired speed, (J,).
        turn: Whether this tick looks where the movement goes.
        moving_rad_s: Slower is no direction.
        slew: Most change in a tick.
        out: The present multiple, (J,).
    """
    for joint in range(digit.size):
        if turn:
            if abs(dq_desired_rad_s[joint]) >= moving_rad_s:
                now[2, joint] = 1.0 if dq_desired_rad_s[joint] > 0.0 else 0.0
            now[1, joint] = by_digit[1 if now[2, joint] > 0.5 else 0, digit[joint]]
        step = now[1, joint] - now[0, joint]
        now[0, joint] += min(max(step, -slew), slew)
        out[joint] = now[0, joint]


@compiled
def note(
    dq_desired_rad_s: Float64,
    error_rad: Float64,
    dq_rad_s: Float64,
    tau_interaction_nm: Float64,
    seen: Float64,
    stuck: Float64,
    bounds: tuple[float, float, float, float],
) -> None:
    """Add a tick to what a repetition is judged by.

    Args:
        dq_desired_rad_s: Desired speed, (J,).
        error_rad: q_d - q, (J,).
        dq_rad_s: Measured speed, (J,).
        tau_interaction_nm: Torque on the patient, (J,).
        seen: Sum of how far behind, sum of the push in the direction, count, and whether blocked, each into
            extension and flexion, (4, 2, J); updated.
        stuck: How many such ticks a joint has stood still, and the push when that began, (2, J); updated.
        bounds: Speeds of moving and of standing still, ticks after which still is blocked, rise of the push.
    """
    moving_rad_s, slow_rad_s, blocked_after, rise_nm = bounds
    for joint in range(error_rad.size):
        wanted = dq_desired_rad_s[joint]
        row, way = (1, 1.0) if wanted > 0.0 else (0, -1.0)
        push = tau_interaction_nm[joint] * way
        if abs(wanted) > moving_rad_s:
            seen[0, row, joint] += max(error_rad[joint] * way, 0.0)
            seen[1, row, joint] += push
            seen[2, row, joint] += 1.0
        if stuck[0, joint] == 0.0:
            stuck[1, joint] = push
        still = abs(wanted) > max(slow_rad_s, moving_rad_s) and dq_rad_s[joint] * way < slow_rad_s
        stuck[0, joint] = stuck[0, joint] + 1.0 if still else 0.0
        if stuck[0, joint] >= blocked_after and push > stuck[1, joint] + rise_nm:
            seen[3, row, joint] = 1.0
