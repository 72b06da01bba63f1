"""Settings: option before environment before file before default; a mistake is one sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

from rehab_app.config import (
    KEYS,
    ClinicFolder,
    Settings,
    StoreSettings,
    load_settings,
    secret_key,
)
from rehab_app.errors import Refused

FILE = """\
catalogue_url = "postgresql://clinic:geheim@db/clinic"
station = "room-2"

[server]
port = 9000
[store]
bucket = "sealed"
secret_key = "never-shown"
"""


@pytest.fixture
def folder(tmp_path: Path) -> ClinicFolder:
    return ClinicFolder(tmp_path / "clinic").create()


def write(folder: ClinicFolder, text: str) -> None:
    (folder.root / "rehab-app.toml").write_text(text, encoding="utf-8")


def test_without_a_file_everything_is_at_its_default(folder):
    loaded = load_settings(folder, environment={})
    assert loaded.settings == Settings()
    assert set(loaded.origins.values()) == {"default"}
    assert loaded.file is None


def test_option_before_environment_before_file_before_default(folder):
    write(folder, FILE)
    by_file = load_settings(folder, environment={})
    assert (by_file.settings.server.port, by_file.origins["server.port"]) == (9000, "rehab-app.toml:5")
    by_variable = load_settings(folder, environment={"REHAB_SERVER_PORT": "9001"})
    assert (by_variable.settings.server.port, by_variable.origins["server.port"]) == (9001, "environment")
    by_option = load_settings(folder, {"server.port": 9002}, {"REHAB_SERVER_PORT": "9001"})
    assert (by_option.settings.server.port, by_option.origins["server.port"]) == (9002, "option")
    not_given = load_settings(folder, {"server.port": None}, {})
    assert not_given.settings.server.port == 9000
    assert by_option.settings.station_name == "room-2"
    assert by_option.settings.server.host == Settings().server.host


def test_every_key_can_be_set_by_its_variable(folder):
    said = {"int": "7", "float": "1.5"}
    for key in KEYS:
        value = key.default if isinstance(key.default, str) else said[type(key.default).__name__]
        value = {"log.level": "error", "log.format": "text"}.get(key.dotted, value or "x")
        loaded = load_settings(folder, environment={key.variable: value})
        assert loaded.origins[key.dotted] == "environment"
        got = getattr(loaded.settings, key.section) if key.section else loaded.settings
        assert str(getattr(got, key.name)) == value


def test_another_file_is_named_by_the_environment(folder, tmp_path):
    write(folder, FILE)
    other = tmp_path / "other.toml"
    other.write_text("[server]\nport = 8181\n", encoding="utf-8")
    loaded = load_settings(folder, environment={"REHAB_CONFIG": str(other)})
    assert (loaded.settings.server.port, loaded.settings.station, loaded.file) == (8181, "", other)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("[server]\nport = 90000", r"server\.port \(rehab-app\.toml:2\) is 90000, but must be .* 1 to 65535"),
        ("[server]\nport = '80'", r"server\.port \(rehab-app\.toml:2\) is '80', but must be a whole number"),
        ("[server]\n\nprot = 1", r"server\.prot \(rehab-app\.toml:3\) is unknown.*write server\.port"),
        ("colour = 1", r"colour \(rehab-app\.toml:1\) is unknown.*take it out"),
        ("server = 1", r"server \(rehab-app\.toml:1\) is 1.*write \[server\]"),
        ("[log]\nlevel = 'loud'", r"log\.level .*is 'loud', but must be debug or info or warning or error"),
        ("station = 'a b'", r"station \(rehab-app\.toml:1\)"),
        ("[server\n", r"must be a TOML file"),
        ("[health]\nheartbeat_s = 0.1", r"a number from 0\.2 to 60"),
        ("server.port = 0", r"server\.port \(rehab-app\.toml:1\)"),
    ],
)
def test_a_mistake_in_the_file_is_one_sentence_with_its_line(folder, text, sentence):
    write(folder, text)
    with pytest.raises(Refused, match=sentence) as refused:
        load_settings(folder, environment={})
    assert "\n" not in str(refused.value)


def test_mistakes_in_the_environment(folder):
    with pytest.raises(Refused, match=r"server\.port \(environment\) is 'x'"):
        load_settings(folder, environment={"REHAB_SERVER_PORT": "x"})
    with pytest.raises(Refused, match="variable REHAB_SERVER_PROT is unknown"):
        load_settings(folder, environment={"REHAB_SERVER_PROT": "1"})
    with pytest.raises(Refused, match="not readable"):
        load_settings(folder, environment={"REHAB_CONFIG": str(folder.root / "none.toml")})
    load_settings(folder, environment={"REHAB_DATA": "x", "REHAB_BACKUP_PASSPHRASE": "y"})


def test_a_file_that_is_no_text_is_refused(folder):
    (folder.root / "rehab-app.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(Refused, match="UTF-8"):
        load_settings(folder, environment={})


def test_no_secret_is_shown_neither_in_a_refusal_nor_in_a_representation(folder):
    write(folder, FILE)
    loaded = load_settings(folder, environment={"REHAB_METRICS_TOKEN": "token-in-clear"})
    shown = repr(loaded) + "".join(str(key.shown(loaded.settings)) for key in KEYS)
    for secret in ("geheim", "never-shown", "token-in-clear"):
        assert secret not in shown
    assert "postgresql://clinic:***@db/clinic" in shown
    write(folder, "[store]\nsecret_key = ['geheim']")
    with pytest.raises(Refused) as refused:
        load_settings(folder, environment={})
    assert "geheim" not in str(refused.value)


def test_the_secret_comes_from_a_file_where_one_is_named(tmp_path):
    file = tmp_path / "secret"
    file.write_text("of the store\nmore\n", encoding="utf-8")
    assert secret_key(StoreSettings(secret_key="direct", secret_key_file=str(file))) == "of the store"
    assert secret_key(StoreSettings(secret_key="direct")) == "direct"
    with pytest.raises(Refused, match="secret_key_file"):
        secret_key(StoreSettings(secret_key_file=str(tmp_path / "none")))


def test_the_table_of_the_documentation_is_that_of_the_dataclasses():
    page = (Path(__file__).parents[3] / "docs" / "operation.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| `") and "| `REHAB_" in line]
    assert rows == [row(key) for key in KEYS]


def row(key):
    default = "" if key.default == "" else f"`{key.default}`"
    return f"| `{key.dotted}` | `{key.variable}` | {key.bound} | {default} | {key.meaning} |"
