"""The simulated DLR-HIT-Hand II is the hand of the kinematics."""

from __future__ import annotations

import numpy as np
import pytest

from robot_iface.kinematics.dlr_hit import FINGER_MAX_RAD, FINGER_MIN_RAD, dlr_hit_hand, hand_points
from robot_iface.sim.dlr_hit import LINK_MASS_KG, add_dlr_hit, addresses, simulated_points
from robot_iface.sim.engine import mujoco


def test_mujoco_tree_agrees_with_the_modified_denavit_hartenberg_chain() -> None:
    rng = np.random.default_rng(52)
    for joints in rng.uniform(FINGER_MIN_RAD, FINGER_MAX_RAD, (40, 5, 3)):
        expected = hand_points(dlr_hit_hand(), joints)
        np.testing.assert_allclose(simulated_points(joints), expected, atol=1e-9)


def test_the_straight_finger_is_105_mm_long() -> None:
    points = simulated_points(np.zeros((5, 3)))
    np.testing.assert_allclose(np.linalg.norm(points[:, 3] - points[:, 0], axis=1), 0.105, atol=1e-12)


def test_the_distal_joint_follows_the_middle_one_under_torque() -> None:
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    add_dlr_hit(spec, spec.worldbody, dlr_hit_hand(), np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), 1.0)
    model = spec.compile()
    at, state = addresses(model), mujoco.MjData(model)
    farthest = 0.0
    for _ in range(200):
        state.qfrc_applied[at.dof] = 0.4 * (0.8 - state.qpos[at.qpos]) - 0.025 * state.qvel[at.dof]
        mujoco.mj_step(model, state)
        farthest = max(farthest, float(np.abs(state.qpos[at.dip_qpos] - state.qpos[at.qpos[:, 2]]).max()))
    assert state.qpos[at.qpos[:, 2]].min() > 0.3
    assert farthest < np.deg2rad(0.1)


def test_it_weighs_what_the_real_hand_weighs() -> None:
    spec = mujoco.MjSpec()
    add_dlr_hit(spec, spec.worldbody, dlr_hit_hand(), np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), 1.0)
    model = spec.compile()
    assert float(model.body_mass.sum()) == pytest.approx(1.5, abs=0.01)
    np.testing.assert_allclose(model.body_mass[addresses(model).bodies], np.tile(LINK_MASS_KG, (5, 1)))
