"""Compiled numerics of a task: stiffness, feed-forward and set-point change gently or follow the patient."""

from __future__ import annotations

import math

from robot_iface.compiled import compiled
from robot_iface.safety.hull_kernels import nearest_in
from robot_iface.types import Float64, Int64

MULTIPLE, TAU, AHEAD = 0, 1, 2
"""Rows of the working table: stiffness multiple, feed-forward torque, lead that is left to the patient."""
_MOVING_RAD = 1e-3
_SMALL = 1e-9


@compiled
def ease(
    table: Float64,
    fixed: Float64,
    q_rad: Float64,
    goal_rad: Float64,
    wanted: Float64,
    wanted_nm: Float64,
    multiple_step: float,
    spring_step_nm: float,
    tau_step_nm: float,
) -> None:
    """Take stiffness and feed-forward one tick towards what is wanted.

    The torque of an unsaturated spring changes by at most ``spring_step_nm`` where its stiffness does.

    Args:
        table: Multiple and feed-forward, changed in place, (3, J).
        fixed: Gains at multiple 1, torque at which the spring saturates, largest step of the lead towards the
            path, ends of today's range, (5, J).
        q_rad: Measured angles, (J,).
        goal_rad: Set-point, (J,).
        wanted: Wanted multiple, (J,).
        wanted_nm: Wanted feed-forward, (J,).
        multiple_step: Largest step of the multiple.
        spring_step_nm: Largest step of the spring's torque.
        tau_step_nm: Largest step of the feed-forward.
    """
    for joint in range(q_rad.shape[0]):
        multiple = table[0, joint]
        per_multiple = fixed[0, joint] * abs(goal_rad[joint] - q_rad[joint])
        step = multiple_step
        if multiple * per_multiple <= fixed[1, joint]:
            step = min(spring_step_nm / (per_multiple + _SMALL), multiple_step)
        table[0, joint] = multiple + min(max(wanted[joint] - multiple, -step), step)
        tau = table[1, joint]
        table[1, joint] = tau + min(max(wanted_nm[joint] - tau, -tau_step_nm), tau_step_nm)


@compiled
def lead(
    table: Float64,
    fixed: Float64,
    q_rad: Float64,
    goal_rad: Float64,
    heading: Float64,
    sign: float,
    step_rad: float,
    most_rad: float,
    out: Float64,
) -> None:
    """Move the set-point to a patient who is ahead on the path, and back gently.

    Which way is ahead turns over where the path does; without bounded steps the torque would jump there.

    Args:
        table: The lead, changed in place, (3, J).
        fixed: Bounds as for ``ease``, (5, J).
        q_rad: Measured angles, (J,).
        goal_rad: Set-point on the path, (J,).
        heading: Where the path is going, (J,); zero leads back to the path.
        sign: 1 on the way, -1 on the way back.
        step_rad: Largest step towards the patient.
        most_rad: Largest lead along the path.
        out: Is filled with the moved set-point, (J,).
    """
    joints = q_rad.shape[0]
    square, along = 0.0, 0.0
    for joint in range(joints):
        square += heading[joint] * heading[joint]
        along += sign * heading[joint] * (goal_rad[joint] - q_rad[joint])
    length = math.sqrt(square)
    share = 0.0
    if length >= _MOVING_RAD and along < 0.0:
        share = -max(along / length, -most_rad) / length
    for joint in range(joints):
        now = table[2, joint]
        wanted = sign * heading[joint] * share
        change = wanted - now
        returns = change * now < 0.0
        most = fixed[2, joint] if returns else step_rad
        table[2, joint] = now + min(max(change, -most), most)
        out[joint] = goal_rad[joint] + table[2, joint]


@compiled
def let_go(
    table: Float64,
    fixed: Float64,
    pairs: Int64,
    corners: Float64,
    q_rad: Float64,
    dq_rad_s: Float64,
    wall_nm_rad: float,
    wall_rad: float,
    swift_rad_s: float,
    swift_multiple: float,
    swift_step: float,
    out: Float64,
) -> None:
    """No goal but the ends of today's range, which stand there like soft walls.

    A wall pushes towards the nearest point of the range with a spring that hardens with the way into it. Its
    stiffness is alike for the joints of a pair, so its torque is the gradient of a potential: it gives back
    no more than it was given.

    Args:
        table: Multiple, feed-forward and lead, changed in place, (3, J).
        fixed: Bounds as for ``ease``, (5, J).
        pairs: Coupled ranges: first and second joint, first corner, corner after the last, (H, 4).
        corners: Corners of all coupled ranges, (C, 2).
        q_rad: Measured angles, (J,).
        dq_rad_s: Measured speeds, (J,).
        wall_nm_rad: Stiffness of a wall, ``wall_rad`` inside it.
        wall_rad: Depth.
        swift_rad_s: Speed above which a joint inside the range is damped.
        swift_multiple: Multiple whose damping it has at twice that speed; there is no spring to it.
        swift_step: Largest step of that multiple.
        out: Is filled with set-point, zero speed and multiple, (3, J).
    """
    for joint in range(q_rad.shape[0]):
        table[1, joint] = 0.0
        table[2, joint] = 0.0
        q = q_rad[joint]
        goal = min(max(q, fixed[3, joint]), fixed[4, joint])
        share = min(abs(q - goal) / wall_rad, 1.0)
        out[0, joint] = goal
        out[1, joint] = 0.0
        swift = min(max(abs(dq_rad_s[joint]) / swift_rad_s - 1.0, 0.0), 1.0) * swift_multiple
        table[0, joint] += min(max(swift - table[0, joint], -swift_step), swift_step)
        out[2, joint] = share * wall_nm_rad / fixed[0, joint] if share > 0.0 else table[0, joint]
    for row in range(pairs.shape[0]):
        first, second = pairs[row, 0], pairs[row, 1]
        x, y = float(q_rad[first]), float(q_rad[second])
        near_x, near_y = nearest_in(x, y, corners, pairs[row, 2], pairs[row, 3])
        depth = math.sqrt((x - near_x) * (x - near_x) + (y - near_y) * (y - near_y))
        if depth > 0.0:
            wall = min(depth / wall_rad, 1.0) * wall_nm_rad
            out[0, first], out[0, second] = near_x, near_y
            out[2, first] = wall / fixed[0, first]
            out[2, second] = wall / fixed[0, second]


@compiled
def sum_up(sums: Float64, q_rad: Float64, dq_rad_s: Float64, tau_nm: Float64) -> None:
    """Add one reading to the sums of a regression of load on angle and speed, joint by joint.

    Args:
        sums: Sums of 1, q, w, t, qq, qw, ww, qt, wt, tt with w the speed and t the load, (10, J).
        q_rad: Angles, (J,).
        dq_rad_s: Speeds, (J,).
        tau_nm: Interaction torques, (J,).
    """
    for joint in range(q_rad.shape[0]):
        q, w, t = q_rad[joint], dq_rad_s[joint], tau_nm[joint]
        sums[0, joint] += 1.0
        sums[1, joint] += q
        sums[2, joint] += w
        sums[3, joint] += t
        sums[4, joint] += q * q
        sums[5, joint] += q * w
        sums[6, joint] += w * w
        sums[7, joint] += q * t
        sums[8, joint] += w * t
        sums[9, joint] += t * t


@compiled
def write_row(
    block: Float64,
    row: int,
    q: Float64,
    dq: Float64,
    tau: Float64,
    interaction: Float64,
    reference: Float64,
    wanted_q: Float64,
    wanted_dq: Float64,
    stiffness: Float64,
    damping: Float64,
    forward: Float64,
    requested: Float64,
    applied: Float64,
) -> None:
    """Write the columns of one tick, (J,) each, in their order into one row of a block, (ticks, 12 J)."""
    joints = q.size
    for joint in range(joints):
        block[row, joint] = q[joint]
        block[row, joints + joint] = dq[joint]
        block[row, 2 * joints + joint] = tau[joint]
        block[row, 3 * joints + joint] = interaction[joint]
        block[row, 4 * joints + joint] = reference[joint]
        block[row, 5 * joints + joint] = wanted_q[joint]
        block[row, 6 * joints + joint] = wanted_dq[joint]
        block[row, 7 * joints + joint] = stiffness[joint]
        block[row, 8 * joints + joint] = damping[joint]
        block[row, 9 * joints + joint] = forward[joint]
        block[row, 10 * joints + joint] = requested[joint]
        block[row, 11 * joints + joint] = applied[joint]
