"""A file of detections is read as it stands, or refused by one sentence that names what is wrong."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rehab_app.recording.detections_file import read_detections
from rehab_app.recording.detections_noise import USUAL_M, USUAL_PX
from sessions.errors import Refused

Arrays = dict[str, Any]
CAMERA = {"fx": 525.0, "fy": 520.0, "cx": 319.5, "cy": 239.5, "width": 640, "height": 480}
FRAMES = 40


def arrays(seed: int = 0, noise_px: float = 0.4, noise_m: float = 0.001) -> Arrays:
    """Ten markers moving slowly, two false blobs a frame, rows in random order."""
    rng = np.random.default_rng(seed)
    start = rng.uniform((100.0, 100.0), (540.0, 380.0), (10, 2))
    t_s = np.arange(FRAMES) / 30.0
    pixel = start + 40.0 * np.sin(t_s)[:, None, None] + rng.normal(0.0, noise_px, (FRAMES, 10, 2))
    pixel = np.concatenate([pixel, rng.uniform((0, 0), (640, 480), (FRAMES, 2, 2))], axis=1)
    depth = 0.7 + rng.normal(0.0, noise_m, (FRAMES, 12))
    shuffled = rng.permutation(FRAMES * 12)
    return {
        "frame_t_s": 5.0 + t_s,
        "frame": np.repeat(np.arange(FRAMES), 12)[shuffled],
        "u_px": pixel[..., 0].ravel()[shuffled],
        "v_px": pixel[..., 1].ravel()[shuffled],
        "depth_m": depth.ravel()[shuffled],
        "init_name": np.array(["wrist", "index_tip"]),
        "init_u_px": start[:2, 0],
        "init_v_px": start[:2, 1],
        **CAMERA,
    }


def save(folder: Path, content: Arrays) -> Path:
    path = folder / "points.npz"
    np.savez(path, **content)
    return path


def test_every_row_comes_back_in_its_frame(tmp_path: Path) -> None:
    content = arrays()
    content["depth_m"][7] = np.nan
    file = read_detections(save(tmp_path, content))
    seen: list[int] = []
    for index, (detections, rows) in enumerate(file.captures()):
        assert detections.t_capture_ns == pytest.approx(index * 1e9 / 30.0, abs=1)
        assert (content["frame"][rows] == index).all()
        assert detections.pixel_px[:, 0] == pytest.approx(content["u_px"][rows])
        known = np.isfinite(content["depth_m"][rows])
        assert detections.p_camera_m[known, 2] == pytest.approx(content["depth_m"][rows][known])
        assert np.isnan(detections.p_camera_m[~known]).all()
        seen.extend(rows.tolist())
    assert sorted(seen) == list(range(len(content["frame"])))
    assert file.labels is not None
    assert file.labels.names == ("wrist", "index_tip")
    assert file.cameras[0].intrinsics.fy_px == 520.0


def test_noise_worse_than_usual_is_read_from_the_jitter_of_the_points(tmp_path: Path) -> None:
    usual = read_detections(save(tmp_path, arrays())).noise
    assert (usual.pixel_std_px[0], usual.depth_std_m[0]) == (USUAL_PX, USUAL_M)
    worse = read_detections(save(tmp_path, arrays(noise_px=1.8, noise_m=0.006))).noise
    assert worse.pixel_std_px[0] == pytest.approx(1.8, rel=0.15)
    assert worse.depth_std_m[0] == pytest.approx(0.006, rel=0.2)


def test_stated_noise_and_similarity_are_taken(tmp_path: Path) -> None:
    content = arrays()
    count = len(content["frame"])
    content |= {"pixel_std_px": np.full(count, 0.3), "depth_std_m": np.full(count, 0.004)}
    content["similarity"] = np.linspace(0.0, 1.0, count)
    file = read_detections(save(tmp_path, content))
    assert (file.noise.pixel_std_px == 0.3).all()
    assert (file.noise.depth_std_m == 0.004).all()
    assert (file.similarity == content["similarity"]).all()


def test_zero_and_missing_depth_say_the_same(tmp_path: Path) -> None:
    content = arrays()
    content["depth_m"][3] = 0.0
    assert np.isnan(read_detections(save(tmp_path, content)).depth_m[3])
    del content["depth_m"]
    file = read_detections(save(tmp_path, content))
    assert np.isnan(file.depth_m).all()
    assert "no depth" in file.complaints[0]


def test_two_cameras_share_one_frame(tmp_path: Path) -> None:
    content = arrays()
    pose = np.tile(np.eye(4), (2, 1, 1))
    pose[1, :3, :3] = np.diag([-1.0, 1.0, -1.0])
    pose[1, :3, 3] = (0.0, 0.0, 1.4)
    content |= {"T_tracking_camera": pose, "fx": np.array([525.0, 500.0])}
    content["view"] = np.arange(len(content["frame"])) % 2
    file = read_detections(save(tmp_path, content))
    detections, rows = next(iter(file.captures()))
    assert (detections.view == content["view"][rows]).all()
    assert detections.origin_camera_m[detections.view == 1] == pytest.approx(np.tile((0.0, 0.0, 1.4), (6, 1)))
    u, depth = content["u_px"][rows], content["depth_m"][rows]
    other = detections.view == 1
    assert detections.p_camera_m[other, 0] == pytest.approx((-(u - 319.5) / 500.0 * depth)[other])
    assert detections.p_camera_m[other, 2] == pytest.approx((1.4 - depth)[other])


def without(name: str) -> Callable[[Arrays], None]:
    def spoil(content: Arrays) -> None:
        del content[name]

    return spoil


def put(name: str, value: object) -> Callable[[Arrays], None]:
    def spoil(content: Arrays) -> None:
        content[name] = value

    return spoil


def at(name: str, row: int, value: float) -> Callable[[Arrays], None]:
    def spoil(content: Arrays) -> None:
        content[name] = np.array(content[name], dtype=np.float64)
        content[name][row] = value

    return spoil


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (without("frame_t_s"), "with frame_t_s"),
        (without("u_px"), "with u_px"),
        (without("fx"), "with fx"),
        (without("init_u_px"), "with init_u_px"),
        (put("v_px", np.zeros(3)), "v_px is of shape"),
        (put("init_v_px", np.zeros(3)), "as init_name"),
        (put("init_name", np.array(["wrist", "wrist"])), "naming wrist twice"),
        (put("init_name", np.array(["wrist", None], dtype=object)), "a pickle is never opened"),
        (put("u_px", np.array(["a", "b"])), "of texts"),
        (at("frame", 0, 40.0), "0 to 39"),
        (at("frame", 5, -1.0), "0 to 39"),
        (at("frame", 5, 1.5), "1.5 in row 5"),
        (at("frame_t_s", 3, 0.0), "rising"),
        (at("frame_t_s", 3, np.nan), "not finite"),
        (at("u_px", 9, np.nan), "not finite in row 9"),
        (at("depth_m", 2, -0.5), "-0.5 m in row 2"),
        (put("depth_m", np.full(FRAMES * 12, 700.0)), "depths in m"),
        (put("width", 160), "principal point"),
        (put("height", 300), "as width and height say"),
        (put("fx", -5.0), "intrinsics"),
        (put("fx", np.nan), "not finite"),
        (put("fx", np.array([525.0, 525.0])), "T_tracking_camera"),
        (put("T_tracking_camera", np.zeros((2, 4, 4))), "a rigid pose"),
        (put("T_tracking_camera", np.tile(np.eye(4), (2, 1, 1))), "with view"),
        (put("T_tracking_camera", np.eye(3)), "T_tracking_camera"),
        (put("T_tracking_camera", np.array(1.0)), "T_tracking_camera"),
        (put("frame", np.zeros(0)), "without any detection"),
        (put("pixel_std_px", np.zeros(FRAMES * 12)), "not above 0"),
    ],
)
def test_nonsense_is_refused_by_name(tmp_path: Path, spoil: Callable[[Arrays], None], words: str) -> None:
    content = arrays()
    spoil(content)
    with pytest.raises(Refused) as refused:
        read_detections(save(tmp_path, content))
    assert words in str(refused.value)
    assert str(refused.value).endswith(".")


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04 cut"])
def test_no_archive_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "points.npz"
    path.write_bytes(content)
    with pytest.raises(Refused):
        read_detections(path)
    with pytest.raises(Refused, match="exists"):
        read_detections(tmp_path / "absent.npz")
