from __future__ import annotations

import json

import numpy as np
import pytest

from rehab_app.errors import RobotRefused
from rehab_app.therapy.run import record_run, session_header
from rehab_app.therapy.run_poses import COUPLED_STD_RAD, UNSEEN_STD_RAD, WornHand
from rehab_app.therapy.run_recorder import RunRecorder
from robot_iface.kinematics import average_hand, forward
from robot_iface.safety import shipped_limits
from robot_iface.types import (
    DIGITS,
    JOINTS,
    LANDMARKS,
    Capabilities,
    Certificate,
    PatientTwin,
    PhaseChange,
    Plan,
    Prescription,
    ReferencePath,
    RunEnd,
    SafetyEvent,
    SafetyState,
    TickBlock,
)
from sessions.records import Status
from sessions.records.topics import (
    EVENTS,
    PATIENT_POSE,
    PHASE,
    REFERENCE,
    ROBOT_COMMAND,
    ROBOT_STATE,
    TRANSFORMS,
)
from sessions.store import SessionReader, recover, verify

DRIVEN = ("thumb_ip", "index_mcp_flexion", "index_pip", "little_pip")
ENCODER_STD = 1e-3
MS = 1_000_000
DEVICE = Capabilities(
    name="exoskeleton",
    simulated=True,
    joint_names=DRIVEN,
    period_ns=MS,
    q_min_rad=np.full(4, -0.5),
    q_max_rad=np.full(4, 1.5),
    tau_max_nm=np.full(4, 0.6),
    worn=True,
    unpowered="free",
    encoder_std_rad=ENCODER_STD,
)


def plan():
    t_s = np.linspace(0.0, 2.0, 21)
    q_rad = np.zeros((21, 4))
    path = ReferencePath(DRIVEN, t_s, q_rad, "ab" * 32, "left")
    limits = shipped_limits(DRIVEN, np.full(4, -0.5), np.full(4, 1.5))
    return Plan("exoskeleton", path, Prescription("passive"), limits, PatientTwin(), 1, "0")


def block(first_ms, rng, offset_rad=0.0):
    n = 50
    reference = rng.uniform(0.0, 1.0, (n, 4))
    rows = {
        name: rng.uniform(0.0, 1.0, (n, 4))
        for name in (
            "dq_rad_s",
            "tau_nm",
            "tau_interaction_nm",
            "q_command_rad",
            "dq_command_rad_s",
            "damping_nms_rad",
            "tau_ff_nm",
            "tau_requested_nm",
            "tau_applied_nm",
        )
    }
    return TickBlock(
        t_ns=(first_ms + np.arange(n)) * MS,
        q_rad=reference + offset_rad,
        q_reference_rad=reference,
        stiffness_nm_rad=np.full((n, 4), 0.9),
        path_s=np.linspace(0.0, 1.0, n),
        path_speed=np.ones(n),
        safety_state=np.full(n, int(SafetyState.ACTIVE), dtype=np.uint8),
        **rows,
    )


def messages(offset_rad=0.0, blocks=40):
    rng = np.random.default_rng(7)
    yield PhaseChange(0, 0, "move", "robot", 0.0, 1.0, np.array([2.0, 3.0, 5.0, 4.0]))
    for index in range(blocks):
        yield block(50 * index, rng, offset_rad)
    yield PhaseChange(50 * blocks * MS, -1, "done", "", 1.0, 0.0, np.full(4, 3.0))
    yield RunEnd(blocks * 0.05, True, SafetyState.READY, 0, 0, "cd" * 32)


def certificate():
    return Certificate("ef" * 32, True, "fine", (0.1,) * 4, 2.0)


def record(tmp_path, stream):
    geometry = average_hand(0.18, "left")
    header = session_header(plan(), certificate(), geometry, "open_close", "P-0001", DEVICE)
    return record_run(stream, tmp_path / "session.mcap", header, plan(), geometry, DEVICE)


def test_everything_that_was_reported_is_in_the_file(tmp_path):
    result = record(tmp_path, messages())
    verify(result.path)
    with SessionReader(result.path) as reader:
        counts = reader.counts
        assert counts[ROBOT_STATE.name] == counts[ROBOT_COMMAND.name] == 40
        assert counts[PATIENT_POSE.name] == counts[REFERENCE.name] == 200
        assert counts[PHASE.name] == 2
        state, command = reader.columns(ROBOT_STATE), reader.columns(ROBOT_COMMAND)
        sent = [message for message in messages() if isinstance(message, TickBlock)]
        np.testing.assert_array_equal(state["q_rad"], np.concatenate([one.q_rad for one in sent]))
        np.testing.assert_array_equal(
            command["tau_applied_nm"], np.concatenate([one.tau_applied_nm for one in sent])
        )
        np.testing.assert_array_equal(
            command["tau_requested_nm"], np.concatenate([one.tau_requested_nm for one in sent])
        )
        header = reader.header
    assert header.kind == "therapy"
    assert header.side == "left"
    assert header.robot_joints == DRIVEN
    assert header.parents == ("ab" * 32,)
    assert '"repetitions":3' in header.prescription
    assert "ef" * 32 in header.certificate
    held = json.loads(header.limits)
    assert held["q_max_rad"] == plan().limits.q_max_rad.tolist()
    assert held["device_min_rad"] == DEVICE.q_min_rad.tolist()
    assert held["device_max_rad"] == DEVICE.q_max_rad.tolist()


@pytest.mark.parametrize("mode", ["transparent", "resistive"])
def test_a_robot_that_only_measures_or_resists_neither_starts_nor_helps(mode):
    written = []
    hand = WornHand(average_hand(0.18, "left"), DRIVEN, ENCODER_STD)
    recorder = RunRecorder(lambda _, record: written.append(record), hand, DRIVEN, mode)
    for starter in ("robot", "patient", ""):
        recorder.take(PhaseChange(0, 0, "move", starter, 0.0, 1.0, np.full(4, 3.0)))
    assert [row.started_by for row in written] == ["", "patient", ""]
    assert all(np.isnan(row.assistance).all() for row in written)


def test_a_motion_process_that_dies_names_the_way_to_get_the_file_back(tmp_path):
    def dying():
        yield from list(messages())[:5]
        raise RobotRefused("the motion process", "gone", "running", "look at the patient")

    with pytest.raises(RobotRefused) as refusal:
        record(tmp_path, dying())
    (partial,) = tmp_path.glob("*.partial.mcap")
    assert f"rehab-app recover {partial}" in refusal.value.remedy
    assert "look at the patient" in refusal.value.remedy
    assert recover(partial).records > 0


def test_patient_and_reference_share_their_times_at_100_hz(tmp_path):
    result = record(tmp_path, messages())
    with SessionReader(result.path) as reader:
        patient, reference = reader.columns(PATIENT_POSE), reader.columns(REFERENCE)
    np.testing.assert_array_equal(patient["t_ns"], reference["t_ns"])
    assert set(np.diff(patient["t_ns"])) == {10 * MS}


def test_transforms_stay_at_30_hz_or_below_and_name_three_hands(tmp_path):
    result = record(tmp_path, messages())
    with SessionReader(result.path) as reader:
        transforms = list(reader.records(TRANSFORMS))
    assert min(np.diff([one.t_ns for one in transforms])) >= 33 * MS
    assert len(transforms) >= 49
    for hand in ("reference", "patient", "robot"):
        assert f"{hand}/index_tip" in transforms[0].children
    patient = transforms[0].children.index("patient/index_tip")
    assert transforms[0].parents[patient] == "patient/palm"


def test_driven_joints_are_measured_the_rest_estimated_and_dip_follows_pip(tmp_path):
    result = record(tmp_path, messages())
    with SessionReader(result.path) as reader:
        row = next(iter(reader.records(PATIENT_POSE)))
    for column, joint in enumerate(JOINTS):
        expected = Status.MEASURED if joint in DRIVEN else Status.ESTIMATED
        assert row.joint_status[column] == expected, joint
    pip, dip = JOINTS.index("index_pip"), JOINTS.index("index_dip")
    assert row.joints_rad[dip] == pytest.approx(2.0 / 3.0 * row.joints_rad[pip])
    assert row.joints_rad[JOINTS.index("ring_mcp_abduction")] == 0.0
    assert row.source == "encoder"


def test_a_constant_offset_is_the_error(tmp_path):
    result = record(tmp_path, messages(offset_rad=0.02))
    assert result.rmse_rad == pytest.approx(0.02)
    (repetition,) = result.repetitions
    assert repetition.rmse_rad == pytest.approx(0.02)
    assert repetition.started_by == "robot"
    by_digit = dict(zip(DIGITS, repetition.assistance, strict=True))
    assert by_digit == {"thumb": 2.0, "index": 4.0, "middle": None, "ring": None, "little": 4.0}
    assert result.digest == "cd" * 32
    assert result.completed


def test_a_stop_is_in_the_result_and_the_file_is_sealed(tmp_path):
    def stopped():
        stream = list(messages(blocks=40))[:21]
        yield from stream
        yield SafetyEvent(990 * MS, "e-stop", SafetyState.CAT1, "", float("nan"), float("nan"))
        yield PhaseChange(990 * MS, 0, "stopped", "robot", 0.9, 0.0, np.full(4, 3.0))
        yield RunEnd(1.0, False, SafetyState.CAT1, 0, 0, "cd" * 32)

    result = record(tmp_path, stopped())
    (stop,) = result.stops
    assert (stop.cause, stop.category) == ("e-stop", "CAT1")
    assert stop.t_s == pytest.approx(0.99)
    assert not result.completed
    verify(result.path)
    with SessionReader(result.path) as reader:
        (event,) = reader.records(EVENTS)
    assert event.kind == "stop"
    assert event.severity == "alarm"


def test_a_run_stopped_before_its_first_tick_is_sealed_without_figures(tmp_path):
    def stopped():
        yield PhaseChange(0, -1, "approach", "", 0.0, 0.0, np.full(4, 3.0))
        yield SafetyEvent(5 * MS, "e-stop", SafetyState.CAT1, "", float("nan"), float("nan"))
        yield RunEnd(0.005, False, SafetyState.CAT1, 0, 0, "cd" * 32)

    result = record(tmp_path, stopped())
    verify(result.path)
    assert result.repetitions == ()
    assert result.rmse_rad is None
    assert [stop.cause for stop in result.stops] == ["e-stop"]


def test_a_motion_process_that_vanishes_leaves_a_partial_file_only(tmp_path):
    with pytest.raises(RobotRefused, match="motion process"):
        record(tmp_path, list(messages())[:10])
    assert [path.name for path in tmp_path.iterdir()] == ["session.partial.mcap"]


def test_equal_runs_write_equal_messages(tmp_path):
    rows = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        result = record(tmp_path / name, messages())
        with SessionReader(result.path) as reader:
            rows.append([record_ for topic in (PATIENT_POSE, PHASE) for record_ in reader.records(topic)])
    for first, second in zip(*rows, strict=True):
        for field in first.__dataclass_fields__:
            np.testing.assert_array_equal(getattr(first, field), getattr(second, field))


def test_fingertip_spread_is_that_of_drawn_hands():
    """Oracle: hands drawn with the stated spread of every joint scatter as the propagation says."""
    hand = WornHand(average_hand(), DRIVEN, ENCODER_STD)
    joints = hand.joints(np.array([[0.3, 0.6, 0.8, 0.5]]))
    rng = np.random.default_rng(3)
    drawn = joints + hand.std_rad * rng.standard_normal((20_000, 21))
    tips = [LANDMARKS.index(f"{digit}_tip") for digit in DIGITS]
    scatter = forward(hand.geometry, drawn).landmarks_m[:, tips].std(axis=0)
    expected = np.sqrt(np.mean(scatter**2, axis=1))
    np.testing.assert_allclose(hand.fingertip_std_m(joints)[0], expected, rtol=0.03)
    assert UNSEEN_STD_RAD > ENCODER_STD
    assert COUPLED_STD_RAD > ENCODER_STD
