"""Versions of patients, what is written about them, sign-ins, settings, cached metrics.

Revision ID: 0004
Revises: 0003
"""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the column, then make the tables."""
    op.add_column("patients", sa.Column("version", sa.Integer(), nullable=False, server_default="1"))
    _entries()
    op.create_table(
        "sign_ins",
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("user", sa.String(120), nullable=False),
        sa.Column("issued_utc_ns", sa.BigInteger(), nullable=False),
        sa.Column("seen_utc_ns", sa.BigInteger(), nullable=False),
        sa.Column("ended_utc_ns", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_sign_ins")),
    )
    op.create_index(op.f("ix_sign_ins_user"), "sign_ins", ["user"])
    op.create_table(
        "settings",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("key", sa.String(60), nullable=False),
        sa.Column("content", sa.Text(), nullable=False),
        sa.Column("by", sa.String(120), nullable=False),
        sa.Column("created_utc_ns", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_settings")),
    )
    op.create_index(op.f("ix_settings_key"), "settings", ["key"])
    op.create_table(
        "metric_sets",
        sa.Column("sha256", sa.String(64), nullable=False),
        sa.Column("version", sa.String(64), nullable=False),
        sa.Column("content", sa.Text(), nullable=False),
        sa.Column("created_utc_ns", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("sha256", "version", name=op.f("pk_metric_sets")),
    )


def downgrade() -> None:
    """Drop them again."""
    for table in ("metric_sets", "settings", "sign_ins", "patient_entries"):
        op.drop_table(table)
    with op.batch_alter_table("patients") as batch:
        batch.drop_column("version")


def _entries() -> None:
    op.create_table(
        "patient_entries",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("patient", sa.String(20), nullable=False),
        sa.Column("kind", sa.String(30), nullable=False),
        sa.Column("topic", sa.String(60), nullable=False),
        sa.Column("session", sa.String(64), nullable=True),
        sa.Column("content", sa.Text(), nullable=False),
        sa.Column("by", sa.String(120), nullable=False),
        sa.Column("created_utc_ns", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_patient_entries")),
        sa.ForeignKeyConstraint(["patient"], ["patients.id"], name=op.f("fk_patient_entries_patient")),
        sa.ForeignKeyConstraint(
            ["session"], ["therapy_sessions.id"], name=op.f("fk_patient_entries_session")
        ),
    )
    op.create_index("ix_patient_entries_patient_kind", "patient_entries", ["patient", "kind"])
