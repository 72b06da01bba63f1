"""Verbs about what was calibrated: cameras, and the hands of persons. Versions are added, never changed."""

from __future__ import annotations

from sqlalchemy import select

from sessions.catalogue.ledger import Ledger
from sessions.catalogue.records import CameraCalibration, Hand
from sessions.catalogue.rows import SHORTEST_PREFIX, short_id, value_of
from sessions.catalogue.tables import CameraCalibrationRow, HandRow
from sessions.errors import Refused
from sessions.records import Side


class Calibrations(Ledger):
    """Calibrations of cameras and hands of persons."""

    def add_calibration(self, calibration: CameraCalibration) -> CameraCalibration:
        """Add a version; its number and time are given here. One that is there already is given back.

        Raises:
            Refused: The digest is not one.
        """
        short_id(calibration.digest, lambda _: False)
        with self._writing() as session:
            query = select(CameraCalibrationRow).where(CameraCalibrationRow.digest == calibration.digest)
            known = session.scalar(query)
            if known is not None:
                return value_of(CameraCalibration, known)
            row = CameraCalibrationRow(
                calibration.digest,
                calibration.camera,
                calibration.verdict,
                calibration.content,
                self._clock_ns(),
            )
            session.add(row)
            session.flush()
            return value_of(CameraCalibration, row)

    def calibration(self, digest: str) -> CameraCalibration:
        """A version by its digest or six or more leading characters of it.

        Raises:
            Refused: None has it, or several begin so.
        """
        found: list[CameraCalibrationRow] = []
        with self._reading() as session:
            if len(digest) >= SHORTEST_PREFIX and set(digest) <= set("0123456789abcdef"):
                begins = CameraCalibrationRow.digest.startswith(digest)
                found = list(session.scalars(select(CameraCalibrationRow).where(begins).limit(2)))
            if len(found) == 1:
                return value_of(CameraCalibration, found[0])
        thing = f"calibration {digest[:70]!r}"
        if found:
            raise Refused(thing, "ambiguous", "one calibration", "give more characters of its digest")
        raise Refused(
            thing,
            "unknown",
            "the digest of a calibration of this clinic",
            "list them with rehab-app calibrate list",
        )

    def calibrations(self, camera: str = "") -> tuple[CameraCalibration, ...]:
        """All versions, newest first; of one camera where named."""
        query = select(CameraCalibrationRow).order_by(CameraCalibrationRow.id.desc())
        if camera:
            query = query.where(CameraCalibrationRow.camera == camera)
        with self._reading() as session:
            return tuple(value_of(CameraCalibration, row) for row in session.scalars(query))

    def add_hand(self, hand: Hand) -> Hand:
        """Add a version of a person's hand; its number and time are given here."""
        with self._writing() as session:
            row = HandRow(hand.person, hand.side, hand.protocol, hand.content, self._clock_ns())
            session.add(row)
            session.flush()
            return value_of(Hand, row)

    def hands(self, person: str, side: Side | None = None, protocol: str = "") -> tuple[Hand, ...]:
        """Versions of a person's hands, newest first; of one side or protocol where named."""
        query = select(HandRow).where(HandRow.person == person).order_by(HandRow.id.desc())
        if side is not None:
            query = query.where(HandRow.side == side)
        if protocol:
            query = query.where(HandRow.protocol == protocol)
        with self._reading() as session:
            return tuple(value_of(Hand, row) for row in session.scalars(query))
