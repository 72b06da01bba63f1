"""Proposals of the next step: made of the last sessions, answered by a therapist, kept either way."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace

import msgspec

from rehab_app.access import Account, require
from rehab_app.errors import Refused
from rehab_app.services.audit import Audit
from rehab_app.services.plan_items import Plan, PlanItem
from rehab_app.services.progress import Notebook, ProgressReports
from rehab_app.services.proposal_rules import Evidence, Step, evidence, next_step
from sessions.catalogue import Catalogue, PatientEntry, Setting
from sessions.reports.progress import Progress

TARGET = 0.7
LEAST_TARGET, MOST_TARGET = 0.5, 0.9
STRONG_PAIN = 5
RISING_PAIN = 2
"""Published least important difference of pain (2 to 2.5 of 10)."""
_KIND, _SETTING = "proposal", "success-target"


@dataclass(frozen=True, slots=True)
class Proposal:
    """The next step for one item of a patient's plan.

    Attributes:
        item: The item as it is.
        step: What is proposed, and why.
        known: What it is made of.
        digest: Names exactly this proposal: another plan, session or target gives another one.
        declined_by: Who declined exactly this, empty if nobody.
    """

    item: PlanItem
    step: Step
    known: Evidence
    digest: str
    declined_by: str = ""

    @property
    def changes(self) -> tuple[tuple[str, float, float], ...]:
        """What would be changed: name, now, then; empty where nothing is proposed."""
        pairs = (
            ("speed", self.item.speed, self.step.speed),
            ("stiffness_multiple", self.item.stiffness_multiple, self.step.stiffness_multiple),
            ("resistance", self.item.resistance, self.step.resistance),
            ("range", 1.0, self.step.range_share),
        )
        return tuple(pair for pair in pairs if pair[1] != pair[2])


@dataclass(frozen=True, slots=True)
class Answer:
    """What a therapist answered to a proposal, as it is kept.

    Attributes:
        digest: Which proposal.
        accepted: Whether it was accepted.
        item: Key of the item.
        exercise: Its exercise.
        changes: What was proposed: name, before, after.
        why: The sentence that was shown.
        sessions: The sessions that it was made of.
        remark: The therapist's own words.
        by: Who answered.
        created_utc_ns: When.
    """

    digest: str
    accepted: bool
    item: int
    exercise: str
    changes: tuple[tuple[str, float, float], ...]
    why: str
    sessions: tuple[str, ...]
    remark: str = ""
    by: str = ""
    created_utc_ns: int = 0


class Proposals:
    """Makes proposals and keeps the answers.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where answers are noted.
        progress: What happened in the past.
        notebook: Plans and pain.
    """

    def __init__(
        self, catalogue: Catalogue, audit: Audit, progress: ProgressReports, notebook: Notebook
    ) -> None:
        self._catalogue = catalogue
        self._audit = audit
        self._progress = progress
        self._notebook = notebook

    def target(self) -> float:
        """Share of successful repetitions that is aimed at."""
        kept = self._catalogue.setting(_SETTING)
        return TARGET if kept is None else float(json.loads(kept.content))

    def set_target(self, actor: Account, target: float) -> None:
        """Aim at another share (verb "prescribe").

        Raises:
            Refused: The actor may not, or the share is out of bounds.
        """
        require(actor, "prescribe")
        if not LEAST_TARGET <= target <= MOST_TARGET:
            bound = f"{100 * LEAST_TARGET:.0f} to {100 * MOST_TARGET:.0f} %"
            raise Refused("aim of success", f"{100 * target:g} %", bound, "choose another")
        self._catalogue.set(Setting(key=_SETTING, content=json.dumps(target), by=actor.name))
        self._audit.note(actor, "set success target", "", f"{100 * target:.0f} %")

    def of_patient(self, patient_id: str) -> tuple[Proposal, ...]:
        """The next step for every item of the plan, in its order; empty without a plan.

        Raises:
            Refused: There is no such patient.
        """
        plan = self._notebook.plans.current(patient_id)
        if not plan.items:
            return ()
        found, target = self._progress.of_patient(patient_id), self.target()
        pain = _told_pain(found)
        declined = {answer.digest: answer.by for answer in self.answers(patient_id) if not answer.accepted}
        made: list[Proposal] = []
        for item in plan.items:
            known = evidence(item, found.pasts, pain)
            step = next_step(item, known, target)
            digest = _digest(plan, item, step, known)
            made.append(Proposal(item, step, known, digest, declined.get(digest, "")))
        return tuple(made)

    def answer(
        self, actor: Account, patient_id: str, digest: str, *, accept: bool, remark: str = ""
    ) -> Answer:
        """Accept or decline exactly the proposal that was shown; accepting it changes the plan.

        Args:
            actor: Who answers (verb "prescribe").
            patient_id: Pseudonym.
            digest: Of the proposal that was shown.
            accept: Whether the plan is changed.
            remark: Anything else.

        Raises:
            Refused: The actor may not, or plan or sessions have changed since the proposal was shown.
        """
        require(actor, "prescribe")
        found = next((one for one in self.of_patient(patient_id) if one.digest == digest), None)
        if found is None or not found.changes:
            raise Refused(
                "proposal",
                "no longer the one that was shown",
                "of today's plan and sessions",
                "load the page again",
            )
        if accept:
            plan = self._notebook.plans.current(patient_id)
            self._notebook.plans.change(actor, _changed(plan, found))
        kept = Answer(
            digest,
            accept,
            found.item.key,
            found.item.exercise,
            found.changes,
            found.step.why,
            found.known.sessions,
            remark.strip()[:500],
        )
        row = self._catalogue.add_entry(
            PatientEntry(
                patient=patient_id, kind=_KIND, content=msgspec.json.encode(kept).decode(), by=actor.name
            )
        )
        self._audit.note(actor, "accept proposal" if accept else "decline proposal", patient_id, digest[:12])
        return _read(row)

    def answers(self, patient_id: str, limit: int = 200) -> tuple[Answer, ...]:
        """What was answered, newest first.

        Raises:
            Refused: There is no such patient.
        """
        return tuple(_read(row) for row in self._catalogue.entries(patient_id, (_KIND,), limit=limit))


def _read(row: PatientEntry) -> Answer:
    answer = msgspec.json.decode(row.content, type=Answer)
    return replace(answer, by=row.by, created_utc_ns=row.created_utc_ns)


def _changed(plan: Plan, found: Proposal) -> Plan:
    step, item = found.step, found.item
    remark = item.remark
    if step.range_share < 1.0:
        scaled = f"Play {100 * step.range_share:.0f} % of the range: scale the take down and approve it."
        remark = f"{remark} {scaled}".strip() if scaled not in remark else remark
    changed = replace(
        item,
        speed=step.speed,
        stiffness_multiple=step.stiffness_multiple,
        resistance=step.resistance,
        remark=remark,
    )
    items = tuple(changed if one.key == item.key else one for one in plan.items)
    return replace(plan, items=items, reason=step.why)


def _digest(plan: Plan, item: PlanItem, step: Step, known: Evidence) -> str:
    content = msgspec.json.encode((plan.version, item, step, known))
    return hashlib.sha256(content).hexdigest()


def _told_pain(found: Progress) -> bool:
    """Whether strong pain, or pain that rose by what matters to patients, was told since the last session."""
    if not found.pasts or not found.pains:
        return False
    since = found.pasts[-1].utc_start_ns
    before = [score for utc_ns, score in found.pains if utc_ns < since]
    after = [score for utc_ns, score in found.pains if utc_ns >= since]
    if not after:
        return False
    return max(after) >= STRONG_PAIN or (bool(before) and max(after) - before[-1] >= RISING_PAIN)
