"""Reads the settings: option before environment before file before default, each checked where it stands."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rehab_app.config.folder import ClinicFolder
from rehab_app.config.keys import KEYS, SECTIONS, Key
from rehab_app.config.settings import Settings, StoreSettings
from rehab_app.errors import Refused

FILE = "rehab-app.toml"
FILE_VARIABLE = "REHAB_CONFIG"
DEFAULT, ENVIRONMENT, OPTION = "default", "environment", "option"
_BY_NAME = {key.dotted: key for key in KEYS}
_LARGEST = 1_000_000


@dataclass(frozen=True, slots=True)
class Loaded:
    """Settings and where each came from.

    Attributes:
        settings: The settings.
        origins: By dotted key: "default", "environment", "option", or "FILE:LINE".
        file: The file that was read, None where there is none.
    """

    settings: Settings
    origins: Mapping[str, str]
    file: Path | None


@dataclass(slots=True)
class _Said:
    """What was said of each key, the strongest last."""

    values: dict[str, Any] = field(default_factory=dict[str, Any])
    origins: dict[str, str] = field(default_factory=dict[str, str])

    def take(self, key: Key, value: object, place: str, *, written: bool = False) -> None:
        try:
            self.values[key.dotted] = key.convert(value, written=written)
        except ValueError as error:
            shown = "(not shown)" if key.secret else repr(value)[:80]
            raise Refused(
                f"setting {key.dotted} ({place})", shown, key.bound, "correct it, or leave it out"
            ) from error
        self.origins[key.dotted] = place


def load_settings(
    folder: ClinicFolder,
    options: Mapping[str, object] | None = None,
    environment: Mapping[str, str] | None = None,
) -> Loaded:
    """The settings that hold for a clinic folder.

    Args:
        folder: The clinic folder, whose ``rehab-app.toml`` counts where no other file is named.
        options: Values given on the command line by dotted key; None stands for "not given".
        environment: Variables; by default those of the process. ``REHAB_CONFIG`` names another file.

    Raises:
        Refused: The file cannot be read or is no TOML, or a key is unknown, of another type or out of bounds.
    """
    variables = os.environ if environment is None else environment
    said = _Said()
    file = _file(folder, variables)
    if file is not None:
        _read_file(file, said)
    _read_environment(variables, said)
    for name, value in (options or {}).items():
        if value is not None:
            said.take(_BY_NAME[name], str(value) if isinstance(value, Path) else value, OPTION)
    origins = {key.dotted: said.origins.get(key.dotted, DEFAULT) for key in KEYS}
    return Loaded(_built(said.values), origins, file)


def secret_key(store: StoreSettings) -> str:
    """The secret of the object store, from the file where one is named.

    Raises:
        Refused: The file cannot be read.
    """
    if not store.secret_key_file:
        return store.secret_key
    path = Path(store.secret_key_file).expanduser()
    try:
        return (path.read_text(encoding="utf-8").splitlines() or [""])[0].strip()
    except (OSError, UnicodeDecodeError) as error:
        raise Refused(
            "setting store.secret_key_file",
            str(path),
            "a text file that can be read",
            "check path and rights",
        ) from error


def _file(folder: ClinicFolder, variables: Mapping[str, str]) -> Path | None:
    """The file that is named, else the clinic's own where there is one."""
    named = variables.get(FILE_VARIABLE, "")
    if named:
        return Path(named).expanduser().absolute()
    own = folder.root / FILE
    return own if own.is_file() else None


def _read_file(file: Path, said: _Said) -> None:
    text = _text(file)
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise Refused(f"settings file {file}", str(error), "a TOML file", "correct that line") from error
    lines = _Lines(file, text)
    for name, value in content.items():
        if name in SECTIONS:
            if not isinstance(value, dict):
                place = lines.place("", name)
                raise Refused(f"setting {name} ({place})", repr(value)[:80], "a section", f"write [{name}]")
            for inner, one in value.items():
                _take_named(f"{name}.{inner}", one, lines.place(name, inner), said)
        else:
            _take_named(name, value, lines.place("", name), said)


def _text(file: Path) -> str:
    try:
        with file.open("rb") as opened:
            return opened.read(_LARGEST).decode("utf-8")
    except OSError as error:
        why = f"not readable ({error.strerror or error})"
        bound, remedy = "a file that can be read", "check --config, REHAB_CONFIG and its rights"
        raise Refused(f"settings file {file}", why, bound, remedy) from error
    except UnicodeDecodeError as error:
        raise Refused(f"settings file {file}", "not UTF-8", "a TOML file in UTF-8", "save it anew") from error


def _take_named(name: str, value: object, place: str, said: _Said) -> None:
    key = _BY_NAME.get(name)
    if key is None:
        known = "one of the keys in docs/operation.md"
        raise Refused(f"setting {name} ({place})", "unknown", known, _nearest(name))
    said.take(key, value, place)


def _nearest(name: str) -> str:
    import difflib

    close = difflib.get_close_matches(name, _BY_NAME, 1)
    return f"write {close[0]}" if close else "take it out"


def _read_environment(variables: Mapping[str, str], said: _Said) -> None:
    by_variable = {key.variable: key for key in KEYS}
    starts = tuple(f"REHAB_{section.upper()}_" for section in SECTIONS)
    for variable, value in variables.items():
        key = by_variable.get(variable)
        if key is not None:
            said.take(key, value, ENVIRONMENT, written=True)
        elif variable.startswith(starts):
            known = "a variable of docs/operation.md"
            raise Refused(f"variable {variable}", "unknown", known, "correct its name, or unset it")


class _Lines:
    """Finds the line of a key, so that a complaint can name it."""

    _SECTION = re.compile(r"\s*\[\s*([\w.-]+)\s*\]")
    _KEY = re.compile(r"\s*([\w.-]+)\s*=")

    def __init__(self, file: Path, text: str) -> None:
        self._file = file
        self._found = dict(self._walk(text))

    def place(self, section: str, name: str) -> str:
        """Such as ``rehab-app.toml:3``."""
        line = self._found.get((section, name)) or self._found.get(("", f"{section}.{name}"))
        return f"{self._file.name}:{line}" if line else self._file.name

    def _walk(self, text: str) -> Iterator[tuple[tuple[str, str], int]]:
        section = ""
        for number, line in enumerate(text.splitlines(), 1):
            if begins := self._SECTION.match(line):
                section = begins[1]
                yield ("", section), number
            elif named := self._KEY.match(line):
                yield (section, named[1]), number


def _built(values: Mapping[str, Any]) -> Settings:
    top = {name: value for name, value in values.items() if "." not in name}
    inner: dict[str, dict[str, Any]] = {name: {} for name in SECTIONS}
    for name, value in values.items():
        section, _, key = name.partition(".")
        if key:
            inner[section][key] = value
    return Settings(**top, **{name: kind(**inner[name]) for name, kind in SECTIONS.items()})
