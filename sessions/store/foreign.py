"""What an MCAP file of another program is, in one phrase, and what it lacks to be a session."""

from __future__ import annotations

from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Header, Metadata

from sessions.store.container import Source, declarations, unpack
from sessions.store.damage import Damaged
from sessions.store.header import METADATA_NAME
from sessions.store.summary import Summary, read_summary

_RECORDS_MAX = 2000
_TOPICS_SHOWN = 4
_TEXT_MAX = 60


def session_texts_at_start(source: Source) -> dict[str, str] | None:
    """The metadata record ``session`` where every session has it, as the second record; else None."""
    try:
        for index, span in enumerate(source.spans()):
            if span.opcode == Opcode.METADATA and index == 1:
                metadata = source.parsed(span, Metadata.read)
                return metadata.metadata if metadata.name == METADATA_NAME else None
            if index > 1:
                return None
    except Damaged:
        return None
    return None


def describe(source: Source) -> str:
    """Say what the file is: profile, library, topics, encodings, and that the session header is missing."""
    profile, library = _origin(source)
    channels = _channels(source)
    topics = sorted({f"{_short(item.topic)} [{_short(item.message_encoding)}]" for item in channels})
    shown = ", ".join(topics[:_TOPICS_SHOWN]) + (", ..." if len(topics) > _TOPICS_SHOWN else "")
    many = f"{len(topics)} topic{'' if len(topics) == 1 else 's'}"
    origin = f"profile {_short(profile) or 'none'}, library {_short(library) or 'unnamed'}"
    return (
        f"an MCAP file of another program ({origin}, {many}{': ' + shown if shown else ''})"
        f" without a metadata record '{METADATA_NAME}'"
    )


def _origin(source: Source) -> tuple[str, str]:
    try:
        span = next(source.spans())
        header = source.parsed(span, Header.read) if span.opcode == Opcode.HEADER else Header("", "")
    except Damaged:
        return "", ""
    return header.profile, header.library


def _channels(source: Source) -> list[Channel]:
    try:
        return list(read_summary(source).channels.values())
    except Damaged:
        return _scanned_channels(source)


def _scanned_channels(source: Source) -> list[Channel]:
    """The channels among the first records of a file without an index."""
    found = Summary()
    try:
        for count, span in enumerate(source.spans()):
            if span.opcode == Opcode.CHANNEL:
                found.take(span.opcode, source.read(span.start, span.length))
            elif span.opcode == Opcode.CHUNK:
                for item in declarations(unpack(source.parsed(span, Chunk.read))):
                    if isinstance(item, Channel):
                        found.channels[item.id] = item
            if count > _RECORDS_MAX:
                break
    except Damaged:
        pass  # what was found until there is what can be said
    return list(found.channels.values())


def _short(text: str) -> str:
    printable = "".join(letter if letter.isprintable() else "?" for letter in text)
    return printable if len(printable) <= _TEXT_MAX else printable[:_TEXT_MAX] + "..."
