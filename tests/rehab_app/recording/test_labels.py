"""Labels as people write them, and the pictures that are tracked from them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from rehab_app.cameras import virtual_camera
from rehab_app.cli.app import app
from rehab_app.hand.protocol import load_protocol
from rehab_app.recording.labels import labels_of
from rehab_app.recording.recorder import TakeOrder, record_take
from rehab_app.recording.track import track
from rehab_app.recording.track_order import TrackOrder
from rehab_app.tracking import Labels
from sessions.errors import Refused
from sessions.records import Status

PROTOCOL = load_protocol("thesis25")


def camera() -> Any:
    return virtual_camera("open_close", "right", 4.0, PROTOCOL, seed=8, period_s=3.0)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("session") / "hand.mcap"
    record_take(camera(), PROTOCOL, TakeOrder(path, "right", "open_close", 1.5, "0", consent_images=True))
    return path


def texts(count: int = 25) -> list[str]:
    """Where the markers truly are in the first picture."""
    pixel = camera().truth(0.0).pixel_px.tolist()
    return [f"{name}={u:.2f},{v:.2f}" for name, (u, v) in zip(PROTOCOL.names, pixel, strict=True)][:count]


def errors_px(path: Path) -> np.ndarray:
    with np.load(path) as tracks:
        truth = np.array([camera().truth(float(t)).pixel_px for t in tracks["t_s"]])
        said = np.stack([tracks["u_px"], tracks["v_px"]], axis=2)
        return np.linalg.norm(said - truth, axis=2)[tracks["status"] == Status.MEASURED]


def test_texts_become_labels() -> None:
    assert labels_of(()) is None
    labels = labels_of(["index_pip=312.5, 201", " wrist=1e2,3"])
    assert labels is not None
    assert labels.names == ("index_pip", "wrist")
    assert labels.pixel_px.tolist() == [[312.5, 201.0], [100.0, 3.0]]


@pytest.mark.parametrize(
    "text", ["", "index_pip", "=1,2", "index_pip=", "index_pip=1", "index_pip=1,2,3", "index_pip=inf,2"]
)
def test_what_is_no_label_is_refused(text: str) -> None:
    with pytest.raises(Refused, match="NAME=U,V"):
        labels_of([text])


def test_the_command_follows_the_names(session: Path, tmp_path: Path) -> None:
    said = [part for text in texts() for part in ("--label", text)]
    out = tmp_path / "tracks.npz"
    result = CliRunner().invoke(app, ["track", str(session), "--out", str(out), *said])
    assert result.exit_code == 0, result.output
    assert np.quantile(errors_px(out), 0.95) < 1.0


@pytest.mark.parametrize(
    ("labels", "words"),
    [
        (["sixth=1,2"], "one of thumb_cmc"),
        (["wrist=1"], "NAME=U,V"),
        (["wrist=-1,2"], "inside the picture of 640 x 480 px"),
        (["wrist=1,2", "wrist=3,4"], "each marker once"),
        (["wrist=1,2"], "4 or more"),
    ],
)
def test_wrong_labels_are_one_sentence_and_no_file(
    session: Path, tmp_path: Path, labels: list[str], words: str
) -> None:
    said = [part for text in labels for part in ("--label", text)]
    arguments = ["track", str(session), "--out", str(tmp_path / "take.mcap"), *said]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 1
    assert words in " ".join(result.output.split())
    assert list(tmp_path.iterdir()) == []


def test_names_are_what_was_said_even_where_they_are_wrong(session: Path, tmp_path: Path) -> None:
    """Two fingers' names exchanged: the tracks begin where they were said to be."""
    right = labels_of(texts())
    assert right is not None
    exchanged = [PROTOCOL.names.index(name) for name in ("index_tip", "middle_tip")]
    pixel = right.pixel_px.copy()
    pixel[exchanged] = pixel[exchanged[::-1]]
    order = TrackOrder(
        (session,), tmp_path / "tracks.npz", "right", "0", tracker="rbmcda", labels=Labels(right.names, pixel)
    )
    with np.load(track(order).out) as tracks:
        first = np.stack([tracks["u_px"][0], tracks["v_px"][0]], axis=1)[exchanged]
    assert np.linalg.norm(first - pixel[exchanged], axis=1).max() < 3.0
