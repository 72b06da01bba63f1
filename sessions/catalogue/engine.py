"""Opens the data base, SQLite or PostgreSQL, and brings it to the newest migration."""

from __future__ import annotations

from importlib import resources
from typing import Any

from alembic import command
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url
from sqlalchemy.exc import ArgumentError, DBAPIError

from sessions.errors import NoAnswer, Refused

BUSY_MS = 5000
WRITING = {"writing": True}
"""Execution option of transactions that write: they take the write lock at once, not half-way."""
_WRITE_LOCK = 0x72656861
"""Number of PostgreSQL's advisory lock that every writer of a clinic takes, as SQLite's writers do."""


def open_engine(url: str) -> Engine:
    """An engine whose data base has all tables.

    Args:
        url: SQLAlchemy URL, such as ``sqlite:////clinic/clinic.sqlite3``.

    Raises:
        Refused: The file is no data base, cannot be written, or was made by a newer version.
    """
    engine = _engine(_address(url))
    try:
        _migrate(engine)
    except DBAPIError as error:
        engine.dispose()
        raise unusable(engine.dialect.name, error) from error
    except Refused:
        engine.dispose()
        raise
    return engine


def engine_to_look(url: str) -> Engine | None:
    """An engine for looking only: nothing is made and nothing migrated.

    Args:
        url: SQLAlchemy URL of a data base that exists.

    Returns:
        The engine; None where the data base is of another version, or has no tables yet.

    Raises:
        Refused: The data base cannot be used.
    """
    engine = _engine(_address(url))
    try:
        with engine.connect() as connection:
            found = MigrationContext.configure(connection).get_current_revision()
    except DBAPIError as error:
        engine.dispose()
        raise unusable(engine.dialect.name, error) from error
    if found != _newest():
        engine.dispose()
        return None
    return engine


def _newest() -> str | None:
    """The revision that this program brings a data base to."""
    config = Config()
    with resources.as_file(resources.files("sessions.catalogue") / "migrations") as scripts:
        config.set_main_option("script_location", str(scripts).replace("%", "%%"))
        return ScriptDirectory.from_config(config).get_current_head()


def unusable(engine: str, error: DBAPIError) -> Refused:
    """Why the data base cannot be used, in one sentence.

    Args:
        engine: Name of the engine.
        error: What it said.
    """
    said = " ".join(str(error.orig).split()) or type(error.orig).__name__
    if engine == "sqlite":
        return Refused(
            "clinic data base",
            f"not usable ({said})",
            "a data base that can be written and that is the clinic's own",
            "choose another folder with --data, or restore a backup",
        )
    return NoAnswer(
        "clinic data base",
        f"not answering ({said[:300]})",
        "a PostgreSQL server that can be reached and signed in to",
        "check the server, the network and catalogue_url, and try again: nothing was half written",
    )


def _address(url: str) -> URL:
    try:
        parsed = make_url(url)
    except ArgumentError as error:
        raise _no_address(repr(url.partition(":")[0][:20])) from error
    if parsed.drivername not in ("sqlite", "postgresql", "postgresql+psycopg"):
        raise _no_address(repr(parsed.drivername[:20]))
    return parsed.set(drivername="postgresql+psycopg") if parsed.drivername == "postgresql" else parsed


def _no_address(kind: str) -> Refused:
    bound = "sqlite:///FILE or postgresql://USER:PASSWORD@HOST/NAME"
    return Refused("catalogue_url", f"of kind {kind}", bound, "correct it, or leave it out")


def _engine(address: URL) -> Engine:
    if address.get_backend_name() == "sqlite":
        engine = create_engine(address)
        event.listen(engine, "connect", _tune_sqlite)
        event.listen(engine, "begin", _begin_sqlite)
        return engine
    try:
        from sessions.catalogue.patience import LOCK_MS, asked_of_server, be_patient

        engine = create_engine(
            address, pool_pre_ping=True, pool_timeout=LOCK_MS / 1000, connect_args=asked_of_server()
        )
    except ModuleNotFoundError as error:
        extra = "the extra 'postgres'"
        raise Refused(
            "PostgreSQL", "without its driver", extra, "pip install 'rehab-app[postgres]'"
        ) from error
    be_patient(engine)
    event.listen(engine, "begin", _begin_postgresql)
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


def _begin_postgresql(connection: Connection) -> None:
    """One writer at a time: numbers, versions and the audit chain are read and written in one transaction."""
    from sessions.catalogue.patience import wait_as_asked

    options = connection.get_execution_options()
    wait_as_asked(connection.connection.driver_connection, options.get("migrating", False))
    if options.get("writing", False):
        connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({_WRITE_LOCK})")


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
        with engine.execution_options(**WRITING, migrating=True).begin() as connection:
            if MigrationContext.configure(connection).get_current_revision() == head:
                return  # another station was first
            config.attributes["connection"] = connection
            command.upgrade(config, "head")
