"""Finding people by what is typed: accents, case and the way of writing a date do not matter."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

ORDERS = ("name", "birth", "side", "added")
"""What a list of patients can be sorted by."""
CODE_POINTS = "C"
"""PostgreSQL's collation that sorts by code point, as SQLite does: one order of names on every engine."""
_PLAIN = str.maketrans(
    {"ø": "o", "ł": "l", "đ": "d", "ħ": "h", "ı": "i", "æ": "ae", "œ": "oe", "ð": "d", "þ": "th"}
)
_DAY_FIRST = re.compile(r"(\d{1,2})[./-](\d{1,2})[./-](\d{4})")


@lru_cache(maxsize=65_536)
def folded(text: str) -> str:
    """A text as it is compared: lower case, without accents and other marks, one space between words.

    Writing that has neither case nor accents (Chinese, Arabic without vowels) stays as it is.
    """
    plain = unicodedata.normalize("NFKD", text).casefold().translate(_PLAIN)
    return " ".join("".join(one for one in plain if not unicodedata.combining(one)).split())


def words_of(typed: str) -> tuple[str, ...]:
    """The words that somebody typed, each to be found; 14.3.1957 is sought as 1957-03-14.

    A comma or semicolon parts words, so that "Rossi, Anna" is found as it is shown.
    """
    words = folded(typed.replace(",", " ").replace(";", " ")).split()
    return tuple(_as_date(word) for word in words)


def sought_text(given_name: str, family_name: str, birth_date: str, pseudonym: str) -> str:
    """The text of a patient in which every typed word must be found."""
    return f"{folded(f'{given_name} {family_name}')} {birth_date} {pseudonym.casefold()}"


def sorted_name(given_name: str, family_name: str) -> str:
    """The name by which a patient stands in a list."""
    return folded(f"{family_name} {given_name}")


def _as_date(word: str) -> str:
    found = _DAY_FIRST.fullmatch(word)
    if found is None:
        return word
    day, month, year = (int(part) for part in found.groups())
    return f"{year:04d}-{month:02d}-{day:02d}"
