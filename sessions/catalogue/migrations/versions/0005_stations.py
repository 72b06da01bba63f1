"""Stations of the clinic, and which of them a patient is in therapy at.

Revision ID: 0005
Revises: 0004
"""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the tables."""
    op.create_table(
        "stations",
        sa.Column("name", sa.String(63), nullable=False),
        sa.Column("holder", sa.String(32), nullable=False),
        sa.Column("version", sa.String(60), nullable=False),
        sa.Column("offset_ns", sa.BigInteger(), nullable=False),
        sa.Column("uncertainty_ns", sa.BigInteger(), nullable=False),
        sa.Column("seen_utc_ns", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("name", name=op.f("pk_stations")),
    )
    op.create_table(
        "patient_claims",
        sa.Column("patient", sa.String(20), nullable=False),
        sa.Column("station", sa.String(63), nullable=False),
        sa.Column("holder", sa.String(32), nullable=False),
        sa.Column("since_utc_ns", sa.BigInteger(), nullable=False),
        sa.Column("until_utc_ns", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("patient", name=op.f("pk_patient_claims")),
        sa.ForeignKeyConstraint(["patient"], ["patients.id"], name=op.f("fk_patient_claims_patient")),
    )


def downgrade() -> None:
    """Drop them again."""
    op.drop_table("patient_claims")
    op.drop_table("stations")
