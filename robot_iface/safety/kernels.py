"""The numbers of one tick of the supervisor, compiled: one call for every bound of every joint.

Arrays of joints are (J,). ``work`` carries what one tick leaves for the next, one row a quantity; the row
numbers below are shared with ``robot_iface.safety.envelope``.
"""

from __future__ import annotations

import math

from robot_iface.compiled import compiled
from robot_iface.safety.hull_kernels import nearest_in
from robot_iface.types import Float64, Int64

LOW, HIGH, PERIOD, RENEWED, KEPT, BOUNDS = range(6)
"""Rows of the table of limits: ends of the range; control period, and what the observer of passivity renews
and keeps in a tick; then one row of bounds a rule."""
SENSORS, RANGE, SPEED, TORQUE, REQUEST, STEP, POWER, LOAD, COUPLED, ENERGY = range(10)
"""Rules, also rows of ``work`` with the magnitudes that were met."""
PREVIOUS, APPLIED, LAST_Q, SLOW = 10, 15, 20, 21
"""Rows of ``work``: the request of the last tick and what was applied, five each, as in ``torque_at``; the
last positions, and the slow part of the torque that the device gave beyond its command."""
WORK_ROWS = 22
HARD_LOAD_MULTIPLE = 1.5
"""A load that is so far over its limit is not waited for."""
NOT_FINITE = 1 << 20
CHANGED = 1 << 21
"""Bits of ``assess`` beside those of the rules: a number is not finite; what is applied differs from the
request."""
INPUT_ROWS = 10
Q, SECOND, DQ, TAU, INTERACTION, WANTED = range(6)
"""Rows of ``given``: five of the reading, then the five of the request in the order of ``torque_at``."""
OUT_ROWS = 5
REQUESTED, CLAMPED, PULLED_Q, PULLED_DQ, SHIFTED = range(OUT_ROWS)
"""Rows of ``out``."""


@compiled
def torque_at(q: float, dq: float, rows: Float64, first: int, joint: int) -> float:
    """Torque of a stored command (position, speed, feed-forward, stiffness, damping) at a state, Nm."""
    return float(
        rows[first + 3, joint] * (rows[first, joint] - q)
        + rows[first + 4, joint] * (rows[first + 1, joint] - dq)
        + rows[first + 2, joint]
    )


@compiled
def pull_in(given: Float64, table: Float64, pairs: Int64, corners: Float64, out: Float64) -> None:
    """Positions moved to the nearest point of box or hull, speeds without their part that leads outwards.

    Args:
        given: See ``assess``.
        table: Table of limits.
        pairs: See ``PackedHulls``.
        corners: See ``PackedHulls``.
        out: Rows PULLED_Q and PULLED_DQ are written.
    """
    for j in range(given.shape[1]):
        q, dq = given[WANTED, j], given[WANTED + 1, j]
        inner = min(max(q, table[LOW, j]), table[HIGH, j])
        out[PULLED_Q, j] = inner
        out[PULLED_DQ, j] = 0.0 if (inner - q) * dq < 0.0 else dq
    for h in range(pairs.shape[0]):
        a, b = pairs[h, 0], pairs[h, 1]
        qa, qb, va, vb = given[WANTED, a], given[WANTED, b], given[WANTED + 1, a], given[WANTED + 1, b]
        x, y = nearest_in(qa, qb, corners, pairs[h, 2], pairs[h, 3])
        outwards = (x - qa) * va + (y - qb) * vb
        if outwards < 0.0:
            share = outwards / ((x - qa) * (x - qa) + (y - qb) * (y - qb))
            va -= share * (x - qa)
            vb -= share * (y - qb)
        out[PULLED_Q, a], out[PULLED_Q, b] = x, y
        out[PULLED_DQ, a], out[PULLED_DQ, b] = va, vb


@compiled
def coupled_excess(given: Float64, pairs: Int64, corners: Float64, work: Float64) -> None:
    """Row COUPLED of ``work``: distance outside a hull, at the joint that is farther out of the two."""
    work[COUPLED, :] = 0.0
    for h in range(pairs.shape[0]):
        a, b = pairs[h, 0], pairs[h, 1]
        x, y = nearest_in(given[Q, a], given[Q, b], corners, pairs[h, 2], pairs[h, 3])
        dx, dy = given[Q, a] - x, given[Q, b] - y
        work[COUPLED, a if abs(dx) >= abs(dy) else b] = math.sqrt(dx * dx + dy * dy)


@compiled
def measure(
    given: Float64,
    torque_mode: bool,
    stepped: bool,
    cap_nm: Float64,
    table: Float64,
    work: Float64,
    out: Float64,
) -> None:
    """Rows of ``work`` and the torques of ``out`` joint by joint; the pulled positions are there already."""
    for j in range(given.shape[1]):
        q, dq = given[Q, j], given[DQ, j]
        if torque_mode:
            given[WANTED, j] = given[WANTED + 1, j] = given[WANTED + 3, j] = given[WANTED + 4, j] = 0.0
            out[PULLED_Q, j] = out[PULLED_DQ, j] = 0.0
        tau = torque_at(q, dq, given, WANTED, j)
        pulled = (
            tau
            + given[WANTED + 3, j] * (out[PULLED_Q, j] - given[WANTED, j])
            + given[WANTED + 4, j] * (out[PULLED_DQ, j] - given[WANTED + 1, j])
        )
        clamped = min(max(pulled, -cap_nm[j]), cap_nm[j])
        out[REQUESTED, j] = tau
        out[CLAMPED, j] = clamped
        out[SHIFTED, j] = given[WANTED + 2, j] + (clamped - pulled)
        work[SENSORS, j] = abs(q - given[SECOND, j])
        work[RANGE, j] = abs(q - 0.5 * (table[LOW, j] + table[HIGH, j]))
        work[SPEED, j] = abs(dq)
        work[TORQUE, j] = abs(given[TAU, j])
        work[REQUEST, j] = abs(tau)
        work[STEP, j] = abs(tau - torque_at(q, dq, work, PREVIOUS, j)) if stepped else 0.0
        work[POWER, j] = abs(clamped * dq)
        work[LOAD, j] = abs(given[INTERACTION, j])


@compiled
def observe(given: Float64, continued: bool, table: Float64, work: Float64) -> None:
    """One step of the observer of passivity, row ENERGY; see ``robot_iface.safety.passivity``.

    Args:
        given: See ``assess``.
        continued: Whether the last command was applied as noted; otherwise the observer begins here.
        table: Table of limits.
        work: Carried from tick to tick.
    """
    for j in range(given.shape[1]):
        q, dq = given[Q, j], given[DQ, j]
        if continued:
            last = work[LAST_Q, j]
            ideal = torque_at(0.5 * (last + q), dq, work, APPLIED, j)
            excess = given[TAU, j] - ideal
            work[SLOW, j] += table[RENEWED, j] * (excess - work[SLOW, j])
            slip = work[APPLIED + 1, j] - dq
            lost = work[APPLIED + 4, j] * slip * slip * table[PERIOD, j]
            gained = (excess - work[SLOW, j]) * (q - last) - lost
            work[ENERGY, j] = max(table[KEPT, j] * work[ENERGY, j] + gained, 0.0)
        else:
            work[ENERGY, j] = work[SLOW, j] = 0.0
        work[LAST_Q, j] = q


@compiled
def compare(table: Float64, work: Float64) -> tuple[int, float]:
    """Bits of the rules that are broken, or NOT_FINITE, and the largest load as a share of its limit."""
    bits, load, total = 0, 0.0, 0.0
    for rule in range(ENERGY + 1):
        for j in range(work.shape[1]):
            share = work[rule, j] / table[BOUNDS + rule, j]
            total += share
            if rule == LOAD:
                load = max(load, share)
            elif share > 1.0:
                bits |= 1 << rule
    if load > HARD_LOAD_MULTIPLE:
        bits |= 1 << LOAD
    if not math.isfinite(total):
        bits |= NOT_FINITE
    return bits, load


@compiled
def note(j: int, given: Float64, work: Float64, out: Float64) -> None:
    """Keep the request of a joint, and what is applied of it, for the next tick."""
    for row in range(5):
        work[PREVIOUS + row, j] = given[WANTED + row, j]
        work[APPLIED + row, j] = given[WANTED + row, j]
    for row in range(3):
        work[APPLIED + row, j] = out[PULLED_Q + row, j]


@compiled
def take_in(
    q: Float64,
    second: Float64,
    dq: Float64,
    tau: Float64,
    interaction: Float64,
    wanted_q: Float64,
    wanted_dq: Float64,
    wanted_tau: Float64,
    stiffness: Float64,
    damping: Float64,
    given: Float64,
) -> None:
    """Reading and request, (J,) each, into the rows of ``given``.

    Raises:
        ValueError: One of them is for another number of joints.
    """
    joints = given.shape[1]
    for size in (q.size, second.size, dq.size, tau.size, interaction.size):
        if size != joints:
            raise ValueError("the reading is for another number of joints")
    for size in (wanted_q.size, wanted_dq.size, wanted_tau.size, stiffness.size, damping.size):
        if size != joints:
            raise ValueError("the request is for another number of joints")
    for j in range(joints):
        given[Q, j], given[SECOND, j], given[DQ, j] = q[j], second[j], dq[j]
        given[TAU, j], given[INTERACTION, j] = tau[j], interaction[j]
        given[WANTED, j], given[WANTED + 1, j], given[WANTED + 2, j] = (
            wanted_q[j],
            wanted_dq[j],
            wanted_tau[j],
        )
        given[WANTED + 3, j], given[WANTED + 4, j] = stiffness[j], damping[j]


@compiled
def assess(
    q: Float64,
    second: Float64,
    dq: Float64,
    tau: Float64,
    interaction: Float64,
    wanted_q: Float64,
    wanted_dq: Float64,
    wanted_tau: Float64,
    stiffness: Float64,
    damping: Float64,
    given: Float64,
    torque_mode: bool,
    stepped: bool,
    continued: bool,
    cap_nm: Float64,
    table: Float64,
    pairs: Int64,
    corners: Float64,
    work: Float64,
    out: Float64,
) -> tuple[int, float, float, float]:
    """Check reading and request of one tick, (J,) each.

    Args:
        q: Of the reading: positions.
        second: Positions by the second sensor.
        dq: Speeds.
        tau: Motor torques.
        interaction: Torques on the patient.
        wanted_q: Of the request: positions.
        wanted_dq: Speeds.
        wanted_tau: Feed-forward torques.
        stiffness: K.
        damping: D.
        given: Is filled with all of these, INPUT_ROWS rows.
        torque_mode: Whether the request is its feed-forward torque alone.
        stepped: Whether the request of the last tick came from the same source, so that they may be compared.
        continued: Whether what was noted as applied in the last tick was.
        cap_nm: Clamp of the torque.
        table: Limits, see the rows above.
        pairs: See ``PackedHulls``.
        corners: See ``PackedHulls``.
        work: Carried from tick to tick.
        out: Torque asked for, torque within the limits; position, speed and feed-forward that give it.

    Returns:
        Bits of the rules that are broken, NOT_FINITE and CHANGED; the largest load as a share of its limit;
        the highest commanded and the highest measured speed.

    Raises:
        ValueError: Reading or request are for another number of joints.
    """
    take_in(q, second, dq, tau, interaction, wanted_q, wanted_dq, wanted_tau, stiffness, damping, given)
    observe(given, continued, table, work)
    pull_in(given, table, pairs, corners, out)
    coupled_excess(given, pairs, corners, work)
    measure(given, torque_mode, stepped, cap_nm, table, work, out)
    bits, load = compare(table, work)
    commanded = fastest = 0.0
    for j in range(given.shape[1]):
        commanded = max(commanded, abs(given[WANTED + 1, j]))
        fastest = max(fastest, work[SPEED, j])
        changed = out[CLAMPED, j] != out[REQUESTED, j] or out[PULLED_Q, j] != given[WANTED, j]
        if changed or out[PULLED_DQ, j] != given[WANTED + 1, j]:
            bits |= CHANGED
        note(j, given, work, out)
    return bits, load, commanded, fastest
