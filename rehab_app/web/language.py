"""The language of a request: English is in the sources, the others are gettext catalogues in web_assets."""

from __future__ import annotations

import gettext as standard
import io
from contextvars import ContextVar
from functools import lru_cache
from importlib import resources
from typing import Any

from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po
from starlette.datastructures import Headers

SOURCE = "en"
LANGUAGES = {"en": "English", "it": "Italiano"}
COOKIE = "rehab_language"
_FOLDER = resources.files("web_assets") / "locale"
_spoken: ContextVar[str] = ContextVar("language", default=SOURCE)


def speak(language: str) -> None:
    """Answer in this language from here on; it holds for the request that is being answered."""
    _spoken.set(language if language in LANGUAGES else SOURCE)


def spoken() -> str:
    """Code of the language of the request that is being answered."""
    return _spoken.get()


def asked_for(headers: Headers, cookies: dict[str, str], usual: str = "") -> str:
    """The language of a browser: chosen on a page, else the clinic's, else the first that its settings name.

    Args:
        headers: Of the request.
        cookies: Of the request.
        usual: Code of the language that the clinic set for whoever has not chosen one, "" for none.
    """
    for chosen in (cookies.get(COOKIE, ""), usual):
        if chosen in LANGUAGES:
            return chosen
    for part in headers.get("accept-language", "")[:200].split(","):
        code = part.partition(";")[0].strip()[:2].lower()
        if code in LANGUAGES:
            return code
    return SOURCE


def _(text: str) -> str:
    """A text of the pages in the language of the request; what no catalogue holds stays English."""
    return _catalogue(_spoken.get()).gettext(text) if text else ""


def ngettext(one: str, many: str, count: int) -> str:
    """A text that depends on a number."""
    return _catalogue(_spoken.get()).ngettext(one, many, count)


def written(value: float, digits: int | None = None) -> str:
    """A number as people of the language write it: with a decimal comma in Italian.

    Args:
        value: The number.
        digits: Digits after it, None for as many as it has.
    """
    text = f"{value:g}" if digits is None else f"{value:.{digits}f}"
    return text if _spoken.get() == SOURCE else text.replace(".", ",")


def marked(text: str) -> str:
    """Marks a text of a table for the catalogues; it is translated where it is shown, with ``_``."""
    return text


@lru_cache(maxsize=len(LANGUAGES))
def _catalogue(language: str) -> standard.NullTranslations:
    """The compiled catalogue of a language, made in memory: the sources need no build step."""
    if language == SOURCE:
        return standard.NullTranslations()
    compiled = io.BytesIO()
    source: Any = io.BytesIO((_FOLDER / f"{language}.po").read_bytes())
    write_mo(compiled, read_po(source, locale=language, abort_invalid=True))
    compiled.seek(0)
    return standard.GNUTranslations(compiled)
