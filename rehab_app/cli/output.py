"""What a command says: one JSON object on stdout if asked for, words for people on stderr."""

from __future__ import annotations

import sys
from typing import Any

import msgspec


class Output:
    """Output of one command.

    Args:
        as_json: Whether the result goes to stdout as one JSON object.
    """

    def __init__(self, as_json: bool) -> None:
        self._as_json = as_json

    def say(self, text: str) -> None:
        """One line for a person, on stderr."""
        from rich.console import Console

        Console(stderr=True, highlight=False, soft_wrap=True).print(text, markup=False)

    def result(self, content: dict[str, Any]) -> None:
        """The command's one result; its paths become text. Without ``--json`` stdout stays empty."""
        if self._as_json:
            sys.stdout.write(json_line(content))
            sys.stdout.flush()


def json_line(content: dict[str, Any]) -> str:
    """One JSON object on one line; whatever JSON cannot hold is written as text."""
    return msgspec.json.encode(content, enc_hook=str).decode() + "\n"
