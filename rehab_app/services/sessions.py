"""Therapy sessions and their replay."""

from __future__ import annotations

from pathlib import Path

from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.replay import replay_of
from rehab_app.services.rows import Replay, SessionRow
from sessions.catalogue import Catalogue, TherapySession


class Sessions:
    """Recorded therapy sessions; ``path`` and ``replay`` find takes as well.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
    """

    def __init__(self, folder: ClinicFolder, catalogue: Catalogue) -> None:
        self._folder = folder
        self._catalogue = catalogue

    def list(self) -> tuple[SessionRow, ...]:
        """All sessions, newest first."""
        return tuple(self._row(session) for session in self._catalogue.sessions())

    def get(self, session: str) -> SessionRow:
        """One session by catalogue id.

        Raises:
            Refused: There is none.
        """
        return self._row(self._catalogue.session(session))

    def path(self, named: str | Path) -> Path:
        """File of a session or take, by path or catalogue id.

        Raises:
            Refused: There is no such session or take.
        """
        if storage.is_path(named):
            return Path(named)
        for find in (self._catalogue.session, self._catalogue.take):
            try:
                return self._folder.root / find(str(named)).path
            except Refused:
                continue
        raise Refused(
            f"session or take {str(named)!r}",
            "unknown",
            f"the id of a session or take in {self._folder.root}, or a path",
            "check the id, or name the clinic folder with --data",
        )

    def replay(self, named: str | Path) -> Replay:
        """A session or take for the review viewport, at about 50 Hz.

        Raises:
            Refused: There is no such session or take, or its file is damaged.
        """
        return replay_of(self.path(named))

    def _row(self, session: TherapySession) -> SessionRow:
        return SessionRow(
            id=session.id,
            path=self._folder.root / session.path,
            sha256=session.sha256,
            patient_id=session.patient,
            take_id=session.take,
            mode=session.mode,
            started_utc_ns=session.started_utc_ns,
        )
