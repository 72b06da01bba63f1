"""Runs of a robot that nobody wears, and runs without a path."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from rehab_app.hand.retarget import ROBOT_JOINTS
from rehab_app.therapy.run import PlayResult, record_run, session_header
from rehab_app.therapy.run_causes import sentence_of
from rehab_app.therapy.run_poses import BareRobot, WornHand, run_hand
from rehab_app.therapy.run_recorder import Message
from robot_iface.build import capabilities
from robot_iface.kinematics import average_hand
from robot_iface.kinematics.dlr_hit import dlr_hit_hand, hand_points
from robot_iface.safety import shipped_limits
from robot_iface.types import (
    DIGITS,
    JOINTS,
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
    Sweep,
    TickBlock,
)
from sessions.errors import Refused
from sessions.records import Status
from sessions.records.topics import EVENTS, PATIENT_POSE, REFERENCE, ROBOT_STATE, TRANSFORMS
from sessions.store import SessionReader, verify

MS = 1_000_000


def plan(device: Capabilities, sweep: bool) -> Plan:
    names = device.joint_names
    limits = shipped_limits(names, device.q_min_rad, device.q_max_rad)
    task: dict[str, object] = {
        "path": ReferencePath(
            names, np.linspace(0.0, 2.0, 21), np.zeros((21, len(names))), "ab" * 32, "right"
        )
    }
    if sweep:
        goals = np.zeros((1, len(names)))
        task = {"path": None, "sweep": Sweep("range", names, "right", ("open",), goals)}
    order = Prescription("transparent" if sweep else "passive")
    return Plan(
        device=device.name,
        prescription=order,
        limits=limits,
        twin=PatientTwin(),
        seed=1,
        software_version="0",
        **task,
    )


def messages(joints: int, cause: str = "") -> Iterator[Message | RunEnd]:
    rng = np.random.default_rng(5)
    yield PhaseChange(0, 0, "move", "robot", 0.0, 1.0, np.full(joints, 3.0))
    for index in range(30):
        yield TickBlock(
            t_ns=(50 * index + np.arange(50)) * MS,
            path_s=np.linspace(0.0, 1.0, 50),
            path_speed=np.ones(50),
            safety_state=np.full(50, int(SafetyState.ACTIVE), dtype=np.uint8),
            **{
                name: rng.uniform(0.0, 1.0, (50, joints))
                for name in TickBlock.__dataclass_fields__
                if name.endswith(("_rad", "_rad_s", "_nm", "_nm_rad", "_nms_rad"))
            },
        )
    if cause:
        yield SafetyEvent(1400 * MS, cause, SafetyState.HOLD, "index_pip", 0.2, 0.1)
    yield PhaseChange(1500 * MS, -1, "done", "", 1.0, 0.0, np.full(joints, 3.0))
    yield RunEnd(1.5, True, SafetyState.READY, 0, 0, "cd" * 32, "sweep", 2)


def record(tmp_path: Path, device: Capabilities, *, sweep: bool = False, cause: str = "") -> PlayResult:
    geometry = average_hand()
    ordered = plan(device, sweep)
    certificate = Certificate("ef" * 32, True, "fine", (0.1,) * len(device.joint_names), 2.0)
    header = session_header(ordered, certificate, geometry, "", "P-1", device)
    stream = messages(len(device.joint_names), cause)
    return record_run(stream, tmp_path / "run.mcap", header, ordered, geometry, device)


def test_a_robot_that_nobody_wears_is_recorded_by_its_own_chain(tmp_path: Path) -> None:
    device = capabilities("dlr-hit-ii")
    result = record(tmp_path, device)
    verify(result.path)
    with SessionReader(result.path) as reader:
        assert reader.header.source == "dlr-hit-ii (simulated, not worn, its own dlr-hit-ii chain)"
        assert reader.header.robot_joints == ROBOT_JOINTS
        rows, state = reader.columns(PATIENT_POSE), reader.columns(ROBOT_STATE)
        assert reader.counts[REFERENCE.name] == reader.counts[PATIENT_POSE.name] == 150
    measured = state["q_rad"][::10]
    tips = hand_points(dlr_hit_hand(), measured.reshape(-1, 5, 3))[:, :, 3]
    np.testing.assert_allclose(rows["fingertips_palm_m"], tips, atol=1e-12)
    joints = rows["joints_rad"]
    for finger in DIGITS[1:]:
        pip = JOINTS.index(f"{finger}_pip")
        np.testing.assert_array_equal(joints[:, pip], measured[:, ROBOT_JOINTS.index(f"{finger}_pip")])
        np.testing.assert_array_equal(joints[:, pip + 1], joints[:, pip])
    status = rows["joint_status"][0]
    assert {JOINTS[row] for row in np.flatnonzero(status == Status.MEASURED)} == set(ROBOT_JOINTS)
    assert result.rmse_rad is not None


def test_the_robots_fingertips_scatter_as_drawn_encoders_do() -> None:
    hand = BareRobot(2e-3)
    rng = np.random.default_rng(6)
    posture = rng.uniform(0.1, 1.0, (1, 15))
    drawn = hand.poses(posture + 2e-3 * rng.standard_normal((20_000, 15))).fingertips_m
    expected = np.sqrt((drawn.std(axis=0) ** 2).mean(axis=1))
    found = hand.fingertip_std_m(hand.poses(posture).joints_rad)[0]
    np.testing.assert_allclose(found, expected, rtol=0.03)


@pytest.mark.parametrize("name", ["exoskeleton", "dlr-hit-ii"])
def test_a_run_without_a_path_has_no_reference(tmp_path: Path, name: str) -> None:
    result = record(tmp_path, capabilities(name), sweep=True)
    verify(result.path)
    with SessionReader(result.path) as reader:
        counts, header = dict(reader.counts), reader.header
        transforms = next(iter(reader.records(TRANSFORMS)))
    assert REFERENCE.name not in counts
    assert counts[PATIENT_POSE.name] == 150
    assert header.kind == "therapy"
    assert header.exercise == "range sweep"
    assert header.parents == ()
    assert not any(child.startswith("reference/") for child in transforms.children)
    assert result.completed
    assert result.rmse_rad is None
    assert (result.reason, result.reversals) == ("sweep", 2)


def test_the_hand_follows_the_device() -> None:
    geometry = average_hand()
    assert isinstance(run_hand(capabilities("exoskeleton"), geometry), WornHand)
    robot = capabilities("dlr-hit-ii")
    assert isinstance(run_hand(robot, geometry), BareRobot)
    other = Capabilities(
        **{field: getattr(robot, field) for field in robot.__dataclass_fields__ if field != "joint_names"},
        joint_names=robot.joint_names[::-1],
    )
    with pytest.raises(Refused, match="robot joints"):
        run_hand(other, geometry)


def test_causes_are_sentences(tmp_path: Path) -> None:
    result = record(tmp_path, capabilities("exoskeleton"), cause="reversal")
    with SessionReader(result.path) as reader:
        (event,) = reader.records(EVENTS)
    assert event.text == "A load opposed the movement: the robot went back (index_pip)."
    unknown = SafetyEvent(0, "moon-phase", SafetyState.CAT1, "", float("nan"), float("nan"))
    assert sentence_of(unknown) == "The supervisor went to CAT1 for moon-phase."
    fault = SafetyEvent(0, "device-fault brake worn", SafetyState.CAT1, "", float("nan"), float("nan"))
    assert sentence_of(fault) == "The device reported a fault: brake worn."
