"""Prints a paper as PDF/A with typst: fonts embedded, no network, the same bytes for the same paper."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from functools import lru_cache
from importlib import resources
from typing import Any

from sessions.reports.language import _, spoken
from sessions.reports.page import TEMPLATES, footer, kind_of
from sessions.reports.paper import Block, Paper
from sessions.reports.report import Report
from sessions.reports.session_paper import session_paper

FONT = "DejaVu Sans"
STANDARD = "a-2b"
_EPOCH = datetime(2020, 1, 1, tzinfo=UTC)
"""Time of making that the file states: the same paper gives the same bytes, and its text says when it was."""


def render_pdf(report: Report) -> bytes:
    """The report as a PDF/A-2b file."""
    return pdf_of(session_paper(report))


def pdf_of(paper: Paper) -> bytes:
    """Any paper as a PDF file.

    PDF/A forbids a letter that no embedded font has; a paper with such a letter becomes a plain PDF.
    """
    import typst

    source = (TEMPLATES / "paper.typ").read_bytes()
    given = {"paper": json.dumps(_content(paper), ensure_ascii=False)}
    arguments: dict[str, Any] = {
        "format": "pdf",
        "font_paths": _fonts(),
        "sys_inputs": given,
        "timestamp": _EPOCH,
    }
    try:
        made = typst.compile(source, pdf_standards=[STANDARD], **arguments)
    except typst.TypstError:
        made = typst.compile(source, **arguments)
    assert isinstance(made, bytes)  # one file is asked for
    return made


@lru_cache(maxsize=1)
def _fonts() -> Any:
    """The fonts that matplotlib ships, so that a PDF looks the same on every machine."""
    import typst

    folder = str(resources.files("matplotlib") / "mpl-data" / "fonts" / "ttf")
    return typst.Fonts(include_system_fonts=False, include_embedded_fonts=False, font_paths=[folder])


def _content(paper: Paper) -> dict[str, Any]:
    return {
        "title": paper.title,
        "software_version": paper.software_version,
        "language": spoken(),
        "footer": footer(paper),
        "floor": _("floor"),
        "parts": [
            {"title": part.title, "blocks": [_block(block) for block in part.blocks]} for part in paper.parts
        ],
    }


def _block(block: Block) -> dict[str, Any]:
    content = asdict(block) | {"kind": kind_of(block)}
    if content["kind"] == "numbers":
        content["size"] = getattr(block, "kind", "wide")
    if content["kind"] == "words":
        content["weights"] = _weights(content["rows"])
    if content["kind"] == "picture":
        content["svg"] = _with_font(content["svg"])
    return content


def _weights(rows: Sequence[Sequence[str]]) -> list[int]:
    """How wide each column but the first is beside the others: by its longest text, within bounds."""
    return [min(40, max(8, *(len(text) for text in column))) for column in list(zip(*rows, strict=True))[1:]]


def _with_font(svg: str) -> str:
    """Pictures name families that a browser knows; here there is one font."""
    return re.sub(r"(font: [^;\"]*?\d+px )[^;\"]+", rf"\1'{FONT}'", svg)
