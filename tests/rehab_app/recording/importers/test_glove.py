"""A glove's CSV: sensors to joints, chains of Tables 3.2 and 3.3, takes, refusals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rehab_app.grasp.shape_take import shape_json, shape_of_take, shape_of_takes
from rehab_app.recording.importers import import_recording
from rehab_app.recording.importers.glove import glove_joints, read_glove
from rehab_app.recording.take import read_motion
from robot_iface.kinematics import average_hand, forward
from sessions.errors import Refused
from sessions.records import JOINTS, LANDMARKS, Status
from sessions.records.fields import Float64
from sessions.store import SessionReader

INDEX = LANDMARKS.index("index_mcp")


def sensors_deg() -> Float64:
    """Three closings in 9 s at 30 Hz, from a rest that is nowhere 0, shape (271, 22)."""
    random = np.random.default_rng(7)
    share = 0.5 * (1 - np.cos(2 * np.pi * np.arange(271) / 90.0))
    closed = random.uniform(20.0, 60.0, 22)
    closed[[3, 7, 11, 15]] = [10.0, -4.0, -3.0, -5.0]
    return random.uniform(-8.0, 12.0, 22) + share[:, None] * closed


def write(path: Path, table: Float64, head: str = "") -> Path:
    rows = [",".join("" if np.isnan(value) else f"{value:.4f}" for value in row) for row in table]
    path.write_text(head + "\n".join(rows) + "\n")
    return path


def dh(theta: float, offset: float, a: float, alpha: float) -> Float64:
    """One link in the classical Denavit-Hartenberg form of the thesis."""
    ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array(
        [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, offset], [0, 0, 0, 1]]
    )


def test_the_index_is_the_chain_of_table_3_2() -> None:
    geometry = average_hand(0.189, "right")
    p, m, d = geometry.bones_m[1]
    for abduction, mcp, pip, dip in np.random.default_rng(2).uniform(
        [-0.3, 0, 0, 0], [0.3, 1.4, 1.6, 1.2], (20, 4)
    ):
        joints = np.zeros(21)
        for name, angle in (("mcp_abduction", abduction), ("mcp_flexion", mcp), ("pip", pip), ("dip", dip)):
            joints[JOINTS.index(f"index_{name}")] = angle
        ours = forward(geometry, joints).landmarks_m[INDEX : INDEX + 4]
        at = dh(0.0, 0.0, 0.08, -np.pi / 2) @ dh(abduction, 0.0, 0.0, np.pi / 2)
        chain = [at[:3, 3]]
        for theta, a in ((mcp, p), (pip, m), (dip, d)):
            at = at @ dh(theta, 0.0, a, 0.0)
            chain.append(at[:3, 3])
        for one in range(4):
            for other in range(one):
                apart = np.linalg.norm(chain[one] - chain[other])
                assert np.linalg.norm(ours[one] - ours[other]) == pytest.approx(apart, abs=1e-12)
        # where the tip stands seen from the straight metacarpal: along it, aside and out of the palm
        straight = forward(geometry, np.zeros(21)).landmarks_m[INDEX : INDEX + 4]
        along = (straight[3] - straight[0]) / np.linalg.norm(straight[3] - straight[0])
        assert (ours[3] - ours[0]) @ along == pytest.approx((chain[3] - chain[0])[0], abs=1e-9)


def test_sensors_go_to_their_joints_and_rest_is_0(tmp_path: Path) -> None:
    table = sensors_deg()
    glove = read_glove(write(tmp_path / "a.csv", table))
    assert (glove.sensors_rad[0] == 0).all()
    np.testing.assert_allclose(glove.sensors_rad, np.radians(table - table[0]), atol=1e-5)
    joints = glove_joints(np.eye(22))
    for sensor, name in (
        (0, "thumb_cmc_flexion"),
        (2, "thumb_ip"),
        (4, "index_mcp_flexion"),
        (14, "ring_dip"),
    ):
        assert joints[sensor].nonzero()[0].tolist() == [JOINTS.index(name)]
        assert joints[sensor].sum() == 1.0
    # the middle finger stays: spread between middle and ring takes ring and little to the ulnar side
    assert joints[11, JOINTS.index("ring_mcp_abduction")] == -1.0
    assert joints[11, JOINTS.index("little_mcp_abduction")] == -1.0
    assert not joints[19:].any()


def test_a_glove_becomes_a_take_of_the_stated_hand(tmp_path: Path) -> None:
    table = sensors_deg()
    table[5, 4] = np.nan
    stated = "# hand_length_m: 0.175\n# rate_hz: 60\n"
    taken = import_recording(write(tmp_path / "a.csv", table, stated), "left")
    assert (taken.source, taken.landmarks, taken.gaps, taken.frames) == ("glove-csv", 0, 0, 271)
    assert taken.duration_s == pytest.approx(4.5)
    assert np.isnan(taken.residual_m)
    sealed = taken.write(tmp_path / "a.mcap", exercise="grasp", software_version="0")
    with SessionReader(sealed.path) as reader:
        assert reader.header.marker_names == ()
        motion = read_motion(reader)
    joints = glove_joints(np.radians(table - table[0]))
    np.testing.assert_allclose(motion.joints_rad, joints, atol=1e-5)
    placed = forward(average_hand(0.175, "left"), joints).landmarks_m[:, 7]
    np.testing.assert_allclose(motion.fingertips_palm_m[:, 1], placed, atol=1e-6)
    assert motion.joint_status[5, JOINTS.index("index_mcp_flexion")] == Status.LOST
    assert (motion.joint_status[:, JOINTS.index("middle_mcp_abduction")] == Status.ESTIMATED).all()


def test_shape_of_a_take_is_the_mean_over_its_closings(tmp_path: Path) -> None:
    table = sensors_deg()
    taken = import_recording(write(tmp_path / "a.csv", table), "right")
    path = taken.write(tmp_path / "a.mcap", exercise="grasp", software_version="0").path
    found = shape_of_take(path)
    np.testing.assert_allclose(found.t_s, [1.5, 4.5, 7.5], atol=0.04)
    content = shape_json(found)
    assert content["repetitions"] == 3
    assert content["aperture_rad"]["count"] == 3
    assert content["aperture_rad"]["sd"] < 1e-3
    assert 0.005 < content["radius_m"]["index"]["pip"]["mean"] < 0.1
    assert (
        content["curvature_per_m"]["ring"]["mcp"]["mean"]
        == content["curvature_per_m"]["ring"]["tip"]["mean"]
        == 0
    )
    assert list(content["curvature_per_m"]["thumb"]) == ["cmc", "mcp", "ip", "tip"]
    assert set(content["radius_m"]["thumb"]) == {"mcp", "ip"}
    assert shape_json(shape_of_takes([path, path]))["repetitions"] == 6
    with pytest.raises(Refused, match="a take that exists"):
        shape_of_take(tmp_path / "none.mcap")


def test_bad_gloves_are_refused_in_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "b.csv"
    table = sensors_deg()
    for content, said in (
        ("a,b,c\n1,2,3\n", "22 sensors"),
        (",".join(["1"] * 21) + "\n", "22 sensors"),
        (",".join(["1"] * 22) + "\n" + ",".join(["1"] * 20) + "\n", "22 sensors"),
        (",".join(["x1"] * 22) + "\n" + ",".join(["x"] * 22) + "\n", "numbers"),
        (",".join(["inf"] * 22) + "\n", "infinite"),
        (",".join([""] * 22) + "\n", "whole frame"),
        (",".join(["1"] * 22) + "\n" + ",".join(["255"] * 22) + "\n", "degrees from rest"),
        (",".join(["1"] * 22) + "\n", "0.00 s long"),
        ("# hand_length_m: 18\n" + ",".join(["1"] * 22) + "\n", "hand_length_m"),
        ("# only a comment\n", "0 frames"),
        ("\x00\x01\n", "22 sensors"),
    ):
        path.write_text(content)
        with pytest.raises(Refused, match=said):
            import_recording(path, "right")
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(Refused, match="no text"):
        import_recording(path, "right")
    timed = np.column_stack([np.arange(271) / 30.0, table])
    head = "t_s," + ",".join(f"s{row}" for row in range(22)) + "\n"
    assert read_glove(write(path, timed, head)).t_s[-1] == pytest.approx(9.0, abs=1e-3)
    timed[3, 0] = 0.0
    with pytest.raises(Refused, match="rising"):
        import_recording(write(path, timed, head), "right")
    with pytest.raises(Refused, match="no markers"):
        import_recording(write(path, table), "right", "thesis25")
