"""Coupled ranges: geometry, what trips, and where commands are pulled to."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_iface.errors import Refused
from robot_iface.safety import pack_hulls, shipped_limits
from robot_iface.safety.hull_kernels import distance_outside, nearest_in
from robot_iface.types import Hull, SafetyState

NAMES = ("index_mcp_flexion", "index_pip", "thumb_ip")
CORNERS = np.deg2rad([[0.0, 0.0], [60.0, 0.0], [80.0, 20.0], [80.0, 40.0], [20.0, 80.0], [0.0, 80.0]])
"""Tight flexors: the MCP joint opens far only with a bent PIP joint, and both cannot bend fully at once."""


def coupled(rigid: Any, corners: Any = CORNERS, joints: tuple[str, str] = NAMES[:2]) -> Any:
    limits = shipped_limits(NAMES, np.zeros(3), np.full(3, 1.6))
    return dataclasses.replace(limits, hulls=(Hull(joints, corners),))


angles = st.floats(-2.0, 3.0)


@given(x=angles, y=angles, seed=st.integers(0, 10_000))
@settings(max_examples=300, deadline=None)
def test_the_nearest_point_is_the_nearest_of_a_dense_boundary(x: float, y: float, seed: int) -> None:
    """Oracle: distance to each edge, densely sampled; inside by the sign of every edge."""
    rng = np.random.default_rng(seed)
    turns = np.sort(rng.uniform(0.0, 2 * np.pi, 7))
    if np.diff(turns).min() < 0.05:
        return
    corners = np.stack((np.cos(turns), 0.7 * np.sin(turns)), axis=1)
    nx, ny = nearest_in(x, y, corners, 0, len(corners))
    ahead = np.roll(corners, -1, axis=0)
    edges = ahead - corners
    side = edges[:, 0] * (y - corners[:, 1]) - edges[:, 1] * (x - corners[:, 0])
    if (side >= 0.0).all():
        assert (nx, ny) == (x, y)
        assert distance_outside(x, y, corners, 0, len(corners)) == 0.0
        return
    share = np.linspace(0.0, 1.0, 400)[:, None, None]
    boundary = (corners + share * edges).reshape(-1, 2)
    nearest = np.hypot(*(boundary - [x, y]).T).min()
    found = float(np.hypot(nx - x, ny - y))
    assert found == pytest.approx(distance_outside(x, y, corners, 0, len(corners)))
    assert nearest - 0.01 <= found <= nearest + 1e-9
    again = nearest_in(nx, ny, corners, 0, len(corners))
    assert np.hypot(again[0] - nx, again[1] - ny) < 1e-9, "the nearest point lies in the hull"


def test_a_hull_is_cut_to_the_range_and_packed_beside_others() -> None:
    limits = shipped_limits(NAMES, np.zeros(3), np.array([0.5, 1.6, 1.6]))
    packed = pack_hulls(dataclasses.replace(limits, hulls=(Hull(NAMES[:2], CORNERS),)), NAMES)
    assert packed.corners_rad[:, 0].max() == pytest.approx(0.5)
    assert packed.pairs.tolist() == [[0, 1, 0, len(packed.corners_rad)]]
    assert packed.outside(np.array([0.6, 0.3, 0.0]), 0.05) == "index_mcp_flexion and index_pip"
    assert packed.outside(np.array([0.6, 0.3, 0.0]), 0.11) == ""
    assert packed.outside(np.array([0.5, np.nan, 0.0]), 0.11)


@pytest.mark.parametrize(
    ("hulls", "message"),
    [
        ([Hull(("index_mcp_flexion", "ring_pip"), CORNERS)], "joint of a hull is ring_pip"),
        ([Hull(NAMES[:2], CORNERS), Hull(NAMES[1:], CORNERS)], "joint index_pip is in two hulls"),
        ([Hull(NAMES[:2], CORNERS + 2.0)], "hull of index_mcp_flexion and index_pip is outside"),
    ],
)
def test_hulls_that_do_not_fit_are_refused(hulls: list[Hull], message: str) -> None:
    limits = shipped_limits(NAMES, np.zeros(3), np.full(3, 1.6))
    with pytest.raises(Refused, match=message):
        pack_hulls(dataclasses.replace(limits, hulls=tuple(hulls)), NAMES)


@pytest.mark.parametrize("excess_deg", [1.9, 2.1])
@pytest.mark.parametrize(("place_deg", "joint"), [((70.0, 10.0), None), ((85.0, 30.0), 0), ((10.0, 85.0), 1)])
def test_outside_a_hull_by_more_than_the_margin(
    rigid: Any, place_deg: Any, joint: int | None, excess_deg: float
) -> None:
    """Within the box of 0 to 91.7 degrees everywhere: only the hull is left."""
    rig = rigid.Rig(ramp_s=0.02, limits=coupled(rigid))
    rig.go_active()
    place = np.deg2rad(place_deg)
    edge = np.array(nearest_in(*place, CORNERS, 0, len(CORNERS)))
    outwards = (np.array([1.0, -1.0]) / np.sqrt(2)) if joint is None else (place - edge)
    outwards = outwards / np.hypot(*outwards)
    rig.hand.q[:2] = edge + np.deg2rad(excess_deg) * outwards
    rig.hand.dq[:] = rig.hand.ddq[:] = 0.0
    rig.supervisor._previous, rig.supervisor._continued = None, False
    tripped = rig.cycle().safety_state is SafetyState.CAT1
    assert tripped == (excess_deg > 2.0)
    if not tripped:
        return
    event = rig.events()[0]
    assert (event.cause, rig.hand.mode) == ("hull", "brake")
    which = NAMES.index(event.joint)
    if joint is not None:
        assert which == joint
        assert event.bound == pytest.approx(edge[which] + np.deg2rad(2.0))
    assert event.value == pytest.approx(rig.states[-1].q_rad[which])


def test_goals_outside_are_pulled_to_the_nearest_point_and_slide_along_the_edge(rigid: Any) -> None:
    """Both joints are asked to bend fully; along the edge of the hull they still move."""
    rig = rigid.Rig(ramp_s=0.02, limits=coupled(rigid), stiffness=0.0, q_rad=0.3)
    rig.go_active()
    rig.multiple = 0.1  # soft enough that the law does not saturate on the way
    rig.glide(np.array([0.5, 0.5, 0.0]), 3.5)
    rig.run(2000)
    assert rig.events() == []
    goal = nearest_in(float(rig.goal[0]), float(rig.goal[1]), CORNERS, 0, len(CORNERS))
    assert np.rad2deg(np.hypot(*(rig.states[-1].q_rad[:2] - goal))) < 0.5
    outside = [distance_outside(*state.q_rad[:2], CORNERS, 0, len(CORNERS)) for state in rig.states]
    assert np.rad2deg(max(outside)) < 0.5
    assert np.rad2deg(distance_outside(*rig.goal[:2], CORNERS, 0, len(CORNERS))) > 20.0


def test_what_the_device_is_sent_lies_in_the_hull_itself(rigid: Any) -> None:
    """A device that follows positions obeys no feed-forward: the position itself must be pulled in."""
    rig = rigid.Rig(ramp_s=0.02, limits=coupled(rigid), stiffness=0.0, q_rad=0.3)
    rig.go_active()
    rig.speed = np.array([0.6, 0.6, 0.6])
    asked: list[Any] = []
    rig.change = lambda request: asked.append(request) or request
    for _ in range(3500):
        sent = rig.cycle().applied
        assert distance_outside(*sent.q_rad[:2], CORNERS, 0, len(CORNERS)) < 1e-9
        assert np.all(sent.q_rad <= rig.limits.q_max_rad + 1e-12)
    assert sent.dq_rad_s[2] == 0.0, "at its end the third joint is no more asked to move on"
    outwards = asked[-1].q_rad[:2] - sent.q_rad[:2]
    assert np.hypot(*outwards) > 0.01
    assert sent.dq_rad_s[:2] @ outwards < 1e-12, "and the pair not out of its hull"
    assert np.hypot(*sent.dq_rad_s[:2]) > 0.01, "but along its edge"


def test_a_pulled_request_gives_the_torque_that_was_announced(rigid: Any) -> None:
    rig = rigid.Rig(ramp_s=0.02, limits=coupled(rigid), stiffness=0.0, q_rad=0.3)
    rig.go_active()
    rig.speed = np.array([0.5, 0.5, 0.0])
    for _ in range(3000):
        outcome, state = rig.cycle(), rig.states[-1]
        sent = outcome.applied
        torque = sent.stiffness_nm_rad * (sent.q_rad - state.q_rad) + sent.tau_ff_nm
        torque = torque + sent.damping_nms_rad * (sent.dq_rad_s - state.dq_rad_s)
        assert np.allclose(torque, outcome.applied_tau_nm, atol=1e-12)


def test_enabling_outside_a_hull_is_refused_by_name(rigid: Any) -> None:
    rig = rigid.Rig(limits=coupled(rigid), q_rad=np.array([1.3, 1.2, 0.3]), stiffness=0.0)
    rig.supervisor.start()
    rig.cycle()
    with pytest.raises(Refused, match="index_mcp_flexion and index_pip"):
        rig.supervisor.enable_edge()
