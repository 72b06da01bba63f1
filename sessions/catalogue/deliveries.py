"""Writing once: a delivery that arrived is known by its number, however often it is brought."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager

from sqlalchemy.exc import DataError, IntegrityError

from sessions.catalogue.deliveries_tables import DeliveryRow
from sessions.catalogue.ledger import Ledger
from sessions.errors import Refused


class Deliveries(Ledger):
    """Deliveries of stations."""

    @contextmanager
    def once(self, delivery: str, utc_ns: int = 0) -> Generator[bool]:
        """One transaction for every verb of the block, and for the note that this delivery arrived.

        A connection that breaks while it is committed leaves it open whether it was: the delivery is then
        brought again, and the note says so.

        Args:
            delivery: Its number, up to 32 characters, drawn by who brings it.
            utc_ns: When its rows were made, for verbs that give a row its time; 0 for now.

        Yields:
            Whether it is new; where it is not, nothing must be written.

        Raises:
            Refused: The data base does not answer or cannot take it, or a verb of the block refused: nothing
                was written.
        """
        with _taken(), self._writing() as session:
            new = session.get(DeliveryRow, delivery) is None
            if new:
                session.add(DeliveryRow(delivery, self._clock_ns()))
            with self._joined(session, utc_ns):
                yield new

    def delivered(self, delivery: str) -> bool:
        """Whether a delivery arrived."""
        with self._reading() as session:
            return session.get(DeliveryRow, delivery) is not None


@contextmanager
def _taken() -> Generator[None]:
    """What the data base cannot hold is refused in one sentence: it would fail again each time."""
    try:
        yield
    except (DataError, IntegrityError) as error:
        said = " ".join(str(error.orig).split())[:200]
        raise Refused(
            "row", f"not taken ({said})", "one that the data base can hold", "correct it"
        ) from error
