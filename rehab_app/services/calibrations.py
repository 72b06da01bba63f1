"""What the clinic has calibrated: its cameras and the hands of persons; versions are never overwritten."""

from __future__ import annotations

from rehab_app.access import Account, require
from rehab_app.calibration import CalibratedCamera, camera_from_json, camera_to_json
from rehab_app.hand.subject import Subject, subject_from_json, subject_to_json
from rehab_app.services.audit import Audit
from sessions.catalogue import CameraCalibration, Catalogue, Hand
from sessions.records import Side


class Calibrations:
    """Calibrations of cameras.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where additions are noted.
    """

    def __init__(self, catalogue: Catalogue, audit: Audit) -> None:
        self._catalogue = catalogue
        self._audit = audit

    def add(self, actor: Account, camera: CalibratedCamera) -> CameraCalibration:
        """Keep a calibration: the current one of its camera from now on, unless it is there already.

        Args:
            actor: Who adds (verb "record").
            camera: The calibration. One without a time of its own is given this moment's.

        Raises:
            Refused: The actor may not.
        """
        require(actor, "record")
        dated = camera if camera.created_utc else camera.now()
        row = self._catalogue.add_calibration(
            CameraCalibration(
                digest=dated.digest,
                camera=dated.camera,
                verdict=dated.verdict,
                content=camera_to_json(dated),
            )
        )
        self._audit.note(actor, "add calibration", row.digest[:12], dated.verdict)
        return row

    def list(self, camera: str = "") -> tuple[CameraCalibration, ...]:
        """All versions, newest first; of one camera where named."""
        return self._catalogue.calibrations(camera)

    def get(self, digest: str) -> CalibratedCamera:
        """The version of that digest, or of that beginning of one.

        Raises:
            Refused: There is none, or there are several.
        """
        return camera_from_json(self._catalogue.calibration(digest).content)

    def current(self, camera: str) -> CalibratedCamera | None:
        """The newest version of a camera, None where it was never calibrated."""
        rows = self._catalogue.calibrations(camera)
        return camera_from_json(rows[0].content) if rows else None


class Hands:
    """Calibrated hands of patients and therapists, by pseudonym.

    Args:
        catalogue: The clinic's catalogue.
        audit: Where additions are noted.
    """

    def __init__(self, catalogue: Catalogue, audit: Audit) -> None:
        self._catalogue = catalogue
        self._audit = audit

    def keep(self, actor: Account, person: str, protocol: str, subject: Subject) -> Hand:
        """Keep a person's hand; from now on it is the current one for its side and protocol.

        Args:
            actor: Who adds (verb "record").
            person: Pseudonym of the patient or therapist.
            protocol: Name of the marker protocol that the hand wore.
            subject: The hand; its geometry says the side.

        Raises:
            Refused: The actor may not, or nobody is named.
        """
        require(actor, "record")
        hand = self._catalogue.add_hand(
            Hand(
                person=person.strip(),
                side=subject.geometry.side,
                protocol=protocol,
                content=subject_to_json(subject),
            )
        )
        self._audit.note(actor, "keep hand", hand.person, f"{hand.side} hand, {protocol}")
        return hand

    def current(self, person: str, side: Side, protocol: str) -> Subject | None:
        """The newest hand of a person for a side and protocol, None where there is none.

        Raises:
            Refused: What was kept is not readable.
        """
        rows = self._catalogue.hands(person, side, protocol)
        return subject_from_json(rows[0].content) if rows else None

    def list(self, person: str) -> tuple[Hand, ...]:
        """Every version of a person's hands, newest first."""
        return self._catalogue.hands(person)
