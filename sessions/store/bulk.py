"""Several topics as whole columns in one pass through a file: each chunk is unpacked once."""

from __future__ import annotations

import struct
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from itertools import islice

from mcap.opcode import Opcode

from sessions.records import Topic
from sessions.store import refusals
from sessions.store.codec import TableCodec, codec_for
from sessions.store.columns import Columns
from sessions.store.container import PREFIX_BYTES
from sessions.store.damage import Damaged
from sessions.store.gathering import Gathering
from sessions.store.reader import SessionReader, check_channel

_HEAD = struct.Struct("<BQH")
"""Opcode, length and channel: what must be known of a record to pass it over."""
_MESSAGE = int(Opcode.MESSAGE)
_PAYLOAD = PREFIX_BYTES + 22
"""Where the payload of a message begins, from where its record does."""
_WINDOW = 16
"""Chunks in a window: few enough that its memory is used again and again."""
_BATCH, _AHEAD = 8, 3
"""Chunks that are unpacked at once, and how often ahead, on another core."""
Names = Mapping[Topic, Collection[str] | None]


def columns_together(reader: SessionReader, wanted: Names) -> dict[str, Columns]:
    """Columns of several topics, in one pass.

    Args:
        reader: The open file.
        wanted: Topics in layouts of our own, with the fields that are wanted; None for all.

    Returns:
        The same as ``reader.columns`` of each, by topic name.

    Raises:
        Refused: The file is damaged, or a topic is in a newer layout.
    """
    return columns_passing(reader, wanted, {}, lambda window: None)


def columns_passing(
    reader: SessionReader, whole: Names, passing: Names, take: Callable[[Mapping[str, Columns]], None]
) -> dict[str, Columns]:
    """As ``columns_together``; in the same pass long topics go by in windows of seconds and are not kept.

    Args:
        reader: The open file.
        whole: Topics that are wanted whole, with the fields that are wanted; None for all.
        passing: Topics that pass by, likewise; one may also be wanted whole.
        take: Given the columns of each window by topic name, in the order of the file.

    Returns:
        The columns of the whole topics, by topic name.

    Raises:
        Refused: The file is damaged, or a topic is in a newer layout.
    """
    with refusals.refusing(reader.path):
        counts = reader.counts
        kept = {
            topic.name: _gathering(topic, names, counts.get(topic.name, 0)) for topic, names in whole.items()
        }
        windows = {topic.name: _gathering(topic, names, _WINDOW) for topic, names in passing.items()}
        by_channel = _by_channel(reader, {*whole, *passing}, (kept, windows))
        for window in _windows(_ahead(reader.unpacked())):
            for data in window:
                for channel, messages in _messages(data, by_channel).items():
                    for gathering in by_channel[channel]:
                        gathering.add(messages)
            for gathering in (*kept.values(), *windows.values()):
                gathering.flush()
            if windows:
                take({name: gathering.drained(_WINDOW) for name, gathering in windows.items()})
        return {name: gathering.columns() for name, gathering in kept.items()}


def _by_channel(
    reader: SessionReader, topics: Collection[Topic], groups: Iterable[Mapping[str, Gathering]]
) -> dict[int, list[Gathering]]:
    """Who gathers each channel's messages.

    Raises:
        Damaged: A channel is not what its topic says.
        Refused: Its layout is newer.
    """
    by_name = {topic.name: topic for topic in topics}
    found: dict[int, list[Gathering]] = {}
    for channel in reader.summary.channels.values():
        if channel.topic in by_name:
            check_channel(channel, by_name[channel.topic], reader.summary)
            found[channel.id] = [group[channel.topic] for group in groups if channel.topic in group]
    return found


def _ahead(chunks: Iterator[memoryview]) -> Iterator[memoryview]:
    """The same chunks in the same order, unpacked ahead by a thread; unpacking leaves the lock alone."""
    with ThreadPoolExecutor(1, "unpack") as pool:
        waiting = deque(pool.submit(list[memoryview], islice(chunks, _BATCH)) for _ in range(_AHEAD))
        while batch := waiting.popleft().result():
            waiting.append(pool.submit(list[memoryview], islice(chunks, _BATCH)))
            yield from batch


def _windows(chunks: Iterator[memoryview]) -> Iterator[list[memoryview]]:
    """A few chunks at a time."""
    while window := list(islice(chunks, _WINDOW)):
        yield window


def _gathering(topic: Topic, names: Collection[str] | None, messages: int) -> Gathering:
    codec = codec_for(topic)
    if not isinstance(codec, TableCodec):
        raise TypeError(f"{topic.name} is in somebody else's schema")
    return Gathering(topic, codec, names, messages)


def _messages(data: memoryview, channels: Iterable[int]) -> dict[int, list[memoryview]]:
    """The messages of some channels in an unpacked chunk.

    Raises:
        Damaged: A record reaches beyond the chunk.
    """
    found: dict[int, list[memoryview]] = {channel: [] for channel in channels}
    head, take, offset, size = _HEAD.unpack_from, found.get, 0, len(data)
    try:
        while offset < size:
            opcode, length, channel = head(data, offset)
            start = offset + _PAYLOAD
            offset += PREFIX_BYTES + length
            if opcode == _MESSAGE and (messages := take(channel)) is not None:
                if start > offset:
                    raise Damaged("a message is shorter than its head")
                messages.append(data[start:offset])
    except struct.error as error:
        raise Damaged("a chunk ends within a record") from error
    if offset > size:
        raise Damaged("a chunk ends within a record")
    return found
