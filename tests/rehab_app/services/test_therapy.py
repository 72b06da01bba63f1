from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from rehab_app.access import CONSOLE, Account
from rehab_app.bootstrap import open_clinic
from rehab_app.errors import REFUSALS, Refused
from rehab_app.services.order import Order
from robot_iface.motion import QuinticPath, check_path
from sessions.store import verify

AUDITOR = Account("otto", "auditor", "3")
FAST = Order(speed=0.5, repetitions=1)


@pytest.fixture(scope="module")
def approved(stocked):
    (row,) = stocked.takes.list()
    stocked.takes.approve(row.id, CONSOLE)
    return stocked


@pytest.fixture(scope="module")
def take(approved):
    return approved.takes.list()[0].id


@pytest.fixture(scope="module")
def played(approved, take):
    prepared = approved.therapy.plan(take, FAST, actor=CONSOLE)
    return prepared, approved.therapy.rehearse_and_play(prepared, actor=CONSOLE)


def test_a_played_take_is_a_sealed_session_with_its_lineage(approved, take, played):
    prepared, result = played
    assert result.completed
    assert result.stops == ()
    (repetition,) = result.repetitions
    assert repetition.started_by == "robot"
    assert 0.0 < result.rmse_rad < np.deg2rad(6.0)
    assert 0.0 < result.fingertip_rmse_m < 0.01
    assert result.mode == "passive"
    verify(result.path)
    row = approved.sessions.get(result.session)
    assert (row.take_id, row.mode, row.patient_id) == (take, "passive", "")
    assert prepared.plan.path.take_digest == approved.takes.get(take).sha256


def test_the_same_inputs_and_seed_give_the_same_digest(approved, take, played):
    _, first = played
    again = approved.therapy.rehearse_and_play(
        approved.therapy.plan(take, FAST, actor=CONSOLE), actor=CONSOLE
    )
    assert again.digest == first.digest
    other = approved.therapy.rehearse_and_play(
        approved.therapy.plan(take, replace(FAST, seed=1), actor=CONSOLE), actor=CONSOLE
    )
    assert other.digest != first.digest


def test_a_session_replays_with_its_reference(approved, played):
    _, result = played
    replay = approved.sessions.replay(result.session)
    assert replay.reference_joints_rad.shape == replay.patient_joints_rad.shape
    assert replay.fingertip_error_m.shape == replay.t_s.shape
    assert len(replay.phases) == replay.t_s.size
    assert {"move", "hold"} <= set(replay.phases)
    assert np.median(np.diff(replay.t_s)) == pytest.approx(0.02)


def test_a_session_reports_with_the_stiffness_it_was_obtained_at(approved, played):
    _, result = played
    metrics = json.loads(approved.reports.json(result.session))["metrics"]
    whole = next(item for item in metrics if (item["name"], item["subject"]) == ("joint_rmse", "whole"))
    assert whole["value"] == pytest.approx(result.rmse_rad)
    assert "thesis gains" in json.dumps(whole["lineage"])


def test_another_side_is_mirrored_and_said(approved, take):
    patient = approved.patients.add(
        CONSOLE, given_name="A", family_name="B", birth_date="1950-12-31", side="left", hand_length_m=0.175
    )
    prepared = approved.therapy.plan(take, FAST, actor=CONSOLE, patient_id=patient.id)
    assert prepared.plan.side == prepared.geometry.side == prepared.plan.twin.side == "left"
    assert prepared.geometry.length_m == pytest.approx(0.175)
    assert any("mirrored" in note for note in prepared.notes)
    same = approved.therapy.plan(take, FAST, actor=CONSOLE)
    np.testing.assert_allclose(prepared.plan.path.q_rad, same.plan.path.q_rad, atol=1e-12)
    assert not any("mirrored" in note for note in same.notes)


def test_a_movement_beyond_the_limits_is_slowed_where_it_is_and_said(approved, take):
    prepared = approved.therapy.plan(take, Order(speed=1.0, repetitions=1), actor=CONSOLE)
    assert prepared.plan.prescription.speed == 1.0
    assert check_path(QuinticPath(prepared.plan.path), prepared.plan.limits, 1.0, 0.001) is None
    assert any("Slowed locally" in note and "deg/s" in note for note in prepared.notes)


def test_every_digit_has_a_budget(approved, take):
    prepared = approved.therapy.plan(take, FAST, actor=CONSOLE)
    assert set(prepared.budget_m) == {"thumb", "index", "middle", "ring", "little"}
    assert all(0.0 <= value < 0.05 for value in prepared.budget_m.values())


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"device": "toaster"}, "exoskeleton"),
        ({"mode": "dance"}, "one of passive"),
        ({"twin": "zombie"}, "one of healthy"),
        ({"speed": 3.0}, "speed"),
        ({"repetitions": 0}, "repetitions"),
        ({"stiffness_multiple": 99.0}, "stiffness"),
        ({"space": "outer"}, "one of joint, fingertip"),
        ({"warm_up": -1}, "warm-up"),
        ({"minutes": float("nan")}, "minutes"),
        ({"resistance": 1.5}, "resistance"),
        ({"hold_s": float("inf")}, "hold"),
        ({"wrist_rad": float("nan")}, "wrist"),
        ({"wrist_rad": 2.0}, "-80 to 80"),
        ({"seed": -1}, "seed"),
    ],
)
def test_an_order_out_of_bounds_is_refused(approved, take, change, words):
    with pytest.raises(REFUSALS, match=words):
        approved.therapy.plan(take, replace(FAST, **change), actor=CONSOLE)


def test_an_order_by_or_for_nobody_is_refused(approved, take):
    with pytest.raises(Refused, match="may not play"):
        approved.therapy.plan(take, FAST, actor=AUDITOR)
    with pytest.raises(Refused, match="P-9999"):
        approved.therapy.plan(take, FAST, actor=CONSOLE, patient_id="P-9999")


def test_a_certificate_of_another_plan_is_refused(approved, take):
    prepared = approved.therapy.plan(take, FAST, actor=CONSOLE)
    certificate = approved.therapy.rehearse(prepared, actor=CONSOLE)
    stiffer = replace(
        prepared,
        plan=replace(prepared.plan, prescription=replace(prepared.plan.prescription, stiffness_multiple=9.0)),
    )
    before = approved.sessions.list()
    with pytest.raises(REFUSALS, match="prescription"):
        approved.therapy.play(stiffer, certificate, actor=CONSOLE)
    assert approved.sessions.list() == before


def test_an_unapproved_take_is_refused_before_a_motion_process_exists(tmp_path, take_file):
    with open_clinic(tmp_path) as clinic:
        take = clinic.takes.get(take_file).id
        prepared = clinic.therapy.plan(take, FAST, actor=CONSOLE)
        with pytest.raises(Refused, match=f"rehab-app approve {take}"):
            clinic.therapy.rehearse_and_play(prepared, actor=CONSOLE)
        assert list((clinic.folder / "sessions").iterdir()) == []


def test_an_altered_take_is_refused_although_it_was_approved(tmp_path, take_file):
    with open_clinic(tmp_path) as clinic:
        take = clinic.takes.get(take_file).id
        clinic.takes.approve(take, CONSOLE)
        prepared = clinic.therapy.plan(take, FAST, actor=CONSOLE)
        path = clinic.takes.get(take).path
        path.write_bytes(path.read_bytes() + b"x")
        with pytest.raises(Refused, match="changed"):
            clinic.therapy.rehearse_and_play(prepared, actor=CONSOLE)
