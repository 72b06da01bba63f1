"""A station that lost the network goes on, and catches up: what waited is brought in order."""

from __future__ import annotations

import threading
from dataclasses import dataclass

from rehab_app.errors import NoAnswer, Refused
from rehab_app.services.outbox_catalogue import StationCatalogue
from rehab_app.services.outbox_delivery import bare, deliver, erased
from rehab_app.services.outbox_folder import Letter, OutboxFolder
from sessions.catalogue import Catalogue

LOOK_S = 2.0
_LAST_WAIT_S = 2.0
_DAMAGED = "It is damaged and cannot be read: enter by hand what it was."


@dataclass(frozen=True, slots=True)
class OutboxState:
    """How the outbox stands.

    Attributes:
        away: Whether the catalogue did not answer when it was asked last.
        waiting: How many rows wait.
    """

    away: bool
    waiting: int

    @property
    def told(self) -> bool:
        """Whether a page says so."""
        return self.away or self.waiting > 0


class Outbox:
    """Brings what waited. A clinic whose catalogue is a file in its folder has nothing to bring.

    Args:
        catalogue: The clinic's catalogue.

    Attributes:
        trouble: Why the disk refused what should have been set aside, "" where it did not.
    """

    def __init__(self, catalogue: Catalogue) -> None:
        self._station = catalogue if isinstance(catalogue, StationCatalogue) else None
        self._woken = threading.Event()
        self._ended = False
        self._thread = threading.Thread(target=self._work, name="outbox", daemon=True)
        self.trouble = ""

    def state(self) -> OutboxState:
        """How it stands; asks the folder, never the catalogue."""
        station = self._station
        if station is None:
            return OutboxState(away=False, waiting=0)
        return OutboxState(station.reach.away, len(station.outbox.names()))

    def start(self) -> None:
        """Bring what waits from now on, on a thread of its own."""
        if self._station is not None:
            self._station.woken = self._woken.set
            self._thread.start()

    def close(self) -> None:
        """End; what still waits is brought at the next start."""
        self._ended = True
        self._woken.set()
        if self._thread.is_alive():
            self._thread.join(_LAST_WAIT_S)

    def bring(self) -> int:
        """Bring everything that waits, in order, until the catalogue does not answer.

        Another process that brings already is left to it.

        Returns:
            How many rows arrived.

        Raises:
            OSError: The disk refuses.
        """
        station = self._station
        if station is None or not station.outbox.names():
            return 0
        with station.outbox.delivering() as mine:
            return self._bring(station) if mine else 0

    def _bring(self, station: StationCatalogue) -> int:
        plain, arrived = station.plain(), 0
        for letter in station.outbox.waiting():
            try:
                arrived += _brought(plain, station.outbox, letter)
            except NoAnswer as said:
                station.reach.lost(said)
                return arrived
            station.reach.answered()
        station.settle()
        return arrived

    def _work(self) -> None:
        """Look now, whenever something was put there while the catalogue answers, and every 2 s."""
        while not self._ended:
            self._woken.clear()
            try:
                self._look()
                self.trouble = ""
            except OSError as error:
                self.trouble = (
                    f"What waits for the catalogue could not be set aside: {error.strerror or error}."
                )
            self._woken.wait(LOOK_S)

    def _look(self) -> None:
        """Bring what waits; where nothing does, find out whether the catalogue answers again."""
        station = self._station
        if station is None:
            return
        if station.outbox.names():
            self.bring()
        elif station.reach.away:
            try:
                station.data_base_time_ns()
            except NoAnswer:
                return


def _brought(catalogue: Catalogue, outbox: OutboxFolder, letter: Letter) -> int:
    """Bring one row, or set it aside; 1 where it arrived.

    Raises:
        NoAnswer: The catalogue does not answer; the row waits on.
        OSError: The disk refuses.
    """
    if letter.row is None:
        outbox.set_aside(letter, _DAMAGED, None)
        return 0
    try:
        deliver(catalogue, letter.row)
    except NoAnswer:
        raise
    except Refused as refusal:
        outbox.set_aside(letter, str(refusal), bare(letter.row) if erased(catalogue, letter.row) else None)
        return 0
    outbox.remove(letter.path)
    return 1
