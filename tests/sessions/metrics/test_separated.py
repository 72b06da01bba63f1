"""The patient's own work where a passive run tells recoil; the device's end; repeatability; starts."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sessions.metrics import measure
from sessions.metrics.device_end import at_device_end, ends_of
from sessions.metrics.metric import Lineage, Metric
from sessions.metrics.passive_curve import own_work, passive_curve
from sessions.metrics.recording import Origin, read_phases
from sessions.metrics.repeatability import mdc95, repeatability, standard_error
from sessions.metrics.robot_fold import fold
from sessions.metrics.separated import read_passive, separated_metrics, separation
from sessions.metrics.started import latencies
from sessions.records.topics import PHASE, ROBOT_STATE

Make = Callable[..., Any]
T = np.arange(0.0, 12.0, 0.001)
ANGLE = 0.4 * (1 - np.cos(2 * np.pi * T / 3))
SPEED = np.gradient(ANGLE, 0.001)
LIMB = 0.2 * ANGLE + 0.01 * SPEED
LINEAGE = Lineage("0" * 64, (), 0, 1, "encoder")


def noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, 0.004, T.size)


def test_a_limb_like_the_passive_one_does_nothing_itself() -> None:
    curve = passive_curve(ANGLE, SPEED, LIMB + noise(1))
    assert curve is not None
    found = own_work(T, ANGLE, SPEED, LIMB + noise(2), curve)
    assert found.share.value == pytest.approx(1.0, abs=0.02)
    assert found.patient_j.value == pytest.approx(0.0, abs=0.01)


def test_effort_is_told_from_recoil_and_resistance_is_reported_apart() -> None:
    curve = passive_curve(ANGLE, SPEED, LIMB)
    assert curve is not None
    travel = float(np.abs(np.diff(ANGLE)).sum())
    helping = own_work(T, ANGLE, SPEED, LIMB - 0.1 * np.sign(SPEED), curve)
    assert helping.patient_j.value == pytest.approx(0.1 * travel, rel=0.05)
    assert helping.resisting_j.value == pytest.approx(0.0, abs=0.01)
    against = own_work(T, ANGLE, SPEED, LIMB + 0.1 * np.sign(SPEED), curve)
    assert against.resisting_j.value == pytest.approx(-0.1 * travel, rel=0.05)
    assert against.share.value == pytest.approx(1.0, abs=0.02)
    nothing = own_work(T, ANGLE, SPEED, np.zeros(T.size), curve)
    assert nothing.share.value == 0.0


def test_where_the_curve_ends_nothing_is_separated() -> None:
    curve = passive_curve(0.5 * ANGLE, 0.5 * SPEED, LIMB)
    assert curve is not None
    assert "does not reach" in own_work(T, ANGLE, SPEED, LIMB, curve).share.reason
    assert passive_curve(0.01 * ANGLE, SPEED, LIMB) is None


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        (slice(700, 703), "three samples"),
        (slice(600, 690), "less than 1 s"),
        (slice(0, 1400), "only one way"),
    ],
)
def test_a_curve_from_too_little_is_no_curve(rows: slice, why: str) -> None:
    assert passive_curve(ANGLE[rows], SPEED[rows], LIMB[rows]) is None, why
    assert passive_curve(ANGLE, SPEED, LIMB) is not None


def test_a_joint_hardly_met_passively_separates_nothing(make_session: Make) -> None:
    session, passive = make_session(), make_session()
    session.topics[PHASE.name]["mode"][:] = "assistive"
    state = passive.topics[ROBOT_STATE.name]
    state["tau_interaction_nm"][40:] = math.nan
    assert not read_passive(passive).curves
    assert "not separable" in own(session, passive)["work_share"].status


def own(session: Any, passive: Any = None) -> dict[str, Metric]:
    origin = Origin(session.sha256, "exoskeleton")
    run = None if passive is None else read_passive(passive)
    stretches = fold(session).stretches
    ends = np.array(stretches[0].span_ns)
    return {item.name: item for item in separated_metrics(separation(session, stretches, run), ends, origin)}


def test_a_session_needs_a_passive_run_of_the_same_hand_day_and_device(make_session: Make) -> None:
    session, passive = make_session(), make_session()
    session.topics[PHASE.name]["mode"][:] = "assistive"
    assert "not separable" in own(session)["work_share"].status
    assert own(session, passive)["work_share"].value == pytest.approx(1.0, abs=0.02)
    session.topics[ROBOT_STATE.name]["tau_interaction_nm"][:] *= -1.0
    assert own(session, passive)["work_share"].value < 0.9
    for change, word in (
        ({"subject_id": "P-0002"}, "another hand"),
        ({"utc_start_ns": passive.header.utc_start_ns + 10**14}, "another day"),
        ({"source": "other"}, "another device"),
    ):
        other = replace(passive, header=replace(passive.header, **change))
        assert word in own(session, other)["work_share"].status
    assert "not passive" not in own(make_session())["work_share"].status
    assert not own(make_session())["work_share"].measurable


def test_a_session_takes_its_own_passive_repetitions(make_session: Make) -> None:
    session = make_session()
    phases = session.topics[PHASE.name]
    phases["mode"] = np.where(phases["repetition"] == 0, "passive", "assistive")
    assert own(session)["work_share"].value == pytest.approx(1.0, abs=0.02)
    assert measure(session).metric("work_share") is not None


def angle(name: str, value: float) -> Metric:
    return Metric(name, "index_pip", value, "rad", (value - 0.01, value + 0.01), "1", "ok", LINEAGE)


def test_the_end_of_the_device_is_never_the_patients() -> None:
    limits = {"device_min_rad": [0.0], "device_max_rad": [1.4], "q_min_rad": [0.1], "q_max_rad": [1.2]}
    ends = ends_of(json.dumps(limits), ["index_pip"])
    met = at_device_end(
        [angle("range_of_motion", 0.9), angle("angle_min", 0.5), angle("angle_max", 1.395)], ends
    )
    assert met[0].status.startswith("flagged: at least, device limit")
    assert met[1].status == "ok"
    assert met[2].status == "flagged: at least, device limit; one-sided interval, not below 79.4 deg"
    assert met[2].interval is None
    today = at_device_end([angle("angle_max", 1.19)], ends)[0]
    assert today.status.startswith("flagged: at least, today's limit")
    low = at_device_end([angle("angle_min", 0.005)], ends)[0]
    assert low.status.startswith("flagged: at most, device limit")
    for text in ("", "[]", "{", '{"device_max_rad": [1, 2]}', '{"device_max_rad": "x"}'):
        assert at_device_end([angle("angle_max", 1.4)], ends_of(text, ["index_pip"]))[0].status == "ok"


def test_minimal_detectable_change() -> None:
    assert [round(mdc95(sem), 1) for sem in (2.0, 4.0, 11.0)] == [5.5, 11.1, 30.5]


def test_standard_error_is_what_is_left_within_a_subject() -> None:
    rng = np.random.default_rng(5)
    groups = [list(centre + rng.normal(0.0, 2.0, 4)) for centre in rng.normal(0.0, 30.0, 200)]
    found = standard_error(groups)
    assert found.value == pytest.approx(2.0, rel=0.06)
    assert found.interval is not None
    assert found.interval[0] < 2.0 < found.interval[1]
    assert standard_error([[1.0, 3.0]] * 6).value == pytest.approx(math.sqrt(2.0))
    assert "degrees of freedom" in standard_error([[1.0, 3.0]]).reason


def test_repeatability_groups_by_subject_source_and_version() -> None:
    rows = [(whose, [angle("angle_max", value)]) for whose in "ab" for value in (1.0, 1.1, 1.2, 1.1)]
    (one,) = repeatability(rows)
    assert (one.trials, one.subjects, one.name) == (8, 2, "angle_max")
    assert one.mdc95 == pytest.approx(mdc95(one.sem))
    assert repeatability(rows[:3]) == ()


def test_latency_runs_from_the_cue_to_the_patients_own_start(make_session: Make) -> None:
    session = make_session()
    assert latencies(read_phases(session)) == []
    rows = session.topics[PHASE.name]
    first = int(np.flatnonzero(rows["repetition"] == 0)[0])
    rows["phase"][first : first + 4] = "cue"
    rows["started_by"] = np.array(["patient"] * len(rows["t_ns"]))
    assert [one.value for one in latencies(read_phases(session))] == pytest.approx([0.4])
