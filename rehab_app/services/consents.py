"""Consent to images: given, withdrawn, and what is taken away then."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec

from rehab_app import __version__
from rehab_app.access import Account, require
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.recording.without_images import has_images, write_without_images
from rehab_app.services import storage
from rehab_app.services.audit import Audit
from rehab_app.services.takes import Lineage, Takes
from sessions.catalogue import Catalogue, PatientEntry

IMAGES = "images"
_LONGEST = 500


@dataclass(frozen=True, slots=True)
class Consent:
    """One statement of a patient about images.

    Attributes:
        given: Whether they agree.
        remark: How it was said, such as "signed form"; never a name.
    """

    given: bool
    remark: str = ""


@dataclass(frozen=True, slots=True)
class StatedConsent:
    """A statement with who noted it and when.

    Attributes:
        consent: The statement.
        by: Who noted it.
        utc_ns: When.
    """

    consent: Consent
    by: str
    utc_ns: int


class Consents:
    """Keeps what patients agree to. The newest statement counts; without one nothing is agreed.

    Args:
        folder: The clinic folder.
        catalogue: Its catalogue.
        takes: Recorded demonstrations.
        audit: Where statements are noted.
    """

    def __init__(self, folder: ClinicFolder, catalogue: Catalogue, takes: Takes, audit: Audit) -> None:
        self._folder = folder
        self._catalogue = catalogue
        self._takes = takes
        self._audit = audit

    def history(self, patient_id: str) -> tuple[StatedConsent, ...]:
        """Every statement, newest first.

        Raises:
            Refused: The patient is unknown.
        """
        rows = self._catalogue.entries(patient_id, ["consent"], topic=IMAGES)
        return tuple(
            StatedConsent(msgspec.json.decode(row.content, type=Consent), row.by, row.created_utc_ns)
            for row in rows
        )

    def given(self, patient_id: str) -> bool:
        """Whether images of the patient may be stored now.

        Raises:
            Refused: The patient is unknown.
        """
        newest = next(iter(self.history(patient_id)), None)
        return newest is not None and newest.consent.given

    def state(self, actor: Account, patient_id: str, given: bool, remark: str = "") -> StatedConsent:
        """Note what the patient says now. Withdrawing is for anyone who may note; so is agreeing.

        Raises:
            Refused: The actor may not, the patient is unknown, or the remark is too long.
        """
        require(actor, "note")
        if len(remark) > _LONGEST:
            length = f"{len(remark)} characters long"
            raise Refused("remark", length, f"at most {_LONGEST} characters", "shorten it")
        content = msgspec.json.encode(Consent(given, remark.strip())).decode()
        row = self._catalogue.add_entry(
            PatientEntry(patient=patient_id, kind="consent", topic=IMAGES, content=content, by=actor.name)
        )
        self._audit.note(actor, "give consent" if given else "withdraw consent", patient_id, IMAGES)
        return StatedConsent(Consent(given, remark.strip()), row.by, row.created_utc_ns)

    def with_images(self, patient_id: str) -> tuple[str, ...]:
        """Ids of takes of the patient's hand that hold images.

        Raises:
            Refused: A file is damaged.
        """
        own = self._catalogue.takes_of(patient_id)
        paths = [(take.id, self._folder.root / take.path) for take in own]
        return tuple(take for take, path in paths if path.exists() and has_images(path))

    def remove_images(self, actor: Account, patient_id: str) -> tuple[str, ...]:
        """Replace takes with images by takes without; the old files go for good. Approvals are asked anew.

        Returns:
            Ids of the new takes.

        Raises:
            Refused: The actor may not erase, or a file is damaged.
        """
        require(actor, "erase")
        return tuple(self._replaced(actor, take) for take in self.with_images(patient_id))

    def _replaced(self, actor: Account, take: str) -> str:
        old = self._catalogue.take(take)
        target = storage.new_file(self._folder.takes)
        source = self._folder.root / old.path
        write_without_images(source, target, actor.name, __version__)
        reason = "consent to images withdrawn"
        row = self._takes.enter(target, "remove images", actor, Lineage(old.id, actor.name, reason, ""))
        source.unlink(missing_ok=True)
        storage.digest_beside(source).unlink(missing_ok=True)
        self._audit.note(actor, "remove images", old.id, f"replaced by {row.id}")
        return row.id
