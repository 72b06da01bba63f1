"""Which station recorded a file: an addition that older files lack."""

from __future__ import annotations

import hashlib
from dataclasses import replace

import msgspec

from sessions.records import SessionHeader
from sessions.store.header import header_from_texts, header_to_texts


def test_the_station_comes_back(header: SessionHeader) -> None:
    said = replace(header, station='{"name":"room-1","clock_offset_ns":null}')
    assert header_from_texts(header_to_texts(said)) == said


def test_a_file_from_before_has_none(header: SessionHeader) -> None:
    texts = header_to_texts(header)
    del texts["station"], texts["sha256"]
    canonical = msgspec.json.encode(sorted(texts.items()))
    assert header_from_texts(texts | {"sha256": hashlib.sha256(canonical).hexdigest()}) == header
