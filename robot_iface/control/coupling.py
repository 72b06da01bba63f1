"""What both laws share: torque feedback and opposition, with their bounds."""

from __future__ import annotations

import math

import numpy as np

from robot_iface.control.gains import Gains
from robot_iface.types import Float64, Limits

SPRING_SHARE = 0.9
"""Share of the interaction limit at which the spring saturates: below the trip, so that a stiff hand opens as
far as the limit lets it and the run goes on, instead of tripping in every repetition."""
MOST_FEEDBACK = 0.95
"""More torque feedback is not given: below 1 the loop stays stable even if the torque sensor has the wrong
sign; the patient then feels 1 / (1 - f) times the rotor, never a runaway."""
FEEDBACK_SHARE = 0.5
"""Feedback torque is at most this share of the interaction limit."""
FEEDBACK_CUTOFF_HZ = 50.0
FEEDBACK_NM_S = 20.0
"""Rate of the feedback torque: a third of what trips the supervisor."""
OPPOSITION_NMS_RAD = 0.1
"""Largest damping of opposition: half of 0.7 M / T, so that another tick of delay is borne."""


class Coupling:
    """Tables of a law's kernel, and the state of its torque feedback, for one run.

    Args:
        gains: Gains at multiple 1.
        limits: Limits of the driven joints.
        period_s: Control period.
    """

    def __init__(self, gains: Gains, limits: Limits, period_s: float) -> None:
        limit: Float64 = np.array(limits.tau_interaction_nm, dtype=np.float64)
        still = np.zeros(limit.size)
        self.table: Float64 = np.stack(
            (
                gains.stiffness_nm_rad,
                gains.damping_nms_rad,
                SPRING_SHARE * limit,
                FEEDBACK_SHARE * limit,
                limit,
                still + OPPOSITION_NMS_RAD,
                still,
                still,
            )
        )
        """K, D at multiple 1; spring saturation; largest feedback torque; interaction limit; largest damping
        of opposition; interaction torque, low-passed; feedback torque given last. (8, J)."""
        self._keep = math.exp(-2.0 * math.pi * FEEDBACK_CUTOFF_HZ * period_s)
        self._step_nm = FEEDBACK_NM_S * period_s

    def asked(
        self, ramp: float, feedback: float, opposition: float
    ) -> tuple[float, float, float, float, float]:
        """What this tick asks of ``kernels.dress``."""
        return ramp, min(feedback, MOST_FEEDBACK), opposition, self._keep, self._step_nm
