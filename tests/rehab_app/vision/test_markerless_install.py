from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from rehab_app.vision.markerless import install as installer
from rehab_app.vision.markerless.install import install
from rehab_app.vision.markerless.networks import LANDMARKS, Network, cache_folder, is_installed, load
from sessions.errors import Refused

CONTENT = {"palm.tflite": b"palm" * 1000, "hand.tflite": b"hand" * 1000}
FAKE = tuple(
    Network(name, name, hashlib.sha256(content).hexdigest(), len(content))
    for name, content in CONTENT.items()
)


@pytest.fixture
def wheel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Path]:
    """Writes wheels that hold two small files in place of the networks."""
    monkeypatch.setattr(installer, "NETWORKS", FAKE)

    def write(**changed: bytes | None) -> Path:
        path = tmp_path / "some.whl"
        with zipfile.ZipFile(path, "w") as archive:
            for name, content in CONTENT.items():
                held = changed.get(name.split(".")[0], content)
                if held is not None:
                    archive.writestr(f"deep/inside/{name}", held)
        return path

    return write


def test_a_wheel_gives_both_networks_once(wheel: Callable[..., Path], tmp_path: Path) -> None:
    folder = tmp_path / "cache" / "models"
    assert install(wheel(), folder).fresh == ("palm.tflite", "hand.tflite")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == CONTENT
    assert install(wheel(), folder).fresh == ()
    assert install(None, folder).fresh == ()  # nothing is downloaded where nothing is missing


def test_a_damaged_network_is_mended(wheel: Callable[..., Path], tmp_path: Path) -> None:
    install(wheel(), tmp_path / "models")
    (tmp_path / "models" / "hand.tflite").write_bytes(b"cut")
    assert not is_installed(FAKE[1], tmp_path / "models")
    with pytest.raises(Refused, match=r"SHA-256 .* camera models install"):
        load(FAKE[1], tmp_path / "models")
    assert install(wheel(), tmp_path / "models").fresh == ("hand.tflite",)
    assert load(FAKE[1], tmp_path / "models") == CONTENT["hand.tflite"]


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"hand": b"HAND" * 1000}, "hand.tflite in some.whl is other than the known one"),
        ({"hand": b"short"}, "hand.tflite in some.whl is other than the known one"),
        ({"palm": None}, "wheel some.whl is without palm.tflite"),
    ],
)
def test_another_wheel_leaves_nothing(
    wheel: Callable[..., Path], tmp_path: Path, changed: dict[str, bytes | None], said: str
) -> None:
    with pytest.raises(Refused, match=said):
        install(wheel(**changed), tmp_path / "models")
    assert not (tmp_path / "models").exists()


def test_a_single_network_is_known_by_its_content(wheel: Callable[..., Path], tmp_path: Path) -> None:
    wheel()
    single = tmp_path / "renamed.tflite"
    single.write_bytes(CONTENT["palm.tflite"])
    assert install(single, tmp_path / "models").fresh == ("palm.tflite",)
    single.write_bytes(b"another network")
    with pytest.raises(Refused, match=r"network renamed\.tflite is an unknown one"):
        install(single, tmp_path / "models")


def test_what_is_no_wheel_is_said(tmp_path: Path) -> None:
    text = tmp_path / "notes.txt"
    text.write_text("no wheel")
    for path in (text, tmp_path):
        with pytest.raises(Refused, match="no wheel"):
            install(path, tmp_path / "models")
    with pytest.raises(Refused, match="a file that exists"):
        install(tmp_path / "absent.whl", tmp_path / "models")


def test_without_an_index_one_sentence_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PIP_INDEX_URL", "http://127.0.0.1:9/")
    monkeypatch.setenv("PIP_RETRIES", "0")
    with pytest.raises(Refused, match=r"download of mediapipe.* --from"):
        install(None, tmp_path / "models")
    assert not (tmp_path / "models").exists()


def test_the_cache_is_the_users(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "rehab-app" / "models"
    with pytest.raises(Refused, match=r"not installed.*run rehab-app camera models install"):
        load(LANDMARKS)
