"""Markers of a take that somebody names by hand, and the take that is tracked again from those names."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from rehab_app import __version__
from rehab_app.access import Account, require
from rehab_app.cameras import Frame
from rehab_app.cameras.recorded import RecordedCamera
from rehab_app.config import ClinicFolder
from rehab_app.errors import Refused
from rehab_app.hand.protocol import MarkerProtocol, load_protocol
from rehab_app.recording.labels import check_labels
from rehab_app.recording.track import track
from rehab_app.recording.track_order import TrackOrder, TrackResult
from rehab_app.services import storage
from rehab_app.services.calibrations import Calibrations
from rehab_app.services.rows import TakeRow
from rehab_app.services.takes import Takes
from rehab_app.tracking import Labels
from rehab_app.vision import Detector, colour_from_json, make_detector, protocol_colour
from sessions.records import SessionHeader
from sessions.records.fields import Float64
from sessions.records.topics import CAMERA_COLOUR
from sessions.store import SessionReader

FEWEST = 4
"""Markers that must be named before a hand can be fitted to them."""
_JPEG = [cv2.IMWRITE_JPEG_QUALITY, 92]


@dataclass(frozen=True, slots=True)
class FirstPicture:
    """The first picture of a take and what was found in it.

    Attributes:
        jpeg: The picture.
        width_px: Its width.
        height_px: Its height.
        blobs_px: Centres of the markers that were found, u v, from top to bottom, shape (D, 2).
        protocol: Name of the marker protocol.
        names: The markers that can be named, in its order.
    """

    jpeg: bytes
    width_px: int
    height_px: int
    blobs_px: Float64
    protocol: str
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TrackedAgain:
    """A take that was tracked again.

    Attributes:
        take: The new take.
        parent: Catalogue id of the take that its pictures come from.
        result: What the tracking says of it.
    """

    take: TakeRow
    parent: str
    result: TrackResult


class MarkerNames:
    """Names by hand; a ``take`` argument is a path or a catalogue id.

    Args:
        folder: The clinic folder.
        takes: Where takes are found and entered.
        calibrations: Calibrated cameras, which may know the markers' colour.
    """

    def __init__(self, folder: ClinicFolder, takes: Takes, calibrations: Calibrations) -> None:
        self._folder = folder
        self._takes = takes
        self._calibrations = calibrations
        self._at_work = threading.Lock()

    def why_not(self, take: str | Path) -> str:
        """Why the markers of a take cannot be named by hand, one sentence; empty where they can.

        Raises:
            Refused: There is no such take.
        """
        row = self._takes.get(take)
        try:
            self._nameable(row)
        except (_NotNameable, Refused) as why:
            return str(why)
        return ""

    def first_picture(self, take: str | Path, actor: Account) -> FirstPicture:
        """The picture in which markers are named.

        Raises:
            Refused: The actor may not record, or the take's markers cannot be named.
        """
        require(actor, "record")
        row = self._takes.get(take)
        header, protocol = self._named_by_hand(row)
        frame = _first_frame(row)
        found = _detector(self._colour(header), protocol).detect(
            frame.t_capture_ns, frame.colour_bgr, frame.depth_m, frame.intrinsics
        )
        order = np.lexsort((found.pixel_px[:, 0], found.pixel_px[:, 1]))
        return FirstPicture(
            jpeg=cv2.imencode(".jpg", frame.colour_bgr, _JPEG)[1].tobytes(),
            width_px=frame.intrinsics.width_px,
            height_px=frame.intrinsics.height_px,
            blobs_px=found.pixel_px[order],
            protocol=protocol.name,
            names=protocol.names,
        )

    def track_again(self, take: str | Path, labels: Labels, actor: Account) -> TrackedAgain:
        """Track a take's pictures from markers named by hand: a new take; the old one stays as it is.

        The new take holds no pictures: they stay in the one that was recorded.

        Args:
            take: The take.
            labels: Markers and where they are in its first picture.
            actor: Who named them.

        Raises:
            Refused: The actor may not record, a name or pixel is wrong, too few are named, no hand fits
                them, or another take is being tracked right now.
        """
        require(actor, "record")
        row = self._takes.get(take)
        header, protocol = self._named_by_hand(row)
        self._takes.check_unchanged(row)
        check_labels(labels, protocol, _first_frame(row).intrinsics)
        if len(labels.names) < FEWEST:
            raise Refused(
                "take", f"with {len(labels.names)} named markers", f"{FEWEST} or more", "name further markers"
            )
        if not self._at_work.acquire(blocking=False):
            raise Refused("tracking", "at work on a take", "one take at a time", "wait until it is done")
        try:
            result = track(self._order(row, header, labels))
        finally:
            self._at_work.release()
        return TrackedAgain(self._takes.enter(result.out, "track again", actor), row.id, result)

    def _order(self, row: TakeRow, header: SessionHeader, labels: Labels) -> TrackOrder:
        """The names are what was wrong, so the hand that was learnt with them is not used."""
        return TrackOrder(
            inputs=(row.path,),
            out=storage.new_file(self._folder.takes),
            side=header.side,
            software_version=__version__,
            protocol=header.marker_protocol,
            subject_id=header.subject_id,
            exercise=header.exercise,
            labels=labels,
            colour=self._colour(header),
            parents=(row.sha256,),
        )

    def _named_by_hand(self, row: TakeRow) -> tuple[SessionHeader, MarkerProtocol]:
        try:
            return self._nameable(row)
        except _NotNameable as why:
            raise Refused(
                f"take {row.id}", "without markers to click", "a take with pictures of markers", str(why)
            ) from why

    def _nameable(self, row: TakeRow) -> tuple[SessionHeader, MarkerProtocol]:
        """Header and protocol of a take whose markers can be named."""
        with SessionReader(row.path) as reader:
            header, pictures = reader.header, reader.counts.get(CAMERA_COLOUR.name, 0)
        if not pictures and header.source == RecordedCamera.name:
            raise _NotNameable("It holds no pictures: they are in the take that it was tracked from.")
        if not pictures:
            raise _NotNameable("It holds no pictures: record with consent to images.")
        try:
            protocol = load_protocol(header.marker_protocol)
        except Refused:
            protocol = None
        if protocol is None or protocol.names != header.marker_names:
            raise _NotNameable("Its marker protocol is not one of the clinic's: use rehab-app track --label.")
        if not any(marker.colour for marker in protocol.markers):
            raise _NotNameable("It was recorded of a bare hand, which wears no markers.")
        return header, protocol

    def _colour(self, header: SessionHeader) -> str:
        """Colour of the markers as learnt with the calibration that the take states, empty where none was."""
        known = {row.digest for row in self._calibrations.list()}
        digest = header.calibration_digest
        return self._calibrations.get(digest).colour if digest in known else ""


class _NotNameable(Exception):
    """Markers of a take cannot be named by hand; the text says why."""


def _first_frame(row: TakeRow) -> Frame:
    with RecordedCamera(row.path) as camera:
        return next(camera.frames())


def _detector(colour: str, protocol: MarkerProtocol) -> Detector:
    return make_detector(colour=colour_from_json(colour) if colour else protocol_colour(protocol))
