"""The thesis's chapters 3 to 5 beside what this application makes of them, as one document.

What is compared is computed anew each time; nothing in the right-hand columns is written down anywhere.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

HEAD = """# The thesis reproduced

F. Cordella's thesis of 2011, chapters 3 to 5: every table and figure, ours beside it, the difference,
and what cannot be reproduced and why. Made by `rehab-app grasp --reproduce docs/thesis-reproduction.md`;
a test makes it anew and compares. Values of the thesis are facts that it prints; ours are computed by
the code that the product runs."""


@dataclass(frozen=True, slots=True)
class Line:
    """One value of the thesis and ours.

    Attributes:
        what: Its name.
        thesis: As printed.
        ours: As computed.
        difference: What lies between, or why there is nothing to compare.
    """

    what: str
    thesis: str
    ours: str
    difference: str


@dataclass(frozen=True, slots=True)
class Part:
    """A table or figure of the thesis.

    Attributes:
        title: Such as "Table 3.4: aperture by glove".
        words: What is to be known before the values; one paragraph.
        lines: The values, none for a figure that is only described.
    """

    title: str
    words: str
    lines: tuple[Line, ...] = ()


def compared(what: str, thesis: float, ours: float, unit: str, digits: int) -> Line:
    """A line of two numbers with their difference, absolute and in per cent of the thesis's."""
    off = ours - thesis
    share = f" ({100.0 * off / thesis:+.1f} %)" if thesis else ""
    text = f"{off:+.{digits}f} {unit}{share}"
    return Line(what, f"{thesis:.{digits}f} {unit}", f"{ours:.{digits}f} {unit}", text)


def document(chapters: Iterable[tuple[str, tuple[Part, ...]]]) -> str:
    """The document in Markdown.

    Args:
        chapters: Pairs of heading and parts.
    """
    pieces = [HEAD]
    for heading, parts in chapters:
        pieces.append(f"## {heading}")
        pieces.extend(_section(part) for part in parts)
    return "\n\n".join(pieces) + "\n"


def _section(part: Part) -> str:
    text = f"### {part.title}\n\n{part.words}"
    if not part.lines:
        return text
    rows = [f"| {one.what} | {one.thesis} | {one.ours} | {one.difference} |" for one in part.lines]
    return "\n".join([text, "", "| | thesis | here | difference |", "|---|---|---|---|", *rows])
