"""A progress bar on stderr; silent where stderr is no terminal."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rehab_app.cameras import Outage
    from rehab_app.cli.output import Output
    from rehab_app.recording.live_pose import LivePose
    from rehab_app.recording.progress import Progress
    from rehab_app.services.take_sources import Listeners


@contextmanager
def frames_bar(title: str) -> Generator[Progress]:
    """A bar of frames done; what it yields is told how far the work has come."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Bar(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(title, total=None)

        def told(done: int, total: int | None) -> None:
            bar.update(task, completed=done, total=total)

        yield told


@contextmanager
def watching(output: Output, seconds: float) -> Generator[Listeners]:
    """Shows how far a recording has come, and says what goes wrong when it does."""
    from rehab_app.services.take_sources import Listeners

    told = ""

    def say(sentence: str) -> None:
        nonlocal told
        if sentence and sentence != told:
            output.say(sentence)
        told = sentence

    with frames_bar("Recording, tenths of a second") as progress:

        def show(live: LivePose) -> None:
            progress(round(10.0 * live.t_s), round(10.0 * seconds))
            say(live.trouble)

        def show_outage(outage: Outage) -> None:
            say(outage.reason)

        yield Listeners(show, show_outage)
