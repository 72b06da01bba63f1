"""The session header as the metadata record ``session``: text by field, proven by a digest."""

from __future__ import annotations

import hashlib
from dataclasses import fields
from typing import Any

import msgspec

from sessions.errors import Refused
from sessions.records import FORMAT_VERSION, SessionHeader
from sessions.store.damage import Damaged

METADATA_NAME = "session"
_ADDED = {"station": ""}
"""Fields that older files lack, and what they mean there."""
_DIGEST = "sha256"


def header_to_texts(header: SessionHeader) -> dict[str, str]:
    """The header as text by field name: plain text for texts, JSON for all else, and a digest over it."""
    texts: dict[str, str] = {}
    for field in fields(header):
        value: Any = getattr(header, field.name)
        texts[field.name] = value if isinstance(value, str) else msgspec.json.encode(value).decode()
    return texts | {_DIGEST: _digest(texts)}


def header_from_texts(texts: dict[str, str]) -> SessionHeader:
    """The header of a metadata record.

    Raises:
        Damaged: The digest does not fit, or a field is missing or of another kind.
        Refused: The format is newer than this program.
    """
    values = {name: text for name, text in texts.items() if name != _DIGEST}
    if texts.get(_DIGEST) != _digest(values):
        raise Damaged("its header fails its digest")
    _check_version(values)
    values = _ADDED | values
    try:
        return SessionHeader(
            **{
                field.name: msgspec.convert(
                    _plain(values[field.name], str(field.type)), _KINDS[str(field.type)]
                )
                for field in fields(SessionHeader)
            }
        )
    except (KeyError, msgspec.MsgspecError) as error:
        raise Damaged("its header lacks a field") from error


_KINDS: dict[str, Any] = {
    "str": str,
    "Kind": str,
    "Side": str,
    "int": int,
    "bool": bool,
    "tuple[str, ...]": tuple[str, ...],
}


def _plain(text: str, kind: str) -> Any:
    return text if _KINDS[kind] is str else msgspec.json.decode(text)


def _check_version(values: dict[str, str]) -> None:
    version = values.get("format_version", "")
    if version.isascii() and version.isdigit() and len(version) < 9 and int(version) > FORMAT_VERSION:
        raise Refused(
            "format version", version, f"at most {FORMAT_VERSION}", "open the file with a newer rehab-app"
        )


def _digest(texts: dict[str, str]) -> str:
    canonical = msgspec.json.encode(sorted(texts.items()))
    return hashlib.sha256(canonical).hexdigest()
