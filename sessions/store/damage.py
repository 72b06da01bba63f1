"""How bytes that do not follow their format are reported inside the store."""

from __future__ import annotations


class Damaged(Exception):
    """Bytes break the format. Never leaves the store: its callers turn it into a ``Refused`` sentence."""
