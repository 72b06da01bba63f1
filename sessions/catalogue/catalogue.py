"""The catalogue of a clinic folder: values in, values out, one short transaction per verb, any thread."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from sessions.catalogue.beginnings import Beginnings
from sessions.catalogue.calibrations import Calibrations
from sessions.catalogue.choices import Choices
from sessions.catalogue.clinic import Book
from sessions.catalogue.clinical import Clinical
from sessions.catalogue.copying import Copying
from sessions.catalogue.deliveries import Deliveries
from sessions.catalogue.engine import engine_to_look, open_engine
from sessions.catalogue.erasure import Erasure
from sessions.catalogue.people import People
from sessions.catalogue.sign_ins import SignIns
from sessions.catalogue.stations import Stations
from sessions.catalogue.takes import Takes
from sessions.catalogue.therapy import Therapy
from sessions.catalogue.trail import Trail
from sessions.errors import Refused

FILE = "clinic.sqlite3"


class Catalogue(
    People,
    SignIns,
    Takes,
    Choices,
    Therapy,
    Clinical,
    Book,
    Calibrations,
    Stations,
    Beginnings,
    Deliveries,
    Trail,
    Copying,
    Erasure,
):
    """People and what is known and written of them, takes, orders, sessions, cameras, stations, the audit."""

    @classmethod
    def open(cls, folder: Path, url: str = "", clock_ns: Callable[[], int] = time.time_ns) -> Catalogue:
        """Open the catalogue of a clinic folder, making or migrating it where needed.

        Args:
            folder: Clinic folder; it is made where it does not exist.
            url: SQLAlchemy URL; by default the SQLite file in the folder.
            clock_ns: UTC in ns.

        Raises:
            Refused: The folder or data base cannot be used.
        """
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise Refused(
                "clinic folder",
                f"not usable ({error.strerror})",
                "a folder that can be written",
                "choose another with --data",
            ) from error
        return cls(open_engine(url or f"sqlite:///{folder / FILE}"), clock_ns)

    @classmethod
    def look(cls, folder: Path, url: str = "") -> Catalogue | None:
        """The catalogue of a clinic folder as it is: nothing is made, nothing migrated.

        Args:
            folder: Clinic folder, which need not exist.
            url: SQLAlchemy URL; by default the SQLite file in the folder.

        Returns:
            The catalogue, None where there is none of this program's version.

        Raises:
            Refused: The data base cannot be used.
        """
        file = folder / FILE
        if not url and not file.is_file():
            return None
        engine = engine_to_look(url or f"sqlite:///{file}")
        return None if engine is None else cls(engine)

    def close(self) -> None:
        """Give back every connection."""
        self._engine.dispose()

    def __enter__(self) -> Catalogue:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
