"""Therapy sessions and their replay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services import storage
from rehab_app.services.object_rooms import Sealed, sealed_named
from rehab_app.services.replay import replay_of
from rehab_app.services.rows import Replay, SessionRow
from sessions.catalogue import Catalogue, TherapySession

ON_A_PAGE = 100


@dataclass(frozen=True, slots=True)
class SessionPage:
    """A page of sessions.

    Attributes:
        rows: Those of this page.
        total: How many there are on all pages.
        page: Number of this page, from 1.
        pages: Number of pages, at least 1.
    """

    rows: tuple[SessionRow, ...]
    total: int
    page: int
    pages: int


class Sessions:
    """Recorded therapy sessions; ``path`` and ``replay`` find takes as well.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        bring: Brings a file back that lies in the object store only; None where there is none.
    """

    def __init__(
        self, folder: ClinicFolder, catalogue: Catalogue, bring: Callable[[Sealed], None] | None = None
    ) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._bring = bring

    def list(self, patient: str = "") -> tuple[SessionRow, ...]:
        """All sessions, newest first; of one patient where named.

        Raises:
            Refused: No patient has that pseudonym.
        """
        return tuple(self._row(session) for session in self._catalogue.sessions(patient))

    def page(self, number: int) -> SessionPage:
        """A page of the sessions of everybody, newest first.

        Args:
            number: Of the page, from 1; the last one where there are fewer.
        """
        rows, total = self._catalogue.find_sessions(ON_A_PAGE * (max(number, 1) - 1), ON_A_PAGE)
        pages = max(1, -(-total // ON_A_PAGE))
        if number > pages:
            return self.page(pages)
        return SessionPage(tuple(self._row(row) for row in rows), total, max(number, 1), pages)

    def get(self, session: str) -> SessionRow:
        """One session by catalogue id.

        Raises:
            Refused: There is none.
        """
        return self._row(self._catalogue.session(session))

    def path(self, named: str | Path) -> Path:
        """File of a session or take, by path or catalogue id; brought back where only the store has it.

        Raises:
            Refused: There is no such session or take, or the object store does not give it back.
        """
        if storage.is_path(named):
            return Path(named)
        found = self._found(str(named))
        if self._bring is not None and not found.path.exists():
            self._bring(found)
        return found.path

    def unchanged(self, named: str | Path) -> Path:
        """As ``path``, for numbers and decisions: a file of the catalogue must be the one that was entered.

        Raises:
            Refused: As ``path``, or another file lies in its place.
        """
        path = self.path(named)
        if not storage.is_path(named):
            storage.check_unchanged(f"session or take {named}", path, self._found(str(named)).sha256)
        return path

    def replay(self, named: str | Path) -> Replay:
        """A session or take for the review viewport, at about 50 Hz.

        Raises:
            Refused: There is no such session or take, or its file is damaged.
        """
        return replay_of(self.path(named))

    def _found(self, named: str) -> Sealed:
        try:
            return sealed_named(self._folder, self._catalogue, named)
        except Refused:
            raise Refused(
                f"session or take {named!r}",
                "unknown",
                f"the id of a session or take in {self._folder.root}, or a path",
                "check the id, or name the clinic folder with --data",
            ) from None

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
