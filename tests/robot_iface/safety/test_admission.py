"""Limits that may protect this patient on this device now, and the acts that change them."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from robot_iface.errors import Refused
from robot_iface.safety import admit_limits, raised_limits, shipped_limits
from robot_iface.types import Hull

NAMES = ("index_mcp_flexion", "index_pip", "thumb_ip")
NOW_NS = 1_800_000_000 * 10**9
DAY_NS = 86_400 * 10**9


def limits(**changes: Any) -> Any:
    return dataclasses.replace(shipped_limits(NAMES, np.zeros(3), np.full(3, 1.6)), **changes)


def admit(rigid: Any, given: Any, wrist_rad: float = 0.0, now_ns: int = NOW_NS) -> None:
    admit_limits(given, rigid.RigidHand().capabilities, wrist_rad, now_ns)


def test_shipped_limits_and_those_of_today_are_admitted(rigid: Any) -> None:
    admit(rigid, limits())
    today = limits(measured_utc_ns=NOW_NS - 1, expires_utc_ns=NOW_NS + 1, wrist_rad=0.3)
    admit(rigid, today, wrist_rad=0.3)


@pytest.mark.parametrize(("after_ns", "refused"), [(-1, False), (0, True), (DAY_NS, True)])
def test_limits_expire(rigid: Any, after_ns: int, refused: bool) -> None:
    given = limits(expires_utc_ns=NOW_NS)
    if not refused:
        admit(rigid, given, now_ns=NOW_NS + after_ns)
        return
    with pytest.raises(Refused, match=r"expired since 2027-01-15 08:00 UTC.*measure today's range"):
        admit(rigid, given, now_ns=NOW_NS + after_ns)


@pytest.mark.parametrize("measured_deg", [-20.0, 0.0, 25.0])
@pytest.mark.parametrize(("by_deg", "refused"), [(9.9, False), (-9.9, False), (10.1, True), (-10.1, True)])
def test_another_wrist_angle_is_refused(
    rigid: Any, measured_deg: float, by_deg: float, refused: bool
) -> None:
    given, held = limits(wrist_rad=np.deg2rad(measured_deg)), np.deg2rad(measured_deg + by_deg)
    if not refused:
        admit(rigid, given, wrist_rad=held)
        return
    with pytest.raises(Refused, match="within 10 degrees of the measured"):
        admit(rigid, given, wrist_rad=held)


def test_a_wrist_that_nobody_measured_is_no_wrist(rigid: Any) -> None:
    admit(rigid, limits(), wrist_rad=1.0)
    with pytest.raises(Refused, match="wrist"):
        admit(rigid, limits(wrist_rad=0.0), wrist_rad=float("nan"))


BAD = [
    ("tau_interaction_nm", 0.451, "interaction torque of {} is 0.451 Nm, but must be above 0, at most 0.45"),
    ("tau_interaction_nm", 0.0, "interaction torque of {} is 0 Nm"),
    ("tau_interaction_nm", np.nan, "interaction torque of {} is nan"),
    ("tau_nm", 0.61, "motor torque of {} is 0.61 Nm, but must be above 0, at most 0.6"),
    ("q_min_rad", -0.31, "range of {} is -17.8 to 91.7 degrees, but must be within the device's -17.2"),
    ("q_max_rad", 2.01, "range of {} is 0.0 to 115.2 degrees"),
    ("q_max_rad", 0.0, "range of {} is 0.0 to 0.0 degrees"),
    ("q_min_rad", np.nan, "range of {} is nan"),
]


@pytest.mark.parametrize("joint", range(3))
@pytest.mark.parametrize(("field", "value", "message"), BAD)
def test_each_joint_is_looked_at(rigid: Any, field: str, value: float, message: str, joint: int) -> None:
    given = limits()
    row = getattr(given, field).copy()
    row[joint] = value
    with pytest.raises(Refused) as refused:
        admit(rigid, dataclasses.replace(given, **{field: row}))
    assert message.format(NAMES[joint]) in str(refused.value)


def test_the_ends_themselves_are_admitted(rigid: Any) -> None:
    device = rigid.RigidHand().capabilities
    admit(
        rigid,
        limits(tau_interaction_nm=np.full(3, 0.45), q_min_rad=device.q_min_rad, q_max_rad=device.q_max_rad),
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"q_min_rad": np.zeros(2)}, "limits is for 2 joints"),
        ({"trip_speed_rad_s": np.deg2rad(201.0)}, "trip speed is 201 degrees/s"),
        ({"trip_speed_rad_s": np.nan}, "trip speed"),
        ({"margin_rad": np.deg2rad(2.1)}, "margin of the range is 2.1 degrees"),
        ({"margin_rad": -0.01}, "margin of the range"),
        ({"hulls": (Hull(("index_mcp_flexion", "ring_pip"), np.eye(3)[:, :2]),)}, "joint of a hull"),
    ],
)
def test_what_a_plan_may_not_change_is_refused(rigid: Any, changes: Any, message: str) -> None:
    if "hulls" in changes:
        changes = {"hulls": (Hull(("index_mcp_flexion", "ring_pip"), np.array([[0, 0], [1, 0], [0, 1.0]])),)}
    with pytest.raises(Refused) as refused:
        admit(rigid, limits(**changes))
    assert message in str(refused.value)


def test_a_therapist_raises_one_joint_up_to_045(rigid: Any) -> None:
    raised = raised_limits(limits(), NAMES, "index_pip", 0.45)
    assert raised.tau_interaction_nm.tolist() == [0.25, 0.45, 0.10]
    assert limits().tau_interaction_nm.tolist() == [0.25, 0.15, 0.10]
    admit(rigid, raised)


@pytest.mark.parametrize(
    ("joint", "torque", "message"),
    [
        ("index_pip", 0.46, r"interaction torque of index_pip is 0\.46 Nm"),
        ("index_pip", 0.0, "interaction torque of index_pip"),
        ("index_pip", float("nan"), "interaction torque of index_pip"),
        ("ring_pip", 0.2, "joint is ring_pip"),
    ],
)
def test_but_not_more_and_no_other_joint(joint: str, torque: float, message: str) -> None:
    with pytest.raises(Refused, match=message):
        raised_limits(limits(), NAMES, joint, torque)
