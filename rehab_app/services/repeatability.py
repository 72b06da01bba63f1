"""How repeatable the numbers of this set-up are: estimated from repeated recordings, kept as a setting."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.recording_request import RecordingRequest
from sessions.catalogue import Setting
from sessions.metrics import Summary, measure_file
from sessions.metrics.repeatability import FEWEST, Repeat, repeatability

if TYPE_CHECKING:
    from rehab_app.services.audit import Audit
    from rehab_app.services.sessions import Sessions
    from sessions.catalogue import Catalogue

KEY, KEY_VIRTUAL = "repeatability", "repeatability-virtual"
MOST_VIRTUAL = 50
SECONDS = 8.0


class Repeatability:
    """Standard errors of measurement and minimal detectable changes of this clinic's set-up.

    Args:
        catalogue: Where they are kept.
        sessions: Where takes and sessions are found.
        audit: Where an estimate is noted.
    """

    def __init__(self, catalogue: Catalogue, sessions: Sessions, audit: Audit) -> None:
        self._catalogue = catalogue
        self._sessions = sessions
        self._audit = audit

    def estimate(self, actor: Account, takes: Sequence[str | Path]) -> tuple[Repeat, ...]:
        """Estimate from recordings that were repeated without a change between, and keep the result.

        Those of one person, side and exercise form a group.

        Args:
            actor: Who asks (verb "approve").
            takes: Takes or sessions, by path or catalogue id.

        Raises:
            Refused: The actor may not, a file cannot be measured, or there are too few repetitions.
        """
        require(actor, "approve")
        _check_count(len(takes))
        rows = [measure_file(self._sessions.unchanged(take)) for take in takes]
        if len({row.sha256 for row in rows}) < len(rows):
            raise Refused("recordings", "with one named twice", "different ones", "name each once")
        return self._keep(actor, rows, KEY)

    def estimate_virtual(
        self, actor: Account, count: int, exercise: str, said: Callable[[str], None]
    ) -> tuple[Repeat, ...]:
        """Estimate from recordings of the virtual camera, each with markers stuck on anew.

        Kept apart: what a rendered hand gives is no bound for a patient.

        Args:
            actor: Who asks (verb "approve").
            count: How many recordings.
            exercise: Movement of the virtual camera.
            said: Told how far it is.

        Raises:
            Refused: The actor may not, the count or the exercise is out of bounds.
        """
        from rehab_app.services.take_sources import Listeners, record_take

        require(actor, "approve")
        _check_count(count)
        if count > MOST_VIRTUAL:
            raise Refused("recordings", str(count), f"at most {MOST_VIRTUAL}", "ask for fewer")
        rows: list[Summary] = []
        with tempfile.TemporaryDirectory() as folder:
            for seed in range(1, count + 1):
                path = Path(folder) / f"{seed}.mcap"
                request = RecordingRequest(exercise=exercise, side="right", seconds=SECONDS, seed=seed)
                record_take(request, path, calibrations=(None,), subject=None, listeners=Listeners())
                rows.append(measure_file(path))
                said(f"Recording {seed} of {count} measured.")
        return self._keep(actor, rows, KEY_VIRTUAL)

    def kept(self, key: str = KEY) -> tuple[Repeat, ...]:
        """What was estimated last; empty if nothing was.

        Args:
            key: ``KEY``, or ``KEY_VIRTUAL`` for the virtual camera's.
        """
        kept = self._catalogue.setting(key)
        return () if kept is None else msgspec.json.decode(kept.content, type=tuple[Repeat, ...])

    def _keep(self, actor: Account, rows: Sequence[Summary], key: str) -> tuple[Repeat, ...]:
        found = repeatability((_whose(row), row.metrics) for row in rows)
        if not found:
            raise Refused(
                "recordings",
                "without a number that was measured often enough",
                f"at least {FEWEST + 1} of one person, side and exercise",
                "record the same movement more often",
            )
        renewed = {(one.name, one.subject, one.source) for one in found}
        others = tuple(one for one in self.kept(key) if (one.name, one.subject, one.source) not in renewed)
        content = msgspec.json.encode((*others, *found)).decode()
        self._catalogue.set(Setting(key=key, content=content, by=actor.name))
        self._audit.note(actor, "estimate repeatability", "", f"{len(rows)} recordings")
        return found


def _whose(row: Summary) -> str:
    header = row.header
    return "/".join((header.subject_id, header.side, header.exercise))


def _check_count(count: int) -> None:
    if count < FEWEST + 1:
        raise Refused("recordings", str(count), f"at least {FEWEST + 1}", "record the movement more often")
