"""A guard against a control loop that makes energy: the observer of passivity, and its threshold.

The device is told to be a spring and a damper about a set-point, tau = K (q_d - q) + D (dq_d - dq) + tau_ff.
Such a law gives the hand no more than what is put in by moving the set-point and by the feed-forward:

    work on the joint = work of set-point and feed-forward - change of the spring's energy
                        - what the damper takes, D (dq_d - dq)^2 T a tick.

A digital loop with sampling and delay is not that law: near a stiff spring every tick of delay acts as
damping of the wrong sign, -K T. What it generates is what remains when both are subtracted. Over the period
before a reading the motor torque was constant (zero-order hold), so its work is exactly tau (q - q_last).
Set-point and feed-forward were constant too and the spring is linear, so that the ideal law's work is exactly
its torque half-way times (q - q_last). Per joint and tick

    generated = (tau - tau_ideal((q + q_last) / 2)) (q - q_last) - D (dq_d - dq)^2 T
    energy    = max(0, energy exp(-T / LEAK_S) + generated).

``tau`` is the motor torque that the device reports with the reading: where commands arrive late it shows the
late torque, which what was commanded does not. Its part slower than SLOW_S is left out: a bias or a drift of
the torque sensor times a long movement is no unstable loop, while a loop becomes unstable far above 3 Hz.
In torque mode the whole request is feed-forward: feedback hidden in it is not seen.

Threshold: a joint of 5e-4 kg m^2 that trips at 200 deg/s carries 3 mJ; LIMIT_J is a tenth of that, so that a
loop is caught at 50 to 60 deg/s. Healthy, spastic, trembling and spasm runs at the shipped gains stay below a
fifth of it.
"""

from __future__ import annotations

import math

LEAK_S = 0.2
SLOW_S = 0.05
LIMIT_J = 3e-4


def kept_share(period_s: float) -> float:
    """Share of the energy that is kept from one tick to the next."""
    return math.exp(-period_s / LEAK_S)


def renewed_share(period_s: float) -> float:
    """Share of the slow part that is renewed in a tick."""
    return 1.0 - math.exp(-period_s / SLOW_S)
