"""Moves a clinic's catalogue to another data base, and proves by counts and digests that nothing was lost."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any, TypeAlias

import msgspec
from sqlalchemy import Connection, func, insert, select, text
from sqlalchemy import Table as AnyTable
from sqlalchemy.exc import DataError, IntegrityError, OperationalError

from sessions.catalogue.engine import WRITING, open_engine, unusable
from sessions.catalogue.ledger import Ledger
from sessions.catalogue.tables import Table
from sessions.errors import Refused

_AT_ONCE = 1000
_Values: TypeAlias = dict[str, Any]


@dataclass(frozen=True, slots=True)
class MovedTable:
    """One table that was moved.

    Attributes:
        name: Its name.
        rows: How many rows it has, here and there.
        sha256: Digest over every value of every row, in order, here and there.
    """

    name: str
    rows: int
    sha256: str


class Moving(Ledger):
    """Moves the data base."""

    def move_to(self, url: str) -> tuple[MovedTable, ...]:
        """Copy every row into an empty data base; all of it arrives in one transaction, or nothing.

        This catalogue stays as it is. Nobody may write to it meanwhile.

        Args:
            url: Address of the new data base, which has no rows.

        Returns:
            Each table, in the order moved; its digest was computed on both sides and is the same.

        Raises:
            Refused: The new data base cannot be used, is not empty, or what arrived differs.
        """
        target = open_engine(url)
        try:
            with self._as_of_now() as here, target.execution_options(**WRITING).begin() as there:
                _refuse_filled(there)
                return tuple(_moved(table, here, there) for table in Table.metadata.sorted_tables)
        except OperationalError as error:
            raise unusable(target.dialect.name, error) from error
        except (DataError, IntegrityError) as error:
            said = " ".join(str(error.orig).split())[:200]
            remedy = "correct that row here and move again: nothing has arrived yet"
            raise Refused(
                "a row of the catalogue", f"not accepted ({said})", "as its table wants it", remedy
            ) from error
        finally:
            target.dispose()

    def _as_of_now(self) -> Connection:
        """A connection that sees the data base as it is at one instant; SQLite's always do."""
        if self._engine.dialect.name == "sqlite":
            return self._engine.connect()
        return self._engine.connect().execution_options(isolation_level="REPEATABLE READ")


def _refuse_filled(there: Connection) -> None:
    for table in Table.metadata.sorted_tables:
        if there.execute(select(func.count()).select_from(table)).scalar_one():
            raise Refused(
                "new data base",
                f"with rows in {table.name}",
                "empty: a clinic is never mixed into another",
                "name an empty data base with --to",
            )


def _moved(table: AnyTable, here: Connection, there: Connection) -> MovedTable:
    rows = _rows(table, here)
    values = _parents_first(table, rows)
    for start in range(0, len(values), _AT_ONCE):
        there.execute(insert(table), values[start : start + _AT_ONCE])
    _count_on(table, there)
    before, after = _digest(rows), _digest(_rows(table, there))
    if before != after:
        raise Refused(
            f"table {table.name}",
            "another there than here",
            "the same on both sides",
            "try another data base",
        )
    return MovedTable(table.name, len(rows), before)


def _rows(table: AnyTable, connection: Connection) -> list[_Values]:
    return [dict(row) for row in connection.execute(select(table)).mappings()]


def _parents_first(table: AnyTable, rows: list[_Values]) -> list[_Values]:
    """Rows that refer to others of their table stand behind those."""
    own = [key for key in table.foreign_keys if key.column.table is table]
    if not own:
        return rows
    ordered, known, waiting = list[_Values](), set[Any](), rows
    while waiting:
        ready = [row for row in waiting if all(row[key.parent.name] in {None, *known} for key in own)]
        ordered += ready
        known |= {row[key.column.name] for row in ready for key in own}
        waiting = [row for row in waiting if row not in ready] if ready else []
    return ordered


def _count_on(table: AnyTable, there: Connection) -> None:
    """Numbers that the data base gives go on behind those that were moved."""
    column = table.autoincrement_column
    if there.dialect.name != "postgresql" or column is None:
        return
    highest = there.execute(select(func.coalesce(func.max(column), 0))).scalar_one()
    if highest:
        named = {"table": table.name, "column": column.name, "highest": highest}
        there.execute(text("SELECT setval(pg_get_serial_sequence(:table, :column), :highest)"), named)


def _digest(rows: list[_Values]) -> str:
    found = hashlib.sha256()
    for row in sorted(msgspec.json.encode(row) for row in rows):
        found.update(row)
    return found.hexdigest()
