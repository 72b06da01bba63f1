"""Texts that every engine can keep: SQLite takes any length and any character, PostgreSQL does not."""

from __future__ import annotations

from typing import Any

from sqlalchemy import String
from sqlalchemy.orm import Mapper

from sessions.errors import Refused


def storable(text: str) -> bool:
    """Whether a text has neither a NUL nor half of a surrogate pair, which no row can hold."""
    return "\0" not in text and not any("\ud800" <= one <= "\udfff" for one in text)


def unkeepable() -> Refused:
    """What is said of a value that a data base turned down."""
    return Refused("text", "with a character that cannot be kept", "plain text", "type it anew")


def check_texts(mapper: Mapper[Any], _connection: object, row: object) -> None:
    """Refuse a row with a text that one of the engines could not keep, the same on all of them.

    Raises:
        Refused: A text is longer than its column or holds such a character.
    """
    for column in mapper.columns:
        kind, value = column.type, getattr(row, mapper.get_property_by_column(column).key)
        if not isinstance(value, str) or not isinstance(kind, String):
            continue
        thing = f"{column.name.replace('_', ' ')} in {column.table.description.replace('_', ' ')}"
        if not storable(value):
            raise Refused(thing, "with a character that cannot be kept", "plain text", "type it anew")
        if kind.length is not None and len(value) > kind.length:
            value = f"{len(value)} characters long"
            raise Refused(thing, value, f"at most {kind.length} characters", "shorten it")
