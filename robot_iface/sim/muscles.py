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
_RECOVERY_S = 600.0  # fatigue of therapy comes and goes in minutes (assumed)
_TWITCH_S = (
    0.03  # twice: the twitch of a finger muscle peaks some 60 ms after its nerve (assumed within 50-80 ms)
)
_WEAKENS_RAD_S = 10.0  # up to here a muscle gives all: far above any speed that the supervisor lets pass
_FASTEST_RAD_S = 25.0  # no muscle shortens faster: about the fastest movement of a free finger (assumed)
_SLACKENS_RAD_S = math.radians(120.0)  # faster than any therapy flexes
_SLACKENS_S = 0.01
_TAUT_S = 4.0

# columns of a spasm, before those of its joints
STARTS, LASTS, SIZE, BEATS_HZ, FIRST_JOINT = range(5)
# places of what a patient is
ABILITY, SPASTICITY, TIRES_J, CLONUS, CLONUS_HZ = range(5)
# places of how a patient is just now
TICK, EFFORT, WANTS, WILLINGNESS, OWN_S, ROBOT_S, STEP_S, RATE_S, WORK_J, LAG_RAD, LAG_TICKS = range(11)
STATE_PLACES = 11
# rows of a patient's joints
BLOCK_AT, BLOCK_STIFFNESS, TREMOR, PHASE, BEAT, BEAT_TURN, REFLEX_CAP, FLEXOR_CAP, EXTENSOR_CAP = range(9)
ROUSED, REFLEX, SPINDLE_SLACK = 9, 10, 11
JOINT_ROWS = 12


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
def _note_lag(q: Float64, at: Int64, state: Float64, path: Float64) -> None:
    """Adds how far the joint that lags most is behind the movement, while that goes on."""
    here = int(state[ROBOT_S] / state[STEP_S])
    if state[WANTS] == 0.0 or state[ROBOT_S] <= 0.0 or here >= path.shape[0] - 1:
        return
    behind = 0.0
    for j in range(at.size):
        way = path[here + 1, j] - path[here, j]
        if way != 0.0:
            behind = max(behind, (path[here, j] - q[at[j]]) * math.copysign(1.0, way))
    state[LAG_RAD] += behind
    state[LAG_TICKS] += 1.0


@compiled
def _reflex(late: float, j: int, who: Float64, joints: Float64) -> float:
    """Torque of the stretch reflex, and of the beats that a fast stretch sets off.

    The nerve's call is bounded, and the muscle answers it as two equal lags: without them a fast delayed
    loop would shake the soft tissue at 50 Hz, which no muscle can do. Spindles that a fast flexion has left
    slack call less until they are taut again (thixotropy, after Proske, Morgan & Gregory 1993; times
    assumed): a hand that snaps shut does not shake on for ever.
    """
    excess = max(-REFLEX_THRESHOLD_RAD_S - late, 0.0)
    joints[SPINDLE_SLACK, j] *= 1.0 - PERIOD_S / _TAUT_S
    if late > _SLACKENS_RAD_S:
        joints[SPINDLE_SLACK, j] += (1.0 - joints[SPINDLE_SLACK, j]) * (PERIOD_S / _SLACKENS_S)
    call = (1.0 - joints[SPINDLE_SLACK, j]) * min(who[SPASTICITY] * excess, joints[REFLEX_CAP, j])
    joints[ROUSED, j] += (call - joints[ROUSED, j]) * (PERIOD_S / _TWITCH_S)
    joints[REFLEX, j] += (joints[ROUSED, j] - joints[REFLEX, j]) * (PERIOD_S / _TWITCH_S)
    return joints[REFLEX, j] + _beat(excess, j, who, joints)


@compiled
def _beat(excess: float, j: int, who: Float64, joints: Float64) -> float:
    """Torque of the beats that a fast stretch sets off in a clonic hand."""
    if who[CLONUS] == 0.0:
        return 0.0
    beat = who[CLONUS] * min(excess / _CLONUS_FULL_RAD_S, 1.0)
    joints[BEAT, j] = max(joints[BEAT, j] * (1.0 - PERIOD_S / _CLONUS_FADES_S), beat)
    if joints[BEAT, j] < 1e-3 * who[CLONUS]:
        joints[BEAT, j] = joints[BEAT_TURN, j] = 0.0
    joints[BEAT_TURN, j] += 2.0 * math.pi * who[CLONUS_HZ] * PERIOD_S
    pull = max(math.sin(joints[BEAT_TURN, j]), 0.0)
    return joints[BEAT, j] * pull


@compiled
def _within_strength(torque: float, speed: float, j: int, joints: Float64) -> float:
    """What a muscle can give of a torque: no more than its strength, and less when it shortens very fast."""
    if torque * speed > 0.0:
        left = (_FASTEST_RAD_S - abs(speed)) / (_FASTEST_RAD_S - _WEAKENS_RAD_S)
        torque *= min(max(left, 0.0), 1.0)
    return min(max(torque, -joints[EXTENSOR_CAP, j]), joints[FLEXOR_CAP, j])


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
        state: How the patient is just now, (STATE_PLACES,).
        joints: Tissue ends, tremor, beats, reflex and strength of each joint, (JOINT_ROWS, J).
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
    _note_lag(q, at, state, path)
    out[:] = 0.0
    spasm_torque(tick * PERIOD_S, spasms, out)
    for j in range(at.size):
        angle, speed = float(q[at[j]]), float(dq[at[j]])
        own = effort * (_SERVO_STIFFNESS_NM_RAD * (asked[j] - angle) - _SERVO_DAMPING_NMS_RAD * speed)
        power += abs(own * speed)
        asked[j] = path[row, j]
        torque = out[j] + own + _reflex(felt[j], j, who, joints)
        felt[j] = speed
        if joints[TREMOR, j] > 0.0:
            torque += joints[TREMOR, j] * math.sin(turn + joints[PHASE, j])
        torque = _within_strength(torque, speed, j, joints)
        beyond = joints[BLOCK_AT, j] - angle
        if joints[BLOCK_STIFFNESS, j] > 0.0 and beyond > 0.0:
            torque += max(joints[BLOCK_STIFFNESS, j] * beyond - _BLOCK_DAMPING_NMS_RAD * speed, 0.0)
        out[j] = torque
    state[WORK_J] += PERIOD_S * (power - state[WORK_J] / _RECOVERY_S)
