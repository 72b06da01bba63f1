"""The virtual patient's muscles for one tick as machine code.

Constants stand here and not beside the class: what is compiled is kept on disk until this file changes.
Everything is done in place, in arrays that the caller made once.
"""

from __future__ import annotations

import math

from robot_iface.compiled import compiled
from robot_iface.types import Float64, Int64

PERIOD_S = 0.001
COMMAND_DELAY_TICKS = 80  # on the command only; a delay on the feedback would make the servo shake
REFLEX_DELAY_TICKS = 30
REFLEX_THRESHOLD_RAD_S = math.radians(30.0)
TREMOR_HZ = 5.0
_SERVO_STIFFNESS_NM_RAD = 0.4
_SERVO_DAMPING_NMS_RAD = 0.01
_EFFORT_RISE_S = 0.3
_ANTICIPATION_S = 0.1
_LEAD_RAD = math.radians(15.0)  # how far ahead a patient reaches before the robot has started
_BLOCK_DAMPING_NMS_RAD = 0.01
_CLONUS_FULL_RAD_S = math.radians(60.0)  # a stretch so much over the threshold sets off the full beat
_CLONUS_FADES_S = 0.8
_RECOVERY_S = 60.0

# columns of a spasm, before those of its joints
STARTS, LASTS, SIZE, BEATS_HZ, FIRST_JOINT = range(5)
# places of what a patient is
ABILITY, SPASTICITY, TIRES_J, CLONUS, CLONUS_HZ = range(5)
# places of how a patient is just now
TICK, EFFORT, WANTS, WILLINGNESS, OWN_S, ROBOT_S, STEP_S, RATE_S, WORK_J = range(9)
# rows of a patient's joints
BLOCK_AT, BLOCK_STIFFNESS, TREMOR, PHASE, BEAT, BEAT_TURN = range(6)


@compiled
def spasm_torque(t_s: float, spasms: Float64, out: Float64) -> None:
    """Adds the spasms of this moment to the torques, (J,).

    Args:
        t_s: Time.
        spasms: One row each: start, duration, size, beats per second, share of each joint, (S, 4 + J).
        out: Torques, (J,).
    """
    for s in range(spasms.shape[0]):
        since = t_s - spasms[s, STARTS]
        if since < 0.0 or since >= spasms[s, LASTS]:
            continue
        size = spasms[s, SIZE]
        if spasms[s, BEATS_HZ] > 0.0:
            size *= 0.5 - 0.5 * math.cos(2.0 * math.pi * spasms[s, BEATS_HZ] * since)
        for j in range(out.size):
            out[j] += size * spasms[s, FIRST_JOINT + j]


@compiled
def _goal_row(state: Float64, path: Float64) -> int:
    """The posture that the patient now strives for: a little ahead of the robot, or of its start."""
    last = path.shape[0] - 1
    here = min(int(state[ROBOT_S] / state[STEP_S]), last)
    own = min(int(state[OWN_S] / state[STEP_S]), last)
    lead = 0.0
    for j in range(path.shape[1]):
        lead = max(lead, abs(path[own, j] - path[here, j]))
    if lead < _LEAD_RAD:
        state[OWN_S] += state[RATE_S]
    return min(max(own, int((state[ROBOT_S] + _ANTICIPATION_S) / state[STEP_S])), last)


@compiled
def _reflex(late: float, j: int, who: Float64, joints: Float64) -> float:
    """Torque of the stretch reflex, and of the beats that a fast stretch sets off."""
    excess = max(-REFLEX_THRESHOLD_RAD_S - late, 0.0)
    if who[CLONUS] == 0.0:
        return who[SPASTICITY] * excess
    beat = who[CLONUS] * min(excess / _CLONUS_FULL_RAD_S, 1.0)
    joints[BEAT, j] = max(joints[BEAT, j] * (1.0 - PERIOD_S / _CLONUS_FADES_S), beat)
    if joints[BEAT, j] < 1e-3 * who[CLONUS]:
        joints[BEAT, j] = joints[BEAT_TURN, j] = 0.0
    joints[BEAT_TURN, j] += 2.0 * math.pi * who[CLONUS_HZ] * PERIOD_S
    pull = max(math.sin(joints[BEAT_TURN, j]), 0.0)
    return who[SPASTICITY] * excess + joints[BEAT, j] * pull


@compiled
def muscle_torque(
    q: Float64,
    dq: Float64,
    at: Int64,
    who: Float64,
    state: Float64,
    joints: Float64,
    goals: Float64,
    speeds: Float64,
    path: Float64,
    spasms: Float64,
    out: Float64,
) -> None:
    """The patient's muscles and tissue ends at this tick, flexion positive.

    Args:
        q: All positions of the model, (nq,).
        dq: All speeds, (nq,).
        at: Where the J joints stand in them, (J,).
        who: What the patient is, (5,).
        state: How the patient is just now, (9,).
        joints: Tissue ends, tremor and beats of each joint, (6, J).
        goals: Postures striven for and the effort in the last column, not yet arrived, (delay, J + 1).
        speeds: Speeds not yet felt, (delay, J).
        path: Postures of the movement, (M, J).
        spasms: See ``spasm_torque``.
        out: Receives the torques, (J,).
    """
    tick = int(state[TICK])
    state[TICK] += 1.0
    tired = math.exp(-state[WORK_J] / who[TIRES_J])
    wanted = state[WANTS] * state[WILLINGNESS] * who[ABILITY] * tired
    state[EFFORT] += (wanted - state[EFFORT]) * (PERIOD_S / _EFFORT_RISE_S)
    asked, felt, row = (
        goals[tick % COMMAND_DELAY_TICKS],
        speeds[tick % REFLEX_DELAY_TICKS],
        _goal_row(state, path),
    )
    effort, power = asked[at.size], 0.0
    asked[at.size] = state[EFFORT]
    turn = 2.0 * math.pi * TREMOR_HZ * PERIOD_S * tick
    for j in range(at.size):
        angle, speed = q[at[j]], dq[at[j]]
        own = effort * (_SERVO_STIFFNESS_NM_RAD * (asked[j] - angle) - _SERVO_DAMPING_NMS_RAD * speed)
        power += abs(own * speed)
        asked[j] = path[row, j]
        torque = own + _reflex(felt[j], j, who, joints)
        felt[j] = speed
        if joints[TREMOR, j] > 0.0:
            torque += joints[TREMOR, j] * math.sin(turn + joints[PHASE, j])
        beyond = joints[BLOCK_AT, j] - angle
        if joints[BLOCK_STIFFNESS, j] > 0.0 and beyond > 0.0:
            torque += max(joints[BLOCK_STIFFNESS, j] * beyond - _BLOCK_DAMPING_NMS_RAD * speed, 0.0)
        out[j] = torque
    state[WORK_J] += PERIOD_S * (power - state[WORK_J] / _RECOVERY_S)
    spasm_torque(tick * PERIOD_S, spasms, out)
