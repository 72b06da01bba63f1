"""A report as blocks, before it becomes HTML or PDF: one content, two printers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from sessions.reports.tables import Row, Table

Kind: TypeAlias = Literal["wide", "narrow", "small"]


@dataclass(frozen=True, slots=True)
class Facts:
    """Who, what, when: name and text."""

    rows: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Plain:
    """Sentences that a patient can read."""

    sentences: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Picture:
    """A chart.

    Attributes:
        svg: An <svg> element drawn here, every word in it escaped; empty where there is nothing to draw.
        caption: What it shows, or why there is none.
        says: The same in one line, for who cannot see it.
    """

    svg: str
    caption: str
    says: str = ""


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading; level 2 opens a chapter, 3 a part of it."""

    text: str
    level: int = 2


@dataclass(frozen=True, slots=True)
class Cards:
    """Few numbers, large."""

    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True)
class Numbers:
    """A table of numbers.

    Attributes:
        table: The table.
        kind: "wide" fills the page, "narrow" does not, "small" is set smaller.
    """

    table: Table
    kind: Kind = "wide"


@dataclass(frozen=True, slots=True)
class Words:
    """A table of words."""

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, slots=True)
class Notes:
    """Numbered remarks."""

    texts: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Hint:
    """A quiet paragraph; ``missing`` where it stands in place of what is not there."""

    text: str
    missing: bool = False


@dataclass(frozen=True, slots=True)
class Bullets:
    """Short statements."""

    items: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Pairs:
    """Names and values, two columns of them."""

    rows: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Break:
    """A new page, where there are pages."""


Block: TypeAlias = (
    Facts | Plain | Picture | Heading | Cards | Numbers | Words | Notes | Hint | Bullets | Pairs | Break
)


@dataclass(frozen=True, slots=True)
class Part:
    """One file's or one question's part of a report."""

    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, slots=True)
class Paper:
    """A report, ready to be printed.

    Attributes:
        title: Title of the document; never a patient's name.
        parts: Its parts, one or more.
        software_version: Version of the software that measured.
    """

    title: str
    parts: tuple[Part, ...]
    software_version: str
