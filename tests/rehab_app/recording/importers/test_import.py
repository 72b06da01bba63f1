from __future__ import annotations

import contextlib
import io
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rehab_app.errors import REFUSALS
from rehab_app.recording.importers import ImportedTake, import_recording
from rehab_app.recording.take import read_motion
from sessions.errors import Refused
from sessions.records import JOINTS, Status
from sessions.records.fields import Float64
from sessions.records.topics import HAND_POSE, MARKERS
from sessions.store import SessionReader


def written(take: ImportedTake, folder: Path) -> Path:
    return take.write(folder / "take.mcap", exercise="grasp", software_version="0").path


def test_a_tsv_becomes_a_take_with_its_gaps(tsv: Path, tmp_path: Path) -> None:
    take = import_recording(tsv, "right")
    assert (take.source, take.protocol.name, take.landmarks) == ("qualisys-tsv", "mocap13", 13)
    assert (take.frames, take.gaps) == (200, 1)
    assert take.duration_s == pytest.approx(1.99)
    assert take.residual_m < 0.002
    with SessionReader(written(take, tmp_path)) as reader:
        motion, markers = read_motion(reader), reader.columns(MARKERS)
        assert reader.header.utc_start_ns == 1_629_991_164_317_000_000
        residual = reader.columns(HAND_POSE)["residual_m"]
    tip = take.protocol.names.index("thumb_tip")
    assert np.isnan(markers["p_camera_m"][50:60, tip]).all()
    assert (markers["status"][50:60, tip] == Status.LOST).all()
    assert (motion.joint_status[50:60, JOINTS.index("thumb_ip")] != Status.MEASURED).all()
    assert (residual > 0).all()
    pip = motion.joints_rad[:, JOINTS.index("index_pip")]
    assert np.rad2deg(np.percentile(pip, 98) - np.percentile(pip, 2)) == pytest.approx(57.3, abs=5)


def test_landmarks_become_a_take_of_the_stated_side(tmp_path: Path, landmarks_m: Float64) -> None:
    path = tmp_path / "hand.npz"
    np.savez_compressed(path, landmarks_m=landmarks_m.astype(np.float32))
    take = import_recording(path, "left")
    assert (take.protocol.name, take.landmarks, take.frames, take.gaps) == ("mediapipe21", 21, 60, 0)
    with SessionReader(written(take, tmp_path)) as reader:
        assert reader.header.side == "left"
        motion = read_motion(reader)
    mcp = motion.joints_rad[:, JOINTS.index("ring_mcp_flexion")]
    assert np.rad2deg(mcp.max() - mcp.min()) == pytest.approx(57.3, abs=5)


def test_times_of_ones_own(tmp_path: Path, landmarks_m: Float64) -> None:
    for extra, duration_s in (({"fps": 20.0}, 59 / 20), ({"t_s": np.arange(60) * 0.1}, 5.9)):
        path = tmp_path / "hand.npz"
        np.savez(path, landmarks_m=landmarks_m, **extra)
        assert import_recording(path, "left").duration_s == pytest.approx(duration_s)


def swap(old: str, new: str) -> Callable[[str], str]:
    def change(text: str) -> str:
        assert old in text
        return text.replace(old, new)

    return change


def blank(marker: str) -> Callable[[str], str]:
    """All values of a marker empty."""

    def change(text: str) -> str:
        lines = text.splitlines()
        names = lines[6].split("\t")[1:]
        first = 2 + 3 * names.index(marker)
        for row in range(8, len(lines)):
            fields = lines[row].split("\t")
            fields[first : first + 3] = ["", "nan", ""]
            lines[row] = "\t".join(fields)
        return "\n".join(lines)

    return change


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (swap("hand_top", "box_top"), "without marker hand_top"),
        (lambda text: text.replace("_tip", "_a").replace("_middle", "_b"), "without hand markers"),
        (blank("index_tip"), "marker index_tip is never seen"),
        (swap("MARKER_NAMES", "MARKERS"), "MARKER_NAMES"),
        (swap("FREQUENCY\t100", "FREQUENCY\tfast"), "FREQUENCY"),
        (swap("FREQUENCY\t100", "FREQUENCY\t0"), "0 Hz"),
        (lambda text: text[:120], "MARKER_NAMES"),
        (lambda text: text[:300], "0 frames"),
        (lambda text: "\n".join(text.splitlines()[:8]), "0 frames"),
        (lambda text: "\n".join(text.splitlines()[:100]), "cut after"),
        (lambda text: text[:-40], "fields"),
        (swap("0.50000\t", "half\t"), "numbers"),
        (swap("0.50000\t", "inf\t"), "infinite"),
        (swap("0.50000\t", "0.10000\t"), "rising"),
        (swap("NO_OF_FRAMES\t200", "NO_OF_FRAMES\tmany"), "NO_OF_FRAMES"),
        (
            lambda text: swap("NO_OF_FRAMES\t200", "NO_OF_FRAMES\t80")("\n".join(text.splitlines()[:88])),
            "1 s or longer",
        ),
        (swap("\thand_left\t", "\thand_top\t"), "twice"),
        (lambda text: text.replace("\t1.000\t2.000\t3.000", "\t1e30\t2\t3"), "100 m"),
        (lambda _: "", "0 bytes"),
    ],
)
def test_a_bad_tsv_is_refused_in_one_sentence(
    tsv: Path, tsv_text: str, change: Callable[[str], str], says: str
) -> None:
    text = change(tsv_text)
    assert text != tsv_text
    tsv.write_text(text)
    with pytest.raises(Refused) as refusal:
        import_recording(tsv, "right")
    assert says in str(refusal.value)
    assert "\n" not in str(refusal.value)


def npz(**arrays: Any) -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()


def bomb() -> bytes:
    """An archive whose array claims 2**60 numbers."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        member = io.BytesIO()
        np.lib.format.write_array_header_1_0(
            member, {"descr": "<f8", "fortran_order": False, "shape": (2**50, 21, 3)}
        )
        archive.writestr("landmarks_m.npy", member.getvalue() + bytes(100))
    return stream.getvalue()


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (lambda _: b"no archive at all", "no whole .npz"),
        (lambda good: npz(landmarks_m=good)[:-200], "no whole .npz"),
        (lambda good: npz(points=good), "holding points"),
        (lambda good: npz(landmarks_m=good[:, :20]), "(N, 21, 3)"),
        (lambda good: npz(landmarks_m=good[..., :2]), "(N, 21, 3)"),
        (lambda good: npz(landmarks_m=good.astype(object)), "pickle"),
        (lambda good: npz(landmarks_m=good.astype(str)), "real numbers"),
        (lambda good: npz(landmarks_m=good[:20]), "1 s or longer"),
        (lambda good: npz(landmarks_m=good[:0]), "0 frames"),
        (lambda good: npz(landmarks_m=good * np.nan), "never seen"),
        (lambda good: npz(landmarks_m=good * 1e4), "100 m"),
        (lambda good: npz(landmarks_m=good * 10), "m long"),
        (lambda good: npz(landmarks_m=good, fps=0.0), "fps"),
        (lambda good: npz(landmarks_m=good, t_s=np.zeros(60)), "rising"),
        (lambda good: npz(landmarks_m=good, t_s=np.arange(59)), "t_s"),
        (lambda _: bomb(), "bytes of numbers"),
    ],
)
def test_bad_landmarks_are_refused_in_one_sentence(
    tmp_path: Path, landmarks_m: Float64, content: Callable[[Float64], bytes], says: str
) -> None:
    path = tmp_path / "hand.npz"
    path.write_bytes(content(landmarks_m))
    with pytest.raises(Refused) as refusal:
        import_recording(path, "left")
    assert says in str(refusal.value)


def test_side_suffix_and_path_are_checked_first(tsv: Path, tmp_path: Path) -> None:
    with pytest.raises(Refused, match="left or right"):
        import_recording(tsv, "both")
    other = tmp_path / "take.bvh"
    other.write_bytes(b"x")
    with pytest.raises(Refused, match=r"\.tsv, \.npz"):
        import_recording(other, "right")
    with pytest.raises(Refused, match="a file that exists"):
        import_recording(tmp_path / "absent.tsv", "right")
    with pytest.raises(Refused, match="thesis25"):
        import_recording(tsv, "right", "mocap14")


def test_a_refused_import_leaves_no_file(tsv: Path, tmp_path: Path) -> None:
    take = import_recording(tsv, "right")
    (tmp_path / "taken.mcap").write_bytes(b"mine")
    with pytest.raises(Refused):
        take.write(tmp_path / "taken.mcap", exercise="grasp", software_version="0")
    assert {path.name for path in tmp_path.iterdir()} == {"take.tsv", "taken.mcap"}
    assert (tmp_path / "taken.mcap").read_bytes() == b"mine"


@pytest.mark.parametrize("suffix", [".tsv", ".npz"])
def test_damaged_files_are_refused_or_read_but_never_a_traceback(
    tmp_path: Path, tsv_text: str, landmarks_m: Float64, suffix: str
) -> None:
    rng = np.random.default_rng(5)
    whole = tsv_text.encode() if suffix == ".tsv" else npz(landmarks_m=landmarks_m)
    path = tmp_path / f"take{suffix}"
    for turn in range(40):
        damaged = bytearray(whole)
        if turn % 2:
            damaged = damaged[: rng.integers(0, len(damaged))]
        else:
            for _ in range(3):
                damaged[rng.integers(0, 250)] = rng.integers(0, 256)
        path.write_bytes(bytes(damaged))
        with contextlib.suppress(*REFUSALS):
            import_recording(path, "right")
