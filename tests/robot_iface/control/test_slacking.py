"""A patient who slacks: effort falls by itself and is kept up by errors alone (after Reinkensmeyer 2009)."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.control import FeedForward
from robot_iface.safety import shipped_limits

NAMES = ("index_mcp_flexion", "index_pip")
LIMITS = shipped_limits(NAMES, np.zeros(2), np.full(2, 1.5))
DURATION_S, SPEED = 4.0, 0.5
STIFFNESS_NM_RAD = 0.3
HAND_NM_RAD = 0.1
SLACKING = 0.85
EFFORT_PER_RAD = 4.0


def final_ability(forgetting: float, repetitions: int = 40) -> float:
    """Share of the torque that moving the hand needs which the patient gives in the end."""
    learner = FeedForward(DURATION_S, LIMITS, forgetting)
    ability = 0.6
    for _ in range(repetitions):
        errors = []
        for s in np.arange(0.0, DURATION_S, 0.01):
            target = 0.25 * (1.0 - np.cos(2 * np.pi * s / DURATION_S)) * np.ones(2)
            need = HAND_NM_RAD * target
            left = need * (1.0 - ability) - learner.torque(float(s), np.full(2, 0.7))
            error = left / (STIFFNESS_NM_RAD + HAND_NM_RAD)
            learner.observe(float(s), error, 0.2)
            errors.append(error)
        learner.learn(np.full(2, STIFFNESS_NM_RAD), SPEED)
        behind = float(np.maximum(errors, 0.0).mean())
        ability = min(SLACKING * ability + EFFORT_PER_RAD * behind, 1.0)
    return ability


def test_with_forgetting_the_patient_keeps_working_and_without_the_robot_takes_over() -> None:
    forgetful, perfect = final_ability(0.8), final_ability(1.0)
    assert perfect < 0.05
    assert forgetful > 0.15
    assert final_ability(0.7) > forgetful
    assert forgetful == pytest.approx(final_ability(0.8, 60), abs=0.02), "it has settled"
