"""Who was erased, as digests: older backups still hold them, so the list is kept beside backups too."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

LEDGER = "erased.txt"


def line_of(patient: str, created_utc_ns: int) -> str:
    """One line: it tells a patient again and says nothing about them.

    Args:
        patient: Pseudonym.
        created_utc_ns: When the patient was added.
    """
    return hashlib.sha256(f"{patient} {created_utc_ns}".encode()).hexdigest()


def ledger(path: Path) -> tuple[str, ...]:
    """Lines of a ledger of erased patients; none where there is no such file."""
    try:
        return tuple(line for line in path.read_text(encoding="utf-8").splitlines() if line.strip())
    except FileNotFoundError:
        return ()


def add_to_ledger(path: Path, lines: tuple[str, ...]) -> None:
    """Add what a ledger lacks; the file is replaced whole."""
    kept = ledger(path)
    missing = [line for line in lines if line not in kept]
    if not missing:
        return
    working = path.with_name(f".{path.name}.part")
    working.write_text("\n".join((*kept, *missing)) + "\n", encoding="utf-8")
    os.replace(working, path)
