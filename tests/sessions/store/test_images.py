"""Image topics: through the file and back, for strangers, and against damage."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from sessions.errors import Refused
from sessions.records import CameraCalibration, ColourImage, DepthImage, SessionHeader
from sessions.records.topics import CAMERA_CALIBRATION, CAMERA_COLOUR, CAMERA_DEPTH
from sessions.store import SessionReader, SessionWriter
from sessions.store.codec import codec_for
from sessions.store.damage import Damaged

LENS = CameraCalibration(
    t_ns=5,
    frame_id="camera",
    width_px=5,
    height_px=3,
    camera_matrix_px=np.array([[525.0, 0.0, 2.0], [0.0, 526.0, 1.0], [0.0, 0.0, 1.0]]),
)
COLOUR = ColourImage(t_ns=6, frame_id="camera", format="jpeg", encoded=np.arange(256).astype(np.uint8))
DEPTH = DepthImage(
    t_ns=6,
    frame_id="camera",
    depth_mm=np.arange(15).reshape(3, 5).astype(np.uint16) * 4000,
)
RECORDS = ((CAMERA_CALIBRATION, LENS), (CAMERA_COLOUR, COLOUR), (CAMERA_DEPTH, DEPTH))


@pytest.fixture
def path(header: SessionHeader, tmp_path: Path) -> Path:
    path = tmp_path / "images.mcap"
    with SessionWriter(path, replace(header, consent_images=True)) as writer:
        for topic, record in RECORDS:
            writer.write(topic, replace(record, t_ns=header.monotonic_start_ns + record.t_ns))
        writer.seal()
    return path


def test_records_come_back_as_they_were(path: Path) -> None:
    with SessionReader(path) as reader:
        lens, colour, depth = (next(reader.records(topic)) for topic, _ in RECORDS)
    assert np.array_equal(lens.camera_matrix_px, LENS.camera_matrix_px)
    assert (lens.width_px, lens.height_px, lens.frame_id) == (5, 3, "camera")
    assert np.array_equal(colour.encoded, COLOUR.encoded)
    assert colour.format == "jpeg"
    assert depth.depth_mm.dtype == np.uint16
    assert np.array_equal(depth.depth_mm, DEPTH.depth_mm)
    assert colour.t_ns == depth.t_ns == lens.t_ns + 1


def test_any_mcap_reader_decodes_them(path: Path, header: SessionHeader) -> None:
    found: dict[str, Any] = {}
    with path.open("rb") as file:
        for _, channel, message, decoded in make_reader(
            file, decoder_factories=[DecoderFactory()]
        ).iter_decoded_messages():
            found[channel.topic] = decoded
            stamp = decoded.timestamp
            assert stamp.seconds * 10**9 + stamp.nanos == message.log_time
    assert list(found["/camera/calibration"].K) == LENS.camera_matrix_px.ravel().tolist()
    assert found["/camera/color"].data == COLOUR.encoded.tobytes()
    assert found["/camera/depth"].data == DEPTH.depth_mm.astype("<u2").tobytes()
    assert found["/camera/depth"].step == 10


def test_images_are_refused_without_consent(header: SessionHeader, tmp_path: Path) -> None:
    path = tmp_path / "none.mcap"
    with SessionWriter(path, replace(header, consent_images=False)) as writer:
        writer.write(CAMERA_CALIBRATION, replace(LENS, t_ns=header.monotonic_start_ns))
        for topic, record in RECORDS[1:]:
            with pytest.raises(Refused, match="ask for consent"):
                writer.write(topic, record)
        writer.seal()
    with SessionReader(path) as reader:
        assert set(reader.counts) == {"/camera/calibration"}


@pytest.mark.parametrize(
    ("topic", "record"),
    [
        (CAMERA_DEPTH, replace(DEPTH, depth_mm=np.zeros((3, 5), np.float32))),
        (CAMERA_DEPTH, replace(DEPTH, depth_mm=np.zeros(15, np.uint16))),
        (CAMERA_COLOUR, replace(COLOUR, encoded=np.zeros((3, 5), np.uint8))),
        (CAMERA_COLOUR, replace(COLOUR, frame_id="\ud800")),
        (CAMERA_CALIBRATION, replace(LENS, camera_matrix_px=np.zeros(9))),
        (CAMERA_CALIBRATION, replace(LENS, width_px=-1)),
    ],
)
def test_what_is_no_image_is_refused(topic: Any, record: Any) -> None:
    with pytest.raises(Refused):
        codec_for(topic).encode(record, 0)


def test_an_image_that_lies_about_its_size_is_damage() -> None:
    whole = codec_for(CAMERA_DEPTH).encode(DEPTH, 10**18)
    for width in (4, 6, 2**31):
        lying = whole.replace(b"\x15\x05\x00\x00\x00", b"\x15" + width.to_bytes(4, "little"), 1)
        assert lying != whole
        with pytest.raises(Damaged):
            codec_for(CAMERA_DEPTH).decode(memoryview(lying), 0)
    with pytest.raises(Damaged):
        codec_for(CAMERA_DEPTH).decode(memoryview(whole.replace(b"16UC1", b"32FC1")), 0)
