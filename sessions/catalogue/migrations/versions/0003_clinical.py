"""Clinical records, unlocked modes, limits, fit checks, memory, retouched takes, runs without a take.

Revision ID: 0003
Revises: 0002
"""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the columns, then make the tables."""
    for table, columns in _COLUMNS.items():
        for name, kind in columns:
            op.add_column(table, sa.Column(name, kind, nullable=False, server_default=""))
    with op.batch_alter_table("therapy_sessions") as batch:
        batch.alter_column("take", existing_type=sa.String(64), nullable=True)
    _records()
    _limits()
    _memories()
    _fits()


def downgrade() -> None:
    """Drop them again. Runs without a take cannot be kept."""
    for table in (
        "fit_checks",
        "assistance_memories",
        "limit_changes",
        "day_limits",
        "mode_unlocks",
        "clinical_records",
    ):
        op.drop_table(table)
    op.execute("DELETE FROM therapy_sessions WHERE take IS NULL")
    with op.batch_alter_table("therapy_sessions") as batch:
        batch.alter_column("take", existing_type=sa.String(64), nullable=False)
    for table, columns in _COLUMNS.items():
        with op.batch_alter_table(table) as batch:
            for name, _ in columns:
                batch.drop_column(name)


_COLUMNS = {
    "takes": (("author", sa.String(120)), ("reason", sa.Text()), ("retouch", sa.Text())),
    "prescriptions": (("content", sa.Text()), ("by", sa.String(120))),
}


def _records() -> None:
    op.create_table(
        "clinical_records",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("patient", sa.String(20), nullable=False),
        sa.Column("diagnosis", sa.String(60), nullable=False),
        sa.Column("event_date", sa.String(10), nullable=False),
        sa.Column("mas", sa.String(2), nullable=False),
        sa.Column("insensate", sa.Boolean(), nullable=False),
        sa.Column("unaware", sa.Boolean(), nullable=False),
        sa.Column("rheumatoid", sa.Boolean(), nullable=False),
        sa.Column("crps", sa.Boolean(), nullable=False),
        sa.Column("hyperextension_allowed", sa.Boolean(), nullable=False),
        sa.Column("bones_m", sa.Text(), nullable=False),
        sa.Column("by", sa.String(120), nullable=False),
        sa.Column("created_utc_ns", sa.BigInteger(), nullable=False),
        *_of_a_patient("clinical_records"),
    )
    op.create_index(op.f("ix_clinical_records_patient"), "clinical_records", ["patient"])
    op.create_table(
        "mode_unlocks",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("patient", sa.String(20), nullable=False),
        sa.Column("mode", sa.String(20), nullable=False),
        sa.Column("diagnosis", sa.String(60), nullable=False),
        sa.Column("event_date", sa.String(10), nullable=False),
        sa.Column("unlocked", sa.Boolean(), nullable=False),
        sa.Column("reason", sa.Text(), nullable=False),
        sa.Column("by", sa.String(120), nullable=False),
        sa.Column("created_utc_ns", sa.BigInteger(), nullable=False),
        *_of_a_patient("mode_unlocks"),
    )
    op.create_index(op.f("ix_mode_unlocks_patient"), "mode_unlocks", ["patient"])


def _limits() -> None:
    op.create_table(
        "day_limits",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("patient", sa.String(20), nullable=False),
        sa.Column("side", sa.String(5), nullable=False),
        sa.Column("device", sa.String(120), nullable=False),
        sa.Column("wrist_rad", sa.Double(), nullable=False),
        sa.Column("content", sa.Text(), nullable=False),
        sa.Column("measured_utc_ns", sa.BigInteger(), nullable=False),
        sa.Column("expires_utc_ns", sa.BigInteger(), nullable=False),
        sa.Column("by", sa.String(120), nullable=False),
        *_of_a_patient("day_limits"),
    )
    op.create_index(op.f("ix_day_limits_patient"), "day_limits", ["patient"])
    op.create_table(
        "limit_changes",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("patient", sa.String(20), nullable=False),
        sa.Column("device", sa.String(120), nullable=False),
        sa.Column("joint", sa.String(40), nullable=False),
        sa.Column("limit", sa.String(30), nullable=False),
        sa.Column("value", sa.Double(), nullable=False),
        sa.Column("expires_utc_ns", sa.BigInteger(), nullable=False),
        sa.Column("reason", sa.Text(), nullable=False),
        sa.Column("by", sa.String(120), nullable=False),
        sa.Column("created_utc_ns", sa.BigInteger(), nullable=False),
        *_of_a_patient("limit_changes"),
    )
    op.create_index(op.f("ix_limit_changes_patient"), "limit_changes", ["patient"])


def _memories() -> None:
    table = "assistance_memories"
    op.create_table(
        table,
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("patient", sa.String(20), nullable=False),
        sa.Column("exercise", sa.String(120), nullable=False),
        sa.Column("device", sa.String(120), nullable=False),
        sa.Column("content", sa.Text(), nullable=False),
        sa.Column("session", sa.String(64), nullable=False),
        sa.Column("created_utc_ns", sa.BigInteger(), nullable=False),
        *_of_a_patient(table),
        sa.ForeignKeyConstraint(["session"], ["therapy_sessions.id"], name=op.f(f"fk_{table}_session")),
    )
    op.create_index(op.f(f"ix_{table}_patient"), table, ["patient"])


def _fits() -> None:
    table = "fit_checks"
    op.create_table(
        table,
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("patient", sa.String(20), nullable=False),
        sa.Column("side", sa.String(5), nullable=False),
        sa.Column("device", sa.String(120), nullable=False),
        sa.Column("content", sa.Text(), nullable=False),
        sa.Column("verdict", sa.Text(), nullable=False),
        sa.Column("session", sa.String(64), nullable=False),
        sa.Column("by", sa.String(120), nullable=False),
        sa.Column("created_utc_ns", sa.BigInteger(), nullable=False),
        *_of_a_patient(table),
        sa.ForeignKeyConstraint(["session"], ["therapy_sessions.id"], name=op.f(f"fk_{table}_session")),
    )
    op.create_index(op.f(f"ix_{table}_patient"), table, ["patient"])


def _of_a_patient(table: str) -> tuple[sa.Constraint, sa.Constraint]:
    return (
        sa.ForeignKeyConstraint(["patient"], ["patients.id"], name=op.f(f"fk_{table}_patient")),
        sa.PrimaryKeyConstraint("id", name=op.f(f"pk_{table}")),
    )
