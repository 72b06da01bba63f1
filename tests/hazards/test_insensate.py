"""Hazard 9: skin that does not feel. Halved limits are what the device then really applies."""

from __future__ import annotations

from typing import Any

import numpy as np

from robot_iface.safety import shipped_limits


def test_a_stiff_hand_is_loaded_with_half(rigid: Any) -> None:
    low, high = np.zeros(3), np.full(3, 1.6)
    peaks = []
    for halved in (False, True):
        limits = shipped_limits(rigid.NAMES, low, high, halved=halved)
        rig = rigid.Rig(multiple=10.0, ramp_s=0.05, limits=limits, q_rad=1.2, stiffness=0.6, rest_rad=1.2)
        rig.go_active()
        rig.glide(np.deg2rad(-15.0), 3.0)
        peaks.append(np.abs([state.tau_interaction_nm for state in rig.states]).max(axis=0))
        assert rig.events() == []
    assert np.allclose(peaks[1], 0.5 * peaks[0], rtol=0.05)
    assert np.all(peaks[0] <= [0.25, 0.15, 0.10])
