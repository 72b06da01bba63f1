"""C3D files that the library itself wrote, whole and broken."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import ezc3d
import numpy as np
import pytest

from rehab_app.hand.marker_model import MarkerModel
from rehab_app.hand.protocol import load_protocol
from rehab_app.hand.subject import average_subject
from rehab_app.recording.importers import import_recording
from rehab_app.recording.importers.c3d import read_c3d
from rehab_app.recording.take import read_motion
from robot_iface.kinematics import couple_dip
from sessions.errors import Refused
from sessions.records import JOINTS
from sessions.records.fields import Float64
from sessions.store import SessionReader

NAMES = load_protocol("thesis25").names
GAP = (slice(40, 50), NAMES.index("index_tip"))


def angles() -> Float64:
    joints = np.zeros((150, 21))
    share = 0.5 * (1 - np.cos(np.linspace(0, 2 * np.pi, 150)))
    for name in ("index", "middle", "ring", "little"):
        joints[:, JOINTS.index(f"{name}_mcp_flexion")] = 0.9 * share
        joints[:, JOINTS.index(f"{name}_pip")] = 1.1 * share
    return couple_dip(joints)


def markers() -> Float64:
    """A closing hand in the markers of the thesis at 100 Hz, shape (150, 25, 3), with noise of .3 mm."""
    protocol = load_protocol("thesis25")
    clean = MarkerModel(average_subject(protocol, "right"), protocol).positions(angles())
    return clean + [0.2, -0.1, 0.9] + 3e-4 * np.random.default_rng(11).standard_normal(clean.shape)


def write(path: Path, names: tuple[str, ...] = NAMES, unit: str = "mm", factor: float = 1e3) -> Path:
    p_m = markers()
    file: Any = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [100.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = [*names, "*26"]
    file["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    points = np.ones((4, 26, len(p_m)))
    points[:3, :25] = factor * p_m.transpose(2, 1, 0)
    file["data"]["points"] = points
    residuals = np.zeros((1, 26, len(p_m)))
    residuals[0, GAP[1], GAP[0]] = -1.0
    file["data"]["meta_points"]["residuals"] = residuals
    file.write(str(path))
    return path


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1e3), ("m", 1.0), ("cm", 100.0), ("", 1e3)])
def test_markers_units_gaps_and_rate(tmp_path: Path, unit: str, factor: float) -> None:
    read = read_c3d(write(tmp_path / "a.c3d", unit=unit, factor=factor))
    assert read.series.names == NAMES
    np.testing.assert_allclose(np.diff(read.series.t_s), 0.01)
    expected = markers()
    expected[GAP] = np.nan
    np.testing.assert_allclose(read.series.p_camera_m, expected, atol=1e-6)


def test_vicon_labels_of_figure_3_9(tmp_path: Path) -> None:
    digits = {"thumb": 1, "index": 2, "middle": 3, "ring": 4, "little": 5}
    labels = tuple(
        f"Hand:{name.split('_')[1].upper()}{digits[name.split('_')[0]]}"
        if name.split("_")[0] in digits
        else name.upper()
        for name in NAMES
    )
    assert "Hand:MCP2" in labels
    assert "CMC4" in labels
    assert read_c3d(write(tmp_path / "a.c3d", names=labels)).series.names == NAMES


def test_a_c3d_becomes_a_take(tmp_path: Path) -> None:
    taken = import_recording(write(tmp_path / "a.c3d"), "right")
    assert (taken.source, taken.landmarks, taken.frames, taken.gaps) == ("c3d", 25, 150, 1)
    sealed = taken.write(tmp_path / "a.mcap", exercise="grasp", software_version="0")
    with SessionReader(sealed.path) as reader:
        motion = read_motion(reader)
    pip = JOINTS.index("middle_pip")
    assert np.abs(motion.joints_rad[:, pip] - angles()[:, pip]).max() < np.radians(8)


def test_what_is_no_whole_c3d_is_refused_in_a_sentence(tmp_path: Path) -> None:
    whole = write(tmp_path / "a.c3d").read_bytes()
    bad = tmp_path / "b.c3d"
    for content, said in (
        (b"", "0 bytes"),
        (b"x" * 2000, "no C3D"),
        (whole[:300], "no C3D"),
        (whole[: len(whole) // 2], "shorter than it states"),
        (whole[:1400], "shorter than it states"),
    ):
        bad.write_bytes(content)
        with pytest.raises(Refused, match=said):
            import_recording(bad, "right")
    with pytest.raises(Refused, match="inch"):
        read_c3d(write(bad, unit="inch"))
    with pytest.raises(Refused, match="beyond 100 m"):
        read_c3d(write(bad, unit="m", factor=1e3))
    with pytest.raises(Refused, match="twice"):
        read_c3d(write(bad, names=(NAMES[1], *NAMES[1:])))
    with pytest.raises(Refused, match="without hand markers"):
        import_recording(write(bad, names=tuple(f"lleg{row}" for row in range(25))), "right")


def test_turned_bytes_never_raise_anything_else(tmp_path: Path) -> None:
    whole = write(tmp_path / "a.c3d").read_bytes()
    random = np.random.default_rng(3)
    bad = tmp_path / "b.c3d"
    for _ in range(400):
        content = bytearray(whole)
        for place in random.integers(0, 1536, 4):
            content[place] = random.integers(256)
        bad.write_bytes(content)
        with contextlib.suppress(Refused):
            read_c3d(bad)


def test_scaled_integers_say_the_same(tmp_path: Path) -> None:
    whole = bytearray(write(tmp_path / "a.c3d").read_bytes())
    begin = 512 * (int(np.frombuffer(whole, "<u2", 1, 16)[0]) - 1)
    floats = np.frombuffer(bytes(whole), "<f4", 150 * 26 * 4, begin).reshape(-1, 4)
    scaled = np.round(np.column_stack([floats[:, :3] / 0.05, floats[:, 3]])).astype("<i2")
    # an exporter may leave numbers where the residual says that there is no point
    gone = scaled.reshape(150, 26, 4)[GAP]
    assert (gone[:, 3] < 0).all()
    gone[:, :3] = 777
    scaled.reshape(150, 26, 4)[GAP] = gone
    whole[12:16] = np.array(0.05, "<f4").tobytes()
    path = tmp_path / "b.c3d"
    path.write_bytes(bytes(whole[:begin]) + scaled.tobytes())
    expected = markers()
    expected[GAP] = np.nan
    np.testing.assert_allclose(read_c3d(path).series.p_camera_m, expected, atol=3e-5)
