"""Every command has the options that all commands share."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import typer

from rehab_app.cli import options
from rehab_app.cli.app import app
from robot_iface.types import MODES, SPACES, VIRTUAL_KINDS

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
    given = {option for parameter in ALL[name].params for option in parameter.opts}
    assert {"--json", "--data"} - given == EXCEPTIONS.get(name, set())


def test_commands_of_commands_are_looked_at() -> None:
    assert {"track", "record", "camera list", "camera preview", "camera models install"} <= set(ALL)


def test_the_words_that_options_offer_are_those_of_the_motion_core() -> None:
    assert options.TWINS == ", ".join(VIRTUAL_KINDS)
    assert options.MODES == ", ".join(MODES)
    assert options.SPACES == ", ".join(SPACES)
