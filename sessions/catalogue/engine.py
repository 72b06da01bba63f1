"""Opens the data base: SQLite tuned for one server and many threads, brought to the newest migration."""

from __future__ import annotations

from importlib import resources
from typing import Any

from alembic import command
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.exc import DBAPIError

from sessions.errors import Refused

BUSY_MS = 5000
WRITING = {"writing": True}
"""Execution option of transactions that write: they take SQLite's write lock at once, not half-way."""


def open_engine(url: str) -> Engine:
    """An engine whose data base has all tables.

    Args:
        url: SQLAlchemy URL, such as ``sqlite:////clinic/clinic.sqlite3``.

    Raises:
        Refused: The file is no data base, cannot be written, or was made by a newer version.
    """
    engine = create_engine(url)
    if engine.dialect.name == "sqlite":
        event.listen(engine, "connect", _tune_sqlite)
        event.listen(engine, "begin", _begin_sqlite)
    try:
        _migrate(engine)
    except DBAPIError as error:
        engine.dispose()
        raise Refused(
            "clinic data base",
            f"not usable ({error.orig})",
            "a data base that can be written and that is the clinic's own",
            "choose another folder with --data, or restore a backup",
        ) from error
    except Refused:
        engine.dispose()
        raise
    return engine


def _tune_sqlite(connection: Any, _record: object) -> None:
    """Readers beside one writer, references enforced, and patience instead of "database is locked"."""
    connection.isolation_level = None  # transactions begin where we say, see _begin_sqlite
    cursor = connection.cursor()
    cursor.execute(f"PRAGMA busy_timeout = {BUSY_MS}")
    cursor.execute("PRAGMA journal_mode = WAL")
    cursor.execute("PRAGMA foreign_keys = ON")
    cursor.execute("PRAGMA synchronous = FULL")
    cursor.close()


def _begin_sqlite(connection: Connection) -> None:
    writing = connection.get_execution_options().get("writing", False)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writing else "BEGIN")


def _migrate(engine: Engine) -> None:
    config = Config()
    with resources.as_file(resources.files("sessions.catalogue") / "migrations") as scripts:
        config.set_main_option("script_location", str(scripts).replace("%", "%%"))
        script = ScriptDirectory.from_config(config)
        with engine.connect() as connection:
            found = MigrationContext.configure(connection).get_current_revision()
        head = script.get_current_head()
        if found == head:
            return
        if found is not None and found not in {item.revision for item in script.walk_revisions()}:
            raise Refused(
                "clinic data base",
                f"at revision {found}",
                f"at most {head}",
                "open it with a newer rehab-app",
            )
        with engine.execution_options(**WRITING).begin() as connection:
            config.attributes["connection"] = connection
            command.upgrade(config, "head")
