"""The keys of ``Settings`` one by one: type, bounds in words, environment variable, conversion."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass
from typing import Any, Literal, get_args, get_origin, get_type_hints

import msgspec

from rehab_app.config.settings import Settings

_URL = re.compile(r"[\w+.-]+://")
_PASSWORD = re.compile(r"(//[^:/?#@]*):[^/]*@")
_NAMES = {str: "text", int: "a whole number", float: "a number", bool: "true or false"}


@dataclass(frozen=True, slots=True)
class Key:
    """One setting.

    Attributes:
        section: Its section, "" at the top.
        name: Its name there.
        type: Its annotated type.
        default: Its value where nobody says otherwise.
        secret: Whether its value is never shown.
    """

    section: str
    name: str
    type: Any
    default: Any
    secret: bool

    @property
    def dotted(self) -> str:
        """Such as ``server.port``."""
        return f"{self.section}.{self.name}" if self.section else self.name

    @property
    def variable(self) -> str:
        """Such as ``REHAB_SERVER_PORT``."""
        return "REHAB_" + self.dotted.replace(".", "_").upper()

    @property
    def meaning(self) -> str:
        """What it means, in words."""
        return str(_meta(self.type).description or "")

    @property
    def bound(self) -> str:
        """What it may be, in words."""
        inner, meta = get_args(self.type)[0], _meta(self.type)
        if get_origin(inner) is Literal:
            return " or ".join(str(word) for word in get_args(inner))
        words = _NAMES[inner]
        low = meta.ge if meta.ge is not None else meta.gt
        if low is not None:
            above = "from" if meta.ge is not None else "above"
            words += f" {above} {low:g}" + (f" to {meta.le:g}" if meta.le is not None else "")
        if meta.max_length is not None:
            words += f" of at most {meta.max_length} characters"
        if meta.min_length is not None:
            words += " that is not empty"
        return words + (" of letters, digits, dots and dashes, at most 63" if meta.pattern else "")

    def shown(self, settings: Settings) -> Any:
        """The value as a person may see it: of a secret only whether there is one, of a URL no password."""
        value = getattr(getattr(settings, self.section) if self.section else settings, self.name)
        if not self.secret or not value:
            return value
        return _PASSWORD.sub(r"\1:***@", value) if _URL.match(value) else "(set)"

    def convert(self, value: object, *, written: bool) -> Any:
        """The value, checked.

        Args:
            value: What was said.
            written: Whether it was written as text whatever it is (the environment).

        Raises:
            ValueError: It is of another type or out of bounds.
        """
        return msgspec.convert(value, self.type, strict=not written)


def _meta(kind: Any) -> msgspec.Meta:
    return next(one for one in get_args(kind) if isinstance(one, msgspec.Meta))


def _default(one: Field[Any]) -> Any:
    return one.default if one.default is not MISSING else None


def _keys_of(section: str, kind: type[Any]) -> tuple[Key, ...]:
    hints: Mapping[str, Any] = get_type_hints(kind, include_extras=True)
    found: list[Key] = []
    for one in fields(kind):
        hint = hints[one.name]
        if is_dataclass(hint):
            assert isinstance(hint, type)
            found += _keys_of(one.name, hint)
        else:
            found.append(Key(section, one.name, hint, _default(one), bool(one.metadata.get("secret"))))
    return tuple(found)


KEYS: tuple[Key, ...] = _keys_of("", Settings)
"""Every key, in the order of the dataclasses."""

SECTIONS: Mapping[str, type[Any]] = {
    name: hint
    for name, hint in get_type_hints(Settings).items()
    if isinstance(hint, type) and is_dataclass(hint)
}
"""Dataclass of each section."""
