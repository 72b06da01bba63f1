from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from rehab_app.hand.subject import geometry_to_json
from rehab_app.recording.take import HandMotion, read_motion, write_take
from rehab_app.therapy.reference import build_reference
from rehab_app.therapy.retouch import Operation, Scale, Slow, Smooth, Trim, retouch
from rehab_app.therapy.retouch_file import METADATA, read_operations, write_retouched
from robot_iface.build import capabilities
from robot_iface.kinematics import average_hand, couple_dip, forward
from robot_iface.safety import shipped_limits
from sessions.errors import Refused
from sessions.metrics import measure_file
from sessions.records import JOINTS, HandPose, MarkerFrame, SessionHeader, Status
from sessions.store import SessionReader, verify

INDEX_PIP = JOINTS.index("index_pip")
TIPS = [3, 7, 11, 15, 19]
SECONDS = 6.0


def angles(t_s: np.ndarray) -> np.ndarray:
    joints = np.zeros((t_s.size, 21))
    closed = 0.5 * (1.0 - np.cos(2.0 * np.pi * t_s / SECONDS))
    for row, name in enumerate(JOINTS):
        if name.endswith(("mcp_flexion", "pip")):
            joints[:, row] = 0.1 + 0.6 * closed
    return couple_dip(joints)


def motion(noise_rad: float = 0.0) -> HandMotion:
    t_s = np.arange(0.0, SECONDS, 1.0 / 30.0)
    joints = angles(t_s) + noise_rad * np.random.default_rng(1).standard_normal((t_s.size, 21))
    joints[60:70, 5:9] = np.nan
    geometry = average_hand(0.18, "left")
    t_ns = 10**12 + np.round(1e9 * t_s).astype(np.int64)
    return HandMotion(
        t_ns=t_ns,
        t_s=1e-9 * (t_ns - t_ns[0]),
        joints_rad=joints,
        joint_covariance_rad2=np.tile(0.02**2 * np.eye(21), (t_s.size, 1, 1)),
        joint_status=np.where(np.isfinite(joints), Status.MEASURED, Status.LOST).astype(np.uint8),
        fingertips_palm_m=forward(geometry, joints).landmarks_m[:, TIPS],
        p_camera_palm_m=np.tile([0.0, 0.0, 0.6], (t_s.size, 1)),
        q_camera_palm_wxyz=np.tile([1.0, 0.0, 0.0, 0.0], (t_s.size, 1)),
        residual_m=np.full(t_s.size, 1e-3),
        side="left",
        geometry=geometry,
    )


def take_file(folder: Path) -> Path:
    shown = motion()
    header = SessionHeader(
        session_id="1" * 32,
        kind="take",
        subject_id="P-1",
        side="left",
        exercise="open_close",
        source="virtual-camera",
        software_version="0",
        utc_start_ns=10**18,
        monotonic_start_ns=10**12,
        marker_names=("index_tip",),
        subject_hand=geometry_to_json(shown.geometry),
    )
    rows = [
        (
            MarkerFrame(
                t_ns=t_ns,
                p_camera_m=np.zeros((1, 3)),
                covariance_m2=np.zeros((1, 3, 3)),
                status=np.full(1, Status.MEASURED, dtype=np.uint8),
                pixel_px=np.zeros((1, 2)),
                similarity=np.ones(1),
            ),
            HandPose(
                t_ns=t_ns,
                p_camera_palm_m=shown.p_camera_palm_m[row],
                q_camera_palm_wxyz=shown.q_camera_palm_wxyz[row],
                joints_rad=shown.joints_rad[row],
                joint_covariance_rad2=shown.joint_covariance_rad2[row],
                joint_status=shown.joint_status[row],
                fingertips_palm_m=shown.fingertips_palm_m[row],
                fingertip_covariance_m2=np.tile(1e-6 * np.eye(3), (5, 1, 1)),
                residual_m=1e-3,
            ),
        )
        for row, t_ns in enumerate(shown.t_ns.tolist())
    ]
    return write_take(folder / "take.mcap", header, rows).path


def apply(shown: HandMotion, *operations: Operation) -> HandMotion:
    return retouch(shown, operations).motion


def test_trimming_keeps_the_rest_to_the_bit() -> None:
    shown = motion()
    kept = apply(shown, Trim(1.0, 4.0))
    assert kept.t_s[0] == 0.0
    assert kept.t_s[-1] == pytest.approx(3.0, abs=0.04)
    rows = (shown.t_s >= 1.0) & (shown.t_s <= 4.0)
    np.testing.assert_array_equal(kept.joints_rad, shown.joints_rad[rows])
    np.testing.assert_array_equal(kept.t_ns, shown.t_ns[rows])


def test_smoothing_takes_noise_and_leaves_gaps() -> None:
    noisy = motion(0.03)
    calm = apply(noisy, Smooth(20.0))
    np.testing.assert_array_equal(np.isfinite(calm.joints_rad), np.isfinite(noisy.joints_rad))
    truth = angles(noisy.t_s)
    before, after = (np.sqrt(np.nanmean((one.joints_rad - truth) ** 2)) for one in (noisy, calm))
    assert after < 0.5 * before
    known = np.isfinite(calm.joints_rad).all(axis=1)
    tips = forward(calm.geometry, calm.joints_rad[known]).landmarks_m[:, TIPS]
    np.testing.assert_allclose(calm.fingertips_palm_m[known], tips, atol=1e-12)


def test_slowing_shows_the_same_postures_later() -> None:
    shown = motion()
    slowed = apply(shown, Slow(3.0, 2.0, 4.0))
    np.testing.assert_array_equal(slowed.joints_rad, shown.joints_rad)
    before, after = shown.t_s < 2.0, shown.t_s > 4.0
    np.testing.assert_allclose(slowed.t_s[before], shown.t_s[before], atol=2e-9)
    rate = np.diff(slowed.t_s) / np.diff(shown.t_s)
    middle = (shown.t_s[1:] > 2.3) & (shown.t_s[1:] < 3.7)
    np.testing.assert_allclose(rate[middle], 3.0, atol=1e-6)
    np.testing.assert_allclose(np.diff(slowed.t_s[after]), np.diff(shown.t_s[after]), atol=2e-9)
    assert (np.diff(slowed.t_ns) > 0).all()
    assert apply(shown, Slow(1.0, 2.0, 4.0)).t_ns.tolist() == shown.t_ns.tolist()


def test_scaling_is_about_the_first_posture_and_of_its_digit_alone() -> None:
    shown = motion()
    scaled = apply(shown, Scale("index", 0.5))
    first = shown.joints_rad[:9, INDEX_PIP]
    middle = np.median(first)
    np.testing.assert_allclose(
        scaled.joints_rad[:, INDEX_PIP], middle + 0.5 * (shown.joints_rad[:, INDEX_PIP] - middle)
    )
    np.testing.assert_array_equal(scaled.joints_rad[:, 9:], shown.joints_rad[:, 9:])
    assert scaled.joint_covariance_rad2[0, INDEX_PIP, INDEX_PIP] == pytest.approx(0.25 * 0.02**2)
    one = apply(shown, Scale("index_pip", 0.5))
    np.testing.assert_array_equal(one.joints_rad[:, INDEX_PIP - 2], shown.joints_rad[:, INDEX_PIP - 2])


def test_no_operation_touches_what_it_was_given() -> None:
    shown, untouched = motion(0.01), motion(0.01)
    apply(shown, Trim(0.5, 5.5), Smooth(40.0), Slow(2.0, 1.0, 2.0), Scale("ring", 1.1))
    for field in fields(shown):
        if field.name not in ("side", "geometry"):
            np.testing.assert_array_equal(getattr(shown, field.name), getattr(untouched, field.name))


@pytest.mark.parametrize(
    ("operation", "words"),
    [
        (Trim(-1.0, 3.0), "span of the take is -1 to 3 s"),
        (Trim(2.0, 2.5), "1 s or longer"),
        (Trim(float("nan"), 3.0), "span of the take"),
        (Smooth(4.0), "5 to 500"),
        (Slow(0.5, 1.0, 3.0), "1 to 10"),
        (Slow(2.0, 3.0, 3.2), "0.5 s or longer"),
        (Scale("toe", 1.0), "'toe'"),
        (Scale("index", float("nan")), "0 to 2"),
        (Scale("index_mcp_abduction", -1.0), "0 to 2"),
    ],
)
def test_what_is_out_of_bounds_is_refused(operation: Operation, words: str) -> None:
    with pytest.raises(Refused, match=words):
        apply(motion(), operation)


def test_scaling_beyond_a_hand_is_refused_with_joint_time_and_bound() -> None:
    wide = apply(motion(), Scale("little_pip", 2.0))
    with pytest.raises(Refused, match=r"little_pip at 3\.\d s is .* deg, but must be .* to 115 deg"):
        apply(wide, Scale("little_pip", 2.0))


def test_a_retouched_take_is_a_new_take_that_says_what_was_done(tmp_path: Path) -> None:
    parent = take_file(tmp_path)
    kept = parent.read_bytes()
    operations = (Trim(0.5, 5.5), Slow(2.0, 1.0, 2.0), Scale("index", 0.8))
    sealed = write_retouched(parent, tmp_path / "new.mcap", operations, "dr-a", "too fast", "1")
    assert parent.read_bytes() == kept
    verify(sealed.path)
    with SessionReader(sealed.path) as reader:
        header, events, got = reader.header, list(reader.events()), read_motion(reader)
        texts = reader.metadata(METADATA)
    assert header.parents == (verify(parent).sha256,)
    assert header.source == "virtual-camera, retouched"
    assert (header.side, header.subject_id, header.exercise) == ("left", "P-1", "open_close")
    assert [event.text for event in events] == [
        f"Retouched from take {header.parents[0]} by dr-a: too fast",
        "Trimmed to 0.50 to 5.50 s.",
        "Slowed by 2 from 1.00 to 2.00 s.",
        "Scaled the movement of index by 0.8 about its first posture.",
    ]
    assert read_operations(texts["operations"]) == operations
    assert texts["author"] == "dr-a"
    expected = retouch(motion(), operations).motion
    np.testing.assert_allclose(got.joints_rad, expected.joints_rad)
    np.testing.assert_array_equal(got.t_ns, expected.t_ns)
    assert measure_file(sealed.path).metrics


def test_it_can_be_retouched_again_and_played(tmp_path: Path) -> None:
    first = write_retouched(take_file(tmp_path), tmp_path / "1.mcap", (Scale("index", 0.9),), "a", "b", "1")
    second = write_retouched(first.path, tmp_path / "2.mcap", (Smooth(30.0),), "a", "c", "1")
    with SessionReader(second.path) as reader:
        assert reader.header.parents == (first.sha256,)
        assert reader.header.source == "virtual-camera, retouched"
        shown = read_motion(reader)
    device = capabilities("exoskeleton")
    built = build_reference(
        shown,
        patient_geometry=average_hand(),
        patient_side="right",
        driven_joints=device.joint_names,
        limits=shipped_limits(device.joint_names, device.q_min_rad, device.q_max_rad),
        take_digest=second.sha256,
        speed=0.5,
        device=device,
    )
    assert built.path.take_digest == second.sha256


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"author": " "}, "author of the retouch is missing"),
        ({"reason": ""}, "reason for the retouch is missing"),
        ({"operations": ()}, "without an operation"),
        ({"operations": (Scale("index", 9.0),)}, "0 to 2"),
    ],
)
def test_a_refused_retouch_leaves_no_file(tmp_path: Path, change: dict[str, Any], words: str) -> None:
    order: dict[str, Any] = {"operations": (Trim(0.0, 3.0),), "author": "a", "reason": "b"}
    with pytest.raises(Refused, match=words):
        write_retouched(
            take_file(tmp_path), tmp_path / "new.mcap", software_version="1", **{**order, **change}
        )
    assert [path.name for path in tmp_path.glob("new*")] == []


def test_operations_are_read_strictly() -> None:
    with pytest.raises(Refused, match="unreadable"):
        read_operations('[{"type":"grow"}]')
    with pytest.raises(Refused, match="unreadable"):
        read_operations(msgspec.json.encode({"a": 1}).decode())
