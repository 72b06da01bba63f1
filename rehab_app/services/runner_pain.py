"""Pain by one tap, at any moment: held at once, written at once; score and place may follow."""

from __future__ import annotations

from rehab_app.access import Account
from rehab_app.errors import Refused
from rehab_app.services.journal import Journal, PainReport
from rehab_app.services.live import LiveDesk
from rehab_app.services.runner_steps import Course, When
from sessions.records import DIGITS


class PainTaps:
    """Enters pain. Nothing about it waits for a score.

    Args:
        desk: The live desk; what moves is held.
        journal: Where it is written.
    """

    def __init__(self, desk: LiveDesk, journal: Journal) -> None:
        self._desk = desk
        self._journal = journal

    def tap(
        self,
        account: Account,
        course: Course | None,
        score: int | None = None,
        place: str = "",
        corrects: int = 0,
    ) -> int:
        """Hold what moves and write the pain; a later call with the number adds score and place to it.

        Args:
            account: Who enters it; any role may.
            course: The session that goes on, None where there is none.
            score: 0 to 10, None where only "it hurts" is said.
            place: Where.
            corrects: Number of the tap that this says more about, 0 for a new one.

        Returns:
            Number of the entry; 0 where nobody is known whom it could belong to (a demonstration).

        Raises:
            Refused: Score or place is none. What moves is held all the same.
        """
        seen = self._desk.snapshot()
        if not corrects:
            self._desk.pain(account, place if place in DIGITS else "")
        patient = seen.patient_id or ("" if course is None else course.patient)
        if not patient:
            return 0
        told = PainReport(score, place, _when(course, playing=seen.state == "playing"))
        # Who may not correct an entry says more in a new one: nothing that a patient says is lost.
        named = corrects if account.may("note") else 0
        try:
            return self._journal.pain(account, patient, told, corrects=named).id
        except Refused:
            if not named:
                raise
            return self._journal.pain(account, patient, told).id


def _when(course: Course | None, *, playing: bool) -> When:
    if playing or course is None:
        return "during"
    return course.step.when
