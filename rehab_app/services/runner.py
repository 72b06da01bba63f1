"""The session runner: leads one patient from check-in to note; the server keeps where it stands.

At most one session goes on at a time, as there is one robot. Every page shows the same step; a page that acts
says which step it saw, so that two pages never take two steps at once.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace

from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.journal import CheckIn, Journal
from rehab_app.services.live import LiveDesk
from rehab_app.services.order import PLAIN, Order
from rehab_app.services.patients import Patients
from rehab_app.services.plain_text import one_line
from rehab_app.services.runner_file import CourseFile
from rehab_app.services.runner_note import Notes, Told
from rehab_app.services.runner_pain import PainTaps
from rehab_app.services.runner_plan import Choice, SessionPlans
from rehab_app.services.runner_steps import KEYS, Course, Stay, step_named

_LONGEST_REASON = 200


class SessionRunner:
    """Begins, steps and ends a session; starts what its steps start through the live desk.

    Args:
        folder: The clinic folder.
        patients: Patients.
        desk: The live desk.
        journal: Where check-in, pain and note are written.
        plans: What the steps play.
        notes: Composes the note.
        audit: Where verbs are noted.
        clock_ns: UTC in ns.
    """

    def __init__(
        self,
        folder: ClinicFolder,
        patients: Patients,
        desk: LiveDesk,
        journal: Journal,
        plans: SessionPlans,
        notes: Notes,
        audit: Audit,
        clock_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._file = CourseFile(folder.root / "live-session.json")
        self._patients = patients
        self._desk = desk
        self._journal = journal
        self._plans = plans
        self._notes = notes
        self._audit = audit
        self._clock_ns = clock_ns
        self._changing = threading.Lock()
        self._course = self._file.read()
        self._taps = PainTaps(desk, journal)
        self._known: tuple[tuple[int, str], bool] = ((0, ""), False)

    @property
    def course(self) -> Course | None:
        """The session that goes on, None where there is none; takes no lock."""
        return self._course

    def begin(self, actor: Account, patient_id: str, present: str) -> Course:
        """Begin a session with the check-in.

        Args:
            actor: Who leads it (verb "play").
            patient_id: Pseudonym.
            present: Pseudonym of who is there, as a person confirmed by name, birth date and side.

        Raises:
            Refused: The actor may not, nobody confirmed the patient, or another session goes on.
        """
        require(actor, "play")
        patient = self._patients.get(patient_id)
        if present != patient.id:
            asked = "compare them with the patient and tick the box"
            raise Refused("patient", "not confirmed", "confirmed by name, birth date and side", asked)
        now_ns = self._clock_ns()
        with self._changing:
            if self._course is not None:
                bound = "ended before the next begins"
                raise Refused(
                    "session", f"going on with {self._course.patient}", bound, "go on with it, or end it"
                )
            first = Stay(step=KEYS[0], began_utc_ns=now_ns)
            course = Course(patient=patient.id, by=actor.name, began_utc_ns=now_ns, stays=(first,))
            self._keep(course)
        self._audit.note_later(actor.name, "begin session", patient.id)
        return course

    def go(self, actor: Account, at: str, to: str, reason: str = "") -> Course:
        """Leave a step for another one, forwards or back; what was not done counts as skipped.

        Args:
            actor: Who steps (verb "play").
            at: Step that the page showed.
            to: Step to show.
            reason: Why the step is left undone, may be empty.

        Raises:
            Refused: The actor may not, there is no session or step, another page has stepped meanwhile, or
                something moves.
        """
        require(actor, "play")
        wanted = step_named(to)
        why = one_line("reason", reason, _LONGEST_REASON)
        self._check_still()
        with self._changing:
            course = self._at(at)
            now_ns = self._clock_ns()
            done = self._done(course)
            left = replace(
                course.stays[-1], ended_utc_ns=now_ns, skipped=not done, reason="" if done else why
            )
            stays = (*course.stays[:-1], left, Stay(step=wanted.key, began_utc_ns=now_ns))
            course = self._keep(replace(course, stays=stays))
        self._audit.note_later(actor.name, "session step", course.patient, f"{at} to {wanted.key}")
        return course

    def check_in(self, actor: Account, answers: CheckIn) -> Course:
        """Write the check-in and go on to the next step; asked again, it corrects the first.

        Raises:
            Refused: The actor may not note, there is no session, or an answer is none.
        """
        with self._changing:
            course = self._going()
            entry = self._journal.check_in(actor, course.patient, answers, corrects=course.check_in)
            course = self._keep(replace(course, check_in=entry.id))
        if course.step.key == KEYS[0]:
            return self.go(actor, KEYS[0], KEYS[1])
        return course

    def choices(self) -> tuple[Choice, ...]:
        """What the step that is shown can play."""
        course = self._course
        return () if course is None else self._plans.choices(course.patient, course.step)

    def start(self, actor: Account, at: str, chosen: str = "", like: Order = PLAIN) -> None:
        """Start what the step starts: the fit check, the sweep, or one of its choices.

        Args:
            actor: Who starts it.
            at: Step that the page showed.
            chosen: Key of one of ``choices``.
            like: Where device, wrist and virtual patient come from.

        Raises:
            Refused: There is no such choice or no take for it, or the live desk refuses.
        """
        require(actor, "play")
        course = self._at(at)
        step, patient = course.step, course.patient
        if step.starts in ("fit", "range"):
            self._desk.start_assessment(actor, step.starts, patient, like, present=patient)
            return
        if step.starts != "play":
            raise Refused(f"step {step.words}", "without anything that moves", "one that moves", "go on")
        choice = next((one for one in self.choices() if one.key == chosen), None)
        if choice is None or not choice.take:
            value = "not chosen" if choice is None else f"without an approved take ({choice.words})"
            raise Refused("exercise", value, "one with an approved take", "record and approve one, or skip")
        self._desk.start_therapy(actor, patient, choice.take, choice.order(like), present=patient)

    def pain(self, actor: Account, score: int | None = None, place: str = "", corrects: int = 0) -> int:
        """Pain by one tap: held at once, written at once. See ``PainTaps.tap``.

        Raises:
            Refused: Score or place is none. What moves is held all the same.
        """
        entry = self._taps.tap(actor, self._course, score, place, corrects)
        with self._changing:
            course = self._course
            if entry and course is not None:
                kept = tuple(one for one in course.pains if one != corrects)
                self._keep(replace(course, pains=(*kept, entry)))
        return entry

    def note(self) -> Told:
        """The note of the session so far, to be read and changed.

        Raises:
            Refused: There is no session.
        """
        return self._notes.compose(self._going(), self._clock_ns())

    def end(self, actor: Account, text: str) -> str:
        """End the session; a text is written into the journal as its note.

        Args:
            actor: Who ends it (verb "note").
            text: The note, empty for none.

        Returns:
            Pseudonym of the patient.

        Raises:
            Refused: The actor may not, there is no session, something moves, or the text cannot be kept.
        """
        require(actor, "note")
        self._check_still()
        with self._changing:
            course = self._going()
            if text.strip():
                last = next(iter(self._notes.sessions(course)), None)
                self._journal.note(actor, course.patient, text, session="" if last is None else last.id)
            self._keep(None)
        self._audit.note_later(actor.name, "end session", course.patient)
        return course.patient

    def done(self) -> bool:
        """Whether the step that is shown was done; asks the catalogue only when something has changed."""
        course = self._course
        if course is None:
            return False
        key = (course.version, self._desk.snapshot().session_id)
        if self._known[0] != key:
            self._known = (key, self._done(course))
        return self._known[1]

    def _done(self, course: Course) -> bool:
        """Whether the step that is shown was done: something of its kind was run, or written, in it."""
        step = course.step
        if step.key == "check-in":
            return course.check_in > 0
        if step.starts:
            began_ns = min(stay.began_utc_ns for stay in course.stays if stay.step == step.key)
            return any(row.started_utc_ns >= began_ns for row in self._notes.sessions(course))
        return True

    def _going(self) -> Course:
        if self._course is None:
            raise Refused("session", "not begun", "going on", "choose the patient and begin one")
        return self._course

    def _at(self, key: str) -> Course:
        course = self._going()
        if course.step.key != key:
            words = course.step.words
            raise Refused(
                "session", f"at {words} already", "where this page saw it", "look at the page again"
            )
        return course

    def _check_still(self) -> None:
        if self._desk.snapshot().state in ("rehearsing", "playing", "countdown", "recording"):
            raise Refused("live desk", "busy", "at rest", "wait until it is done, or stop it")

    def _keep(self, course: Course | None) -> Course:
        before = self._course
        kept = None if course is None else replace(course, version=course.version + 1)
        self._file.write(kept)
        self._course = kept
        shown = kept or before
        assert shown is not None
        return shown
