from __future__ import annotations

import hashlib
import shutil
import struct
import tracemalloc
import zlib
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from sessions.errors import Refused
from sessions.records import TOPICS, SessionHeader, Topic
from sessions.records.topics import HAND_POSE
from sessions.store import SessionReader, SessionWriter, info, recover, verify
from sessions.store.codec import codec_for
from sessions.store.container import MAGIC
from sessions.store.header import header_to_texts

START_NS = 5_000_000_000
Maker = Callable[[Topic, int, np.random.Generator], Any]


def copy_of(path: Path, folder: Path) -> Path:
    shutil.copy(path, folder / path.name)
    shutil.copy(f"{path}.sha256", folder / f"{path.name}.sha256")
    return folder / path.name


def rewritten(path: Path, texts: dict[str, str], version: str = "1", schema: str = "rehab.HandPose") -> Path:
    """A file with the session's metadata, written by the plain library."""
    stream = BytesIO()
    writer = Writer(stream, compression=CompressionType.ZSTD)
    writer.start("rehab-app", "another hand")
    writer.add_metadata("session", texts)
    schema_id = writer.register_schema(schema, "protobuf", codec_for(HAND_POSE).schema)
    channel = writer.register_channel("/hand/pose", "protobuf", schema_id, {"version": version})
    writer.add_message(channel, START_NS, b"", START_NS)
    writer.finish()
    path.write_bytes(stream.getvalue())
    return path


def refusal(action: Callable[[Path], Any], path: Path) -> str:
    with pytest.raises(Refused) as caught:
        action(path)
    return str(caught.value)


@pytest.mark.parametrize("action", [SessionReader, info, verify, recover])
def test_what_is_no_session_is_said(action: Callable[[Path], Any], tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    assert "no such file" in refusal(action, path)
    assert "not readable" in refusal(action, tmp_path)
    path.write_bytes(b"")
    assert "empty" in refusal(action, path)
    path.write_bytes(b"PK\x03\x04 a zip file, for example")
    assert "no MCAP file" in refusal(action, path)
    assert "rehab-app import" in refusal(action, path)
    assert sorted(item.name for item in tmp_path.iterdir()) == ["x.mcap"]


@pytest.mark.parametrize("kept", [0.3, 0.6, 0.9, 0.999])
def test_a_cut_file_offers_recover(kept: float, sealed: Path, tmp_path: Path) -> None:
    path = copy_of(sealed, tmp_path)
    path.write_bytes(sealed.read_bytes()[: int(kept * sealed.stat().st_size)])
    for action in (SessionReader, info, verify):
        assert "run rehab-app recover walk.mcap" in refusal(action, path)
    found = recover(path)
    assert found.sealed.path == tmp_path / "walk.recovered.mcap"
    assert found.records == sum(verify(found.sealed.path).records.values())
    assert found.records >= int(400 * kept) - 60
    assert found.lost_chunks == 0


def test_foreign_files_are_described(shared_data: Path) -> None:
    files = sorted((shared_data / "foreign_mcap").glob("*.mcap"))
    assert len(files) == 21
    for path in files:
        with path.open("rb") as stream:
            mcap = make_reader(stream)
            mcap_header, summary = mcap.get_header(), mcap.get_summary()
        assert summary is not None
        topics = {channel.topic for channel in summary.channels.values()}
        encodings = {channel.message_encoding for channel in summary.channels.values()}
        for action in (SessionReader, info, verify, recover):
            sentence = refusal(action, path)
            assert "another program" in sentence
            assert "without a metadata record 'session'" in sentence
            assert mcap_header.library in sentence
            assert (mcap_header.profile or "none") in sentence
            assert f"{len(topics)} topic" in sentence
            assert min(topics) in sentence
            assert any(f"[{encoding}]" in sentence for encoding in encodings)


@pytest.mark.parametrize("kept", [0.4, 0.8])
def test_foreign_files_that_are_cut_are_described(kept: float, shared_data: Path, tmp_path: Path) -> None:
    for source in sorted((shared_data / "foreign_mcap").glob("*.mcap")):
        path = tmp_path / source.name
        path.write_bytes(source.read_bytes()[: int(kept * source.stat().st_size)])
        for action in (SessionReader, recover):
            assert "another program" in refusal(action, path)


def test_a_newer_format_is_refused(header: SessionHeader, tmp_path: Path) -> None:
    texts = header_to_texts(header)
    texts.pop("sha256")
    texts["format_version"] = "2"
    pairs = sorted(texts.items())
    body = "[" + ",".join(f'["{key}",{_quoted(value)}]' for key, value in pairs) + "]"
    texts["sha256"] = hashlib.sha256(body.encode()).hexdigest()
    path = rewritten(tmp_path / "new.mcap", texts)
    assert "newer rehab-app" in refusal(SessionReader, path)


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def test_a_newer_layout_is_refused(header: SessionHeader, tmp_path: Path) -> None:
    path = rewritten(tmp_path / "new.mcap", header_to_texts(header), version="2")
    with SessionReader(path) as reader, pytest.raises(Refused, match="layout version"):
        reader.columns(HAND_POSE)


def test_another_schema_on_our_topic_is_refused(header: SessionHeader, tmp_path: Path) -> None:
    path = rewritten(tmp_path / "odd.mcap", header_to_texts(header), schema="other.HandPose")
    with SessionReader(path) as reader, pytest.raises(Refused, match="schema"):
        next(reader.records(HAND_POSE))


def test_a_message_that_lacks_its_fields_is_refused(header: SessionHeader, tmp_path: Path) -> None:
    path = rewritten(tmp_path / "odd.mcap", header_to_texts(header))
    with SessionReader(path) as reader, pytest.raises(Refused, match="do not fill its shape"):
        next(reader.records(HAND_POSE))
    assert "damaged" in refusal(verify, path)


def test_a_header_that_was_changed_is_refused(header: SessionHeader, tmp_path: Path) -> None:
    texts = header_to_texts(header) | {"side": "right"}
    assert "digest" in refusal(SessionReader, rewritten(tmp_path / "x.mcap", texts))


def test_an_altered_file_fails_its_digest(sealed: Path, tmp_path: Path) -> None:
    path = copy_of(sealed, tmp_path)
    noted = path.with_name("walk.mcap.sha256")
    noted.write_text("0" * 64 + "  walk.mcap\n")
    assert "SHA-256" in refusal(verify, path)
    noted.write_text("nonsense")
    assert "no SHA-256" in refusal(verify, path)
    noted.unlink()
    assert not verify(path).digest_noted


def test_a_flipped_bit_in_a_chunk_is_found_and_the_rest_recovered(sealed: Path, tmp_path: Path) -> None:
    path = copy_of(sealed, tmp_path)
    content = bytearray(sealed.read_bytes())
    content[len(content) // 3] ^= 0x10
    path.write_bytes(content)
    assert "damaged" in refusal(verify, path)
    found = recover(path)
    assert found.lost_chunks == 1
    assert 200 < found.records < 40 * len(TOPICS)


def test_a_whole_file_needs_no_recovery(sealed: Path, tmp_path: Path) -> None:
    assert "whole" in refusal(recover, copy_of(sealed, tmp_path))
    assert not (tmp_path / "walk.recovered.mcap").exists()


def _record(opcode: int, content: bytes, length: int | None = None) -> bytes:
    return struct.pack("<BQ", opcode, len(content) if length is None else length) + content


def _text(value: str) -> bytes:
    return struct.pack("<I", len(value.encode())) + value.encode()


def _start(header: SessionHeader) -> bytes:
    body = b"".join(_text(key) + _text(value) for key, value in header_to_texts(header).items())
    metadata = _text("session") + struct.pack("<I", len(body)) + body
    return MAGIC + _record(1, _text("rehab-app") + _text("x")) + _record(12, metadata)


def _chunk(data: bytes, claimed: int, compression: str) -> bytes:
    head = struct.pack("<QQQI", 0, 0, claimed, 0) + _text(compression)
    return _record(6, head + struct.pack("<Q", len(data)) + data)


@pytest.mark.parametrize("length", [2**60, 2**63 - 1, 2**64 - 1, 2**31])
@pytest.mark.parametrize("opcode", [1, 5, 6, 9, 12, 200])
def test_a_claimed_length_allocates_nothing(
    opcode: int, length: int, header: SessionHeader, tmp_path: Path
) -> None:
    path = tmp_path / "huge.mcap"
    path.write_bytes(_start(header) + _record(opcode, b"abc", length))
    assert "recover" in refusal(SessionReader, path)
    assert recover(path).records == 0


@pytest.mark.parametrize("claimed", [10, 2**20, 2**60])
def test_a_bomb_is_not_unpacked(claimed: int, header: SessionHeader, tmp_path: Path) -> None:
    bomb = zstandard.compress(bytes(256 * 2**20))
    path = tmp_path / "bomb.mcap"
    path.write_bytes(_start(header) + _chunk(bomb, claimed, "zstd"))
    tracemalloc.start()
    try:
        assert recover(path).lost_chunks == 1
        assert tracemalloc.get_traced_memory()[1] < 64 * 2**20
    finally:
        tracemalloc.stop()


def test_an_index_outside_the_file_is_refused(sealed: Path, tmp_path: Path) -> None:
    path = copy_of(sealed, tmp_path)
    content = bytearray(sealed.read_bytes())
    for start in (2**60, 0, len(content)):
        content[-28:-20] = struct.pack("<Q", start)
        path.write_bytes(content)
        assert refusal(SessionReader, path)


def test_a_chunk_elsewhere_than_indexed_is_refused(sealed: Path, tmp_path: Path) -> None:
    """A consistent lie: the index is altered and its checksum made to fit."""
    content = bytearray(sealed.read_bytes())
    start = struct.unpack_from("<Q", content, len(content) - 28)[0]
    offset = start
    while content[offset] != 8:
        offset += 9 + struct.unpack_from("<Q", content, offset + 1)[0]
    struct.pack_into("<Q", content, offset + 9 + 16, 2**60)
    crc = zlib.crc32(content[start:-12])
    struct.pack_into("<I", content, len(content) - 12, crc)
    path = tmp_path / "x.mcap"
    path.write_bytes(content)
    with SessionReader(path) as reader, pytest.raises(Refused, match="damaged"):
        list(reader.records(HAND_POSE))


def test_text_that_no_file_can_hold_is_refused(header: SessionHeader, maker: Maker, tmp_path: Path) -> None:
    crooked = replace(header, exercise="\ud800")
    with pytest.raises(Refused):
        SessionWriter(tmp_path / "a.mcap", crooked)
    assert list(tmp_path.iterdir()) == []
