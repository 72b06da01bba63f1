"""The language of a report: English is in the sources, the others are gettext catalogues in web_assets.

A report has a catalogue of its own and falls back on that of the pages, so that exercises, modes and scores
have the same words in both. Formats for programs (JSON, CSV, Parquet, FHIR) are always English.
"""

from __future__ import annotations

import gettext
import io
import re
from collections.abc import Generator
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import UTC, date, datetime
from functools import lru_cache
from importlib import resources
from typing import Any

from sessions.errors import Refused

SOURCE = "en"
LANGUAGES = (SOURCE, "it")
_ASSETS = resources.files("web_assets")
_DECIMAL = re.compile(r"(?<=\d)\.(?=\d)")
_spoken: ContextVar[str] = ContextVar("language of a report", default=SOURCE)


@contextmanager
def speaking(language: str) -> Generator[None]:
    """Everything that is worded inside is in this language.

    Raises:
        Refused: There is no such language.
    """
    if language not in LANGUAGES:
        raise Refused("language", repr(language), "one of " + ", ".join(LANGUAGES), "choose one of them")
    before = _spoken.set(language)
    try:
        yield
    finally:
        _spoken.reset(before)


def spoken() -> str:
    """Code of the language."""
    return _spoken.get()


def _(text: str, **values: object) -> str:
    """A text in the language, with its placeholders filled; what no catalogue holds stays English.

    Args:
        text: In English, with ``%(name)s``; a literal percent sign is %% where there are placeholders.
        values: By name of the placeholder.
    """
    found = _catalogue(_spoken.get()).gettext(text) if text else ""
    return found % values if values else found


def counted(one: str, many: str, count: int, **values: object) -> str:
    """A text that depends on a number, which its placeholder ``%(n)s`` stands for."""
    return _catalogue(_spoken.get()).ngettext(one, many, count) % {"n": count, **values}


def marked(text: str) -> str:
    """Marks a text of a table for the catalogues; it is translated where it is shown, with ``_``."""
    return text


def decimal(text: str) -> str:
    """Numbers in a text as the language writes them: a decimal comma in Italian."""
    return text if _spoken.get() == SOURCE else _DECIMAL.sub(",", text)


def day(utc_ns: int) -> str:
    """A day in UTC, such as "23 November 2026"."""
    return _dated(_at(utc_ns).date(), "d MMMM y")


def short_day(utc_ns: int) -> str:
    """A day in UTC, such as "23 Nov 2026"."""
    return _dated(_at(utc_ns).date(), "d MMM y")


def moment(utc_ns: int) -> str:
    """An instant, such as "23 November 2026, 03:15 UTC"."""
    return f"{day(utc_ns)}, {_at(utc_ns):%H:%M} UTC"


def _at(utc_ns: int) -> datetime:
    return datetime.fromtimestamp(utc_ns // 1_000_000_000, tz=UTC)


def _dated(one: date, form: str) -> str:
    from babel.dates import format_date

    return format_date(one, form, locale=_spoken.get())


@lru_cache(maxsize=len(LANGUAGES))
def _catalogue(language: str) -> gettext.NullTranslations:
    """The compiled catalogues of a language, made in memory: the sources need no build step."""
    if language == SOURCE:
        return gettext.NullTranslations()
    own = _compiled(_ASSETS / "reports" / f"{language}.po", language)
    own.add_fallback(_compiled(_ASSETS / "locale" / f"{language}.po", language))
    return own


def _compiled(path: Any, language: str) -> gettext.GNUTranslations:
    from babel.messages.mofile import write_mo
    from babel.messages.pofile import read_po

    source: Any = io.BytesIO(path.read_bytes())
    made = io.BytesIO()
    write_mo(made, read_po(source, locale=language, abort_invalid=True))
    made.seek(0)
    return gettext.GNUTranslations(made)
