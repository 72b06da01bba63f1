"""Numbers of sealed files, kept by digest and version: what is there, what is missing, and keeping it."""

from __future__ import annotations

from collections.abc import Sequence

from rehab_app.config import ClinicFolder
from rehab_app.services.passive_runs import key_of, passive_runs
from rehab_app.services.recompute_work import Measured, Work
from sessions.catalogue import Catalogue, Take, TherapySession
from sessions.reports.past import Past, past_from_json, past_version


class KeptNumbers:
    """The one place that reads and keeps what was measured; measuring itself is for others.

    Args:
        folder: The clinic folder.
        catalogue: Where numbers are kept.
    """

    def __init__(self, folder: ClinicFolder, catalogue: Catalogue) -> None:
        self._folder = folder
        self._catalogue = catalogue

    def works(self, rows: Sequence[TherapySession]) -> tuple[Work, ...]:
        """What measuring each session would take, in their order."""
        runs = self._runs(rows)
        version, root = past_version(), self._folder.root
        return tuple(
            Work(
                row.id,
                row.sha256,
                key_of(version, runs[row.sha256]),
                root / row.path,
                tuple(root / run.path for run in runs[row.sha256]),
            )
            for row in rows
        )

    def take_works(self, takes: Sequence[Take]) -> tuple[Work, ...]:
        """What measuring each take would take."""
        version, root = past_version(), self._folder.root
        return tuple(Work(take.id, take.sha256, version, root / take.path) for take in takes)

    def texts(self, works: Sequence[Work]) -> dict[str, str]:
        """What is kept of these, as it is kept, by digest; other versions are left out."""
        found: dict[str, str] = {}
        for key in dict.fromkeys(work.key for work in works):
            found |= self._catalogue.kept_metrics([work.sha256 for work in works if work.key == key], key)
        return found

    def pasts(self, works: Sequence[Work]) -> dict[str, Past]:
        """As ``texts``, read."""
        return {digest: past_from_json(text) for digest, text in self.texts(works).items()}

    def keep(self, answer: Measured) -> Past | str:
        """Keep what was measured, unless its file is not the one that was sealed.

        Returns:
            The numbers, or why there are none.
        """
        if answer.refusal:
            return answer.refusal
        if answer.version != past_version():
            return "measured by another version of this program"
        past = past_from_json(answer.content)
        if past.sha256 == answer.work.sha256:
            self._catalogue.keep_metrics(answer.work.sha256, answer.work.key, answer.content)
        return past

    def _runs(self, rows: Sequence[TherapySession]) -> dict[str, tuple[TherapySession, ...]]:
        """Passive runs of the same day by a session's digest."""
        patients = dict.fromkeys(row.patient for row in rows if row.patient)
        others = {patient: self._catalogue.sessions(patient) for patient in patients}
        return {row.sha256: passive_runs(row, others.get(row.patient, ())) for row in rows}
