"""Today's limits are what was measured less a margin, and never wider than what ships."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.motion.limits import INSET_RAD, SweepResult, clamp, hulls_exceeded, limits_of
from robot_iface.motion.polygon import outside
from robot_iface.safety import shipped_limits
from robot_iface.types import Float64, Limits

NAMES = (
    "thumb_cmc_abduction",
    "thumb_ip",
    "index_mcp_flexion",
    "index_pip",
    "little_mcp_flexion",
    "little_pip",
)
LOW = np.deg2rad([-25.0, -10.0, -15.0, -5.0, -15.0, -5.0])
HIGH = np.deg2rad([40.0, 80.0, 90.0, 105.0, 90.0, 105.0])
BASE = shipped_limits(NAMES, LOW, HIGH)
REST_DEG = [0.0, 15.0, 25.0, 33.0, 25.0, 33.0]
PASSIVE_DEG = [
    [-10.0, 0.0, 0.0, 0.0, 10.0, 30.0],
    [20.0, 0.0, 80.0, 0.0, 70.0, 30.0],
    [0.0, 50.0, 10.0, 95.0, 10.0, 80.0],
    [0.0, 60.0, 80.0, 95.0, 60.0, 90.0],
]


def result(passive_deg: object = PASSIVE_DEG, rest_deg: object = REST_DEG) -> SweepResult:
    passive: Float64 = np.deg2rad(np.array(passive_deg, dtype=np.float64))
    none = np.zeros(passive.shape, dtype=np.bool_)
    return SweepResult(
        joint_names=NAMES,
        side="left",
        postures=("open", "tabletop", "hook", "fist")[: len(passive)],
        rest_rad=np.deg2rad(np.array(rest_deg, dtype=np.float64)),
        active_rad=passive,
        passive_rad=passive,
        load_nm=np.zeros(passive.shape),
        patient_end=none,
        device_end=none,
    )


def measured(found: SweepResult, base: Limits = BASE) -> Limits:
    return limits_of(found, base, measured_utc_ns=10, expires_utc_ns=20, wrist_rad=0.1)


def test_the_box_ends_five_degrees_inside_what_was_reached() -> None:
    limits = measured(result())
    np.testing.assert_allclose(
        np.rad2deg(limits.q_min_rad), [-5.0, 5.0, 5.0, 5.0, 15.0, 33.0 + 2.0 - 2.0], atol=1e-4
    )
    np.testing.assert_allclose(np.rad2deg(limits.q_max_rad), [15.0, 55.0, 75.0, 90.0, 65.0, 85.0], atol=1e-4)
    assert (limits.measured_utc_ns, limits.expires_utc_ns, limits.wrist_rad) == (10, 20, 0.1)


def test_the_hull_ends_five_degrees_inside_and_is_not_a_box() -> None:
    limits = measured(result())
    assert [hull.joints for hull in limits.hulls] == [
        ("index_mcp_flexion", "index_pip"),
        ("little_mcp_flexion", "little_pip"),
    ]
    reached = np.deg2rad(np.array(PASSIVE_DEG)[:, 2:4])
    for posture in reached:  # each posture was a corner
        assert outside(limits.hulls[0].corners_rad, posture[None])[0] > INSET_RAD - 1e-6
    tight = np.deg2rad([[0.0, 20.0, 74.0, 6.0, 60.0, 40.0], [0.0, 20.0, 6.0, 88.0, 60.0, 40.0]])
    beyond = hulls_exceeded(tight, NAMES, limits.hulls)
    assert beyond[0, 0] < 0.0 < beyond[1, 0]  # within the box of both joints, but not together


@pytest.mark.parametrize("seed", range(30))
def test_a_measurement_never_widens_a_limit_and_holds_the_rest_posture(seed: int) -> None:
    rng = np.random.default_rng(seed)
    passive = rng.uniform(-40.0, 140.0, (4, 6))
    rest = np.rad2deg(rng.uniform(BASE.q_min_rad, BASE.q_max_rad))
    limits = measured(result(passive, rest))
    assert bool((limits.q_min_rad >= BASE.q_min_rad).all() and (limits.q_max_rad <= BASE.q_max_rad).all())
    assert bool((limits.q_min_rad < limits.q_max_rad).all())
    np.testing.assert_array_equal(limits.tau_interaction_nm, BASE.tau_interaction_nm)
    np.testing.assert_array_equal(limits.extension_speed_rad_s, BASE.extension_speed_rad_s)
    here = np.deg2rad(rest)[None]
    assert bool(((here >= limits.q_min_rad - 1e-9) & (here <= limits.q_max_rad + 1e-9)).all())
    if limits.hulls:
        assert hulls_exceeded(here, NAMES, limits.hulls).max() < 1e-5


def test_hyperextension_stays_out_unless_it_was_allowed() -> None:
    passive = np.array(PASSIVE_DEG)
    passive[0, 2] = -12.0
    assert measured(result(passive)).q_min_rad[2] == pytest.approx(np.deg2rad(5.0))
    wider = shipped_limits(NAMES, LOW, HIGH, hyperextension=True)
    assert measured(result(passive), wider).q_min_rad[2] == pytest.approx(np.deg2rad(-7.0))


def test_a_joint_that_hardly_moves_keeps_the_middle_of_its_range_and_needs_no_hull() -> None:
    passive = np.array(PASSIVE_DEG)
    passive[:, 3] = [30.0, 33.0, 35.0, 36.0]
    limits = measured(result(passive))
    assert np.rad2deg(limits.q_max_rad[3] - limits.q_min_rad[3]) == pytest.approx(3.0, abs=1e-6)
    assert [hull.joints[0] for hull in limits.hulls] == ["little_mcp_flexion"]


def test_joints_that_were_only_moved_together_are_refused() -> None:
    passive = np.array(PASSIVE_DEG)
    passive[:, 2] = passive[:, 3] = [0.0, 30.0, 60.0, 90.0]
    with pytest.raises(Refused, match=r"range of index MCP and PIP is a line.*tabletop"):
        measured(result(passive, [0.0, 15.0, 30.0, 30.0, 25.0, 33.0]))


def test_a_posture_that_broke_off_does_not_count() -> None:
    found = result()
    broken = found.passive_rad.copy()
    broken[3] = np.nan
    limits = measured(replace(found, passive_rad=broken))
    assert limits.q_max_rad[1] == pytest.approx(np.deg2rad(45.0))
    with pytest.raises(Refused, match="without a posture"):
        measured(replace(found, passive_rad=np.full_like(broken, np.nan)))


def test_what_cannot_be_used_is_refused_in_a_sentence() -> None:
    with pytest.raises(Refused, match="broken off"):
        measured(replace(result(), verdict="broken off before its end"))
    with pytest.raises(Refused, match="expired when measured"):
        limits_of(result(), BASE, measured_utc_ns=20, expires_utc_ns=20, wrist_rad=0.0)
    with pytest.raises(Refused, match="for 6 joints"):
        measured(result(), shipped_limits(NAMES[:3], LOW[:3], HIGH[:3]))


def test_clamped_postures_lie_within_hulls_and_box() -> None:
    limits = measured(result())
    rng = np.random.default_rng(3)
    wild = np.deg2rad(rng.uniform(-30.0, 120.0, (500, 6)))
    tame = clamp(wild, NAMES, limits)
    assert hulls_exceeded(tame, NAMES, limits.hulls).max() < 1e-9
    assert bool((tame >= limits.q_min_rad - 1e-9).all() and (tame <= limits.q_max_rad + 1e-9).all())
    np.testing.assert_array_equal(clamp(tame, NAMES, limits).round(9), tame.round(9))
