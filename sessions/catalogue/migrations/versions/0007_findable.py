"""What lists and searches read of a patient, and an index under every question that a page asks.

Revision ID: 0007
Revises: 0006
"""

import sqlalchemy as sa
from alembic import op

from sessions.catalogue.search import CODE_POINTS, sorted_name, sought_text

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None

_INDEXES = (
    ("takes", "subject_id"),
    ("takes", "parent"),
    ("prescriptions", "take"),
    ("therapy_sessions", "take"),
    ("therapy_sessions", "started_utc_ns"),
    ("patient_entries", "session"),
    ("audit", "subject"),
)
_BY_NAME = "ix_patients_archived_sorted_name"


def upgrade() -> None:
    """Add the columns, fill them, then make the indexes."""
    for name, kind in (("sorted_name", _sorted_text()), ("sought", sa.Text())):
        op.add_column("patients", sa.Column(name, kind, nullable=False, server_default=""))
    _fill()
    op.create_index(_BY_NAME, "patients", ["archived", "sorted_name", "number"])
    for table, column in _INDEXES:
        op.create_index(op.f(f"ix_{table}_{column}"), table, [column])


def downgrade() -> None:
    """Drop them again."""
    for table, column in reversed(_INDEXES):
        op.drop_index(op.f(f"ix_{table}_{column}"), table)
    op.drop_index(_BY_NAME, "patients")
    with op.batch_alter_table("patients") as batch:
        for name in ("sought", "sorted_name"):
            batch.drop_column(name)


def _sorted_text() -> sa.Text:
    if op.get_bind().dialect.name == "postgresql":
        return sa.Text(collation=CODE_POINTS)
    return sa.Text()


def _fill() -> None:
    """The folded texts of everybody who is there already."""
    patients = sa.table(
        "patients",
        *(sa.column(name) for name in ("number", "id", "given_name", "family_name", "birth_date")),
        sa.column("sorted_name"),
        sa.column("sought"),
    )
    connection, names = op.get_bind(), patients.c
    asked = sa.select(names.number, names.given_name, names.family_name, names.birth_date, names.id)
    folded = [
        {"at": number, "sorted": sorted_name(given, family), "text": sought_text(given, family, born, one)}
        for number, given, family, born, one in connection.execute(asked)
    ]
    if folded:
        change = patients.update().where(names.number == sa.bindparam("at"))
        values = {"sorted_name": sa.bindparam("sorted"), "sought": sa.bindparam("text")}
        connection.execute(change.values(values), folded)
