"""Alembic migrations of the catalogue; they run when it is opened."""
