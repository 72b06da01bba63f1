from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.control import BUILT_MODES, Goal, ImpedanceLaw, require_mode, thesis_gains
from robot_iface.errors import Refused
from robot_iface.motion import PathState, Setpoint
from robot_iface.safety import shipped_limits
from robot_iface.types import MODES, CommandMode, DeviceState

NAMES = ("index_mcp_flexion", "index_pip", "thumb_cmc_abduction", "thumb_mcp_flexion", "thumb_ip")
J = len(NAMES)
LIMITS = shipped_limits(NAMES, np.zeros(J), np.full(J, 1.5))
vectors = st.lists(st.floats(-1.0, 1.0), min_size=J, max_size=J).map(np.array)


def state(q: np.ndarray, dq: np.ndarray) -> DeviceState:
    zeros = np.zeros(J)
    return DeviceState(0, 0, q, q, dq, zeros, zeros, 30.0, ())


def test_thesis_gains_by_joint() -> None:
    gains = thesis_gains(NAMES)
    assert gains.stiffness_nm_rad.tolist() == [0.3, 0.4, 0.3, 0.3, 0.4]
    assert gains.damping_nms_rad.tolist() == [0.02, 0.027, 0.02, 0.02, 0.027]


@given(n=st.floats(0.1, 10.0))
def test_scaling_keeps_the_damping_ratio(n: float) -> None:
    gains, scaled = thesis_gains(NAMES), thesis_gains(NAMES).scaled(n)
    ratio = scaled.damping_nms_rad**2 / (4 * scaled.stiffness_nm_rad)
    assert np.allclose(ratio, gains.damping_nms_rad**2 / (4 * gains.stiffness_nm_rad))
    assert np.allclose(scaled.stiffness_nm_rad, n * gains.stiffness_nm_rad)


@given(error=vectors, dq=vectors, dq_d=vectors, n=st.floats(0.1, 10.0), ramp=st.floats(0.0, 1.0))
@settings(deadline=None)
def test_impedance_is_spring_and_damper_with_a_saturated_spring(
    error: np.ndarray, dq: np.ndarray, dq_d: np.ndarray, n: float, ramp: float
) -> None:
    q = np.full(J, 0.5)
    setpoint = Setpoint(q + error, dq_d, np.zeros(J))
    goal = Goal(setpoint, np.full(J, n), np.full(J, 0.01), PathState(0.0, 0.0, 0.0, False))
    command = ImpedanceLaw(thesis_gains(NAMES), LIMITS).command(state(q, dq), goal, ramp, 7)
    gains = thesis_gains(NAMES).scaled(n * ramp)
    bound = 0.9 * LIMITS.tau_interaction_nm
    spring = command.stiffness_nm_rad * (command.q_rad - q)
    assert np.allclose(spring, np.clip(gains.stiffness_nm_rad * error, -bound, bound), atol=1e-8)
    assert np.allclose(command.damping_nms_rad, gains.damping_nms_rad)
    assert np.allclose(command.tau_ff_nm, 0.01 * ramp)
    assert np.array_equal(command.dq_rad_s, dq_d)
    assert (command.mode, command.seq) == (CommandMode.IMPEDANCE, 7)


def test_all_four_modes_are_built_and_nothing_else() -> None:
    assert BUILT_MODES == MODES
    for mode in MODES:
        require_mode(mode)
    unknown: Any = "massage"
    with pytest.raises(Refused, match=r"therapy mode is massage.*passive, assistive, transparent, resistive"):
        require_mode(unknown)
