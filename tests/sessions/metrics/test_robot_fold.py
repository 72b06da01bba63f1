"""The robot's ticks, folded while they pass by: no number depends on how the file was cut into windows."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from sessions.metrics import measure
from sessions.metrics.effort import works
from sessions.metrics.robot_blocks import RobotTicks
from sessions.metrics.robot_fold import FIELDS, Folded, RobotFold, fold, fold_columns
from sessions.metrics.robot_stretch import joined_track
from sessions.metrics.separated import PassiveRun, read_passive, separation
from sessions.records.topics import PHASE, ROBOT_COMMAND, ROBOT_STATE

Make = Callable[..., Any]


def cut(recording: Any, edges_ns: list[int]) -> Folded:
    """Fold it window by window; an edge may fall anywhere."""
    ticks = RobotFold(len(recording.header.robot_joints))
    bounds = [-(2**62), *edges_ns, 2**62]
    for low, high in pairwise(bounds):
        window: dict[str, Mapping[str, Any]] = {}
        for topic, names in FIELDS.items():
            rows = recording.topics[topic.name]
            chosen = (rows["t_ns"] >= low) & (rows["t_ns"] < high)
            window[topic.name] = {name: np.asarray(rows[name])[chosen] for name in ("t_ns", *names)}
        ticks.take(window)
    return ticks.finished(recording.header.robot_joints)


@pytest.mark.parametrize("seed", range(5))
def test_no_number_depends_on_the_windows(make_session: Make, seed: int) -> None:
    session, rng = make_session(stopped=seed % 2 == 1), np.random.default_rng(seed)
    state = session.topics[ROBOT_STATE.name]
    state["tau_interaction_nm"] = state["tau_interaction_nm"] + rng.normal(0.0, 0.01, state["q_rad"].shape)
    command = session.topics[ROBOT_COMMAND.name]
    command["stiffness_nm_rad"] = command["stiffness_nm_rad"] + rng.uniform(0.0, 0.1, state["q_rad"].shape)
    times = session.topics[ROBOT_STATE.name]["t_ns"]
    edges = sorted(int(t_ns) for t_ns in rng.choice(times, rng.integers(1, 60), replace=False))
    whole, pieces = fold_columns(session), cut(session, edges)
    assert len(whole.stretches) == 3
    assert repr(pieces.stiffness) == repr(whole.stiffness)
    assert pieces.stiffness_span_ns == whole.stiffness_span_ns
    for one, other in zip(whole.stretches, pieces.stretches, strict=True):
        assert (one.repetition, one.span_ns, one.works) == (other.repetition, other.span_ns, other.works)
        for name in ("low_rad", "high_rad", "square_nm2", "known", "peak_nm"):
            assert np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True)
        for name in ("t_ns", "q_rad", "dq_rad_s", "tau_nm", "passive", "repetition"):
            assert np.array_equal(getattr(one.track, name), getattr(other.track, name), equal_nan=True)


def test_only_ticks_within_repetitions_are_kept(make_session: Make) -> None:
    session = make_session()
    folded = fold(session)
    t_ns = session.topics[ROBOT_STATE.name]["t_ns"]
    phases = session.topics[PHASE.name]
    at = np.searchsorted(phases["t_ns"], t_ns, side="right") - 1
    active = np.isin(phases["phase"][at], ("move", "hold")) & (phases["repetition"][at] >= 0)
    assert sum(int(one.known[0]) for one in folded.stretches) == int(active.sum())
    track = joined_track(folded.stretches)
    assert track is not None
    assert track.t_ns.size == pytest.approx(active.sum() / 10, abs=6)
    session.topics[ROBOT_COMMAND.name]["stiffness_nm_rad"][~active] = 99.0
    assert {one.most for one in fold(session).stiffness.values()} == {0.9}


def test_work_by_joint_is_the_integral_of_the_power() -> None:
    t_s = np.arange(0.0, 3.0, 0.001)
    angle = 0.5 - 0.5 * np.cos(2.0 * np.pi * t_s / 3.0)
    found = works(
        t_s, np.stack([0.2 * angle, np.full(t_s.size, 0.1)]), np.gradient(angle, 0.001) * np.ones((2, 1))
    )
    assert found[0].robot_j == pytest.approx(0.5 * 0.2, rel=1e-3)  # k x^2 / 2 up to x = 1, and back
    assert found[0].returned_j == pytest.approx(0.5 * 0.2, rel=1e-3)
    assert found[1].robot_j == pytest.approx(0.1, rel=1e-3)


def ticks(session: Any, run: PassiveRun | None = None) -> RobotTicks:
    folded = fold(session)
    known = separation(session, folded.stretches, run)
    return RobotTicks(session.header.robot_joints, folded.stretches, known)


@pytest.mark.parametrize("tension_nm", [0.0, -0.05, 0.05])
@pytest.mark.parametrize("friction_nm", [0.0, 0.02])
def test_a_passive_limb_never_has_a_share_of_its_own(
    make_session: Make, tension_nm: float, friction_nm: float
) -> None:
    """A contracture is tense from the start and friction changes sign: both come back like effort."""
    session = make_session()
    state = session.topics[ROBOT_STATE.name]
    state["tau_interaction_nm"] = (
        state["tau_interaction_nm"] + tension_nm + friction_nm * np.sign(state["dq_rad_s"])
    )
    summary = measure(session)
    for item in summary.named("robot_share"):
        assert item.status.startswith("not measurable"), item
    assert all(math.isnan(one.robot_share) for one in summary.repetitions)
    session.topics[PHASE.name]["mode"][:] = "assistive"
    alone = ticks(session).share([1])
    assert math.isnan(alone.value)
    assert "not separable" in alone.reason
    passive = make_session()
    passive.topics[ROBOT_STATE.name]["tau_interaction_nm"] = state["tau_interaction_nm"].copy()
    against_itself = ticks(session, read_passive(passive))
    assert against_itself.share([0, 1]).value == pytest.approx(1.0, abs=0.02)
    for repetition in range(3):
        assert against_itself.share([0, 1], repetition).value == pytest.approx(1.0, abs=0.02)


def test_a_robot_without_torque_has_no_share_in_the_work(make_session: Make) -> None:
    session = make_session()
    session.topics[PHASE.name]["mode"][:] = "transparent"
    session.topics[ROBOT_STATE.name]["tau_interaction_nm"][:] = 0.0
    assert ticks(session).share([0, 1]).value == 0.0
    session.topics[ROBOT_STATE.name]["tau_interaction_nm"][:] = np.nan
    assert "does not measure" in ticks(session).share([0, 1]).reason
    statuses = {item.name: item.status for item in measure(session).metrics if item.subject == "whole"}
    assert statuses["robot_work"].startswith("not measurable")
    assert statuses["returned_work"].startswith("not measurable")


def test_passive_repetitions_take_no_part_in_the_share(make_session: Make) -> None:
    session = make_session()
    phases = session.topics[PHASE.name]
    phases["mode"] = np.where(phases["repetition"] == 0, "passive", "assistive")
    found = ticks(session)
    assert [one.passive for one in found.stretches] == [True, False, False]
    assert "passive mode" in found.share([0, 1], 0).reason
    assert found.share([0, 1], 1).value == pytest.approx(1.0, abs=0.02)
