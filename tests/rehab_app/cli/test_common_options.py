"""Every command has the options that all commands share."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import typer

from rehab_app.cli.app import app

EXCEPTIONS = {
    "serve": {"--json"},  # runs until it is stopped: there is no result to print
}


def commands(group: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    inner = getattr(group, "commands", None)
    if inner is None:
        yield path, group
        return
    for name, one in inner.items():
        yield from commands(one, f"{path} {name}".strip())


ALL = dict(commands(typer.main.get_command(app)))


@pytest.mark.parametrize("name", sorted(ALL))
def test_every_command_has_json_and_data(name: str) -> None:
    options = {option for parameter in ALL[name].params for option in parameter.opts}
    assert {"--json", "--data"} - options == EXCEPTIONS.get(name, set())


def test_commands_of_commands_are_looked_at() -> None:
    assert {"track", "record", "camera list", "camera preview", "camera models install"} <= set(ALL)
