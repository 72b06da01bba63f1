"""Example reports of the two real recordings: import, approve, rehearse, play, report."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rehab_app.access import CONSOLE
from rehab_app.bootstrap import open_clinic
from rehab_app.config import Settings
from rehab_app.errors import Refused
from rehab_app.services.clinic import Clinic
from rehab_app.services.order import Order
from rehab_app.services.retouching import Wish
from rehab_app.services.rows import ImportedSummary

ENVIRONMENT = "REHAB_SHARED_DATA"
SPEED = 0.5
FORMATS = {"take": ("html", "json"), "session": ("html", "pdf", "json", "note")}


@dataclass(frozen=True, slots=True)
class Example:
    """A real recording.

    Attributes:
        name: Stem of its reports.
        file: Where it lies in the folder of recordings.
        scale: Digits whose movement is made smaller by this factor before it is played.
        reason: Why.
    """

    name: str
    file: str
    scale: tuple[tuple[str, float], ...] = ()
    reason: str = ""


EXAMPLES = (
    Example("mocap-hand", "mocap_hand_dfki/recording.tsv"),
    Example(
        "video-hand",
        "human_hand_video/landmarks_m.npz",
        (("ring", 0.95),),
        "The ring fingertip came nearer to the palm than the 5 mm that a rehearsal asks for.",
    ),
)


def make_examples(out: Path, seed: int, say: Callable[[str], None]) -> list[Path]:
    """Bring each real recording through the whole of the app and keep its reports.

    Args:
        out: Folder of the reports; older ones of the same names are replaced.
        seed: Seed of everything random.
        say: Told what is going on.

    Returns:
        The reports: for each recording one of the take and one of the session.

    Raises:
        Refused: The recordings are not there.
    """
    source = recordings()
    out.mkdir(parents=True, exist_ok=True)
    made: list[Path] = []
    with tempfile.TemporaryDirectory() as folder, open_clinic(Path(folder), settings=Settings()) as clinic:
        for example in EXAMPLES:
            say(f"{example.name}: {example.file}")
            made += _make(clinic, example, source / example.file, out, seed, say)
    return made


def _imported(clinic: Clinic, example: Example, file: Path) -> ImportedSummary:
    """The take, whose exercise is called after the example and not after the file."""
    with tempfile.TemporaryDirectory() as folder:
        named = Path(folder) / f"{example.name.replace('-', '_')}{file.suffix}"
        shutil.copyfile(file, named)
        return clinic.takes.import_file(named, actor=CONSOLE, side="right")


def recordings() -> Path:
    """Folder of the real recordings, which are not part of the project.

    Raises:
        Refused: It is not there.
    """
    named = os.environ.get(ENVIRONMENT, "")
    beside = Path(__file__).resolve().parents[2].parent / "shared" / "data"
    folder = Path(named) if named else beside
    if not folder.is_dir():
        raise Refused(
            "folder of real recordings",
            f"{folder}, which does not exist",
            "a folder with mocap_hand_dfki and human_hand_video",
            f"name it in {ENVIRONMENT}",
        )
    return folder


def _make(
    clinic: Clinic, example: Example, file: Path, out: Path, seed: int, say: Callable[[str], None]
) -> list[Path]:
    summary = _imported(clinic, example, file)
    played = summary.take
    if example.scale:
        wish = Wish(scale=example.scale)
        played = clinic.retouching.retouch(played, wish, example.reason, actor=CONSOLE).id
    clinic.takes.approve(played, CONSOLE)
    order = Order(speed=SPEED, repetitions=1, seed=seed)
    prepared = clinic.therapy.plan(played, order, actor=CONSOLE)
    for note in prepared.notes:
        say(f"  {note}")
    result = clinic.therapy.rehearse_and_play(prepared, actor=CONSOLE)
    percent = 100 * prepared.plan.prescription.speed
    say(f"  played at {percent:.0f} % of its speed: {result.simulated_s:.0f} s of therapy")
    made: list[Path] = []
    for subject, kind in ((summary.take, "take"), (result.session, "session")):
        for path in clinic.reports.report([subject], FORMATS[kind], actor=CONSOLE):
            target = out / f"{example.name}-{kind}{path.suffix}"
            shutil.copyfile(path, target)
            made.append(target)
    return made
