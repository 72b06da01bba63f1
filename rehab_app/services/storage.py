"""Sealed files of a clinic folder: new names, copies that are whole or absent, digests."""

from __future__ import annotations

import hashlib
import os
import shutil
import time
import uuid
from pathlib import Path

from rehab_app.errors import Refused

SUFFIX = ".mcap"


def new_file(folder: Path) -> Path:
    """A name in ``folder`` that nothing has: UTC date and time, then eight random digits."""
    stamp = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime())
    return folder / f"{stamp}-{uuid.uuid4().hex[:8]}{SUFFIX}"


def check_out(out: Path | None) -> None:
    """Refuse an ``--out`` that cannot become a session file, before any work is done.

    Raises:
        Refused: It does not end in .mcap, exists already, or its folder does not exist.
    """
    if out is None:
        return
    if out.suffix != SUFFIX:
        raise Refused("--out", str(out), f"a file ending in {SUFFIX}", "give it that ending")
    if out.exists():
        raise Refused("--out", f"{out}, which is there already", "a new file", "choose another name")
    if not out.parent.is_dir():
        raise Refused("folder of --out", f"{out.parent}, which does not exist", "a folder", "make it first")


def copy_sealed(source: Path, target: Path, sha256: str) -> None:
    """Copy a sealed file with its digest beside it; the target is whole or absent.

    Args:
        source: Sealed file.
        target: New name.
        sha256: Digest of the source.

    Raises:
        Refused: The target is there already.
    """
    check_out(target)
    working = target.with_name(f".{target.name}.{uuid.uuid4().hex[:8]}")
    try:
        shutil.copyfile(source, working)
        os.replace(working, target)
    finally:
        working.unlink(missing_ok=True)
    digest_beside(target).write_text(f"{sha256}  {target.name}\n", encoding="utf-8")


def digest_beside(path: Path) -> Path:
    """Where the digest of a sealed file is noted."""
    return path.with_name(path.name + ".sha256")


def check_unchanged(thing: str, path: Path, sha256: str) -> None:
    """Refuse a sealed file that is not the one that was entered, also where it is whole in itself.

    Args:
        thing: What is named in the refusal.
        path: The file.
        sha256: Its digest when it was entered.

    Raises:
        Refused: Its digest differs.
    """
    met = digest(path)
    if met != sha256:
        raise Refused(thing, f"changed (SHA-256 {met[:12]})", sha256[:12], "restore it from a backup")


def digest(path: Path) -> str:
    """SHA-256 of a file's bytes, hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def is_path(named: str | Path) -> bool:
    """Whether a TAKE or SESSION is meant as a path rather than as an id."""
    path = Path(named)
    return bool(path.suffix) or path.parent != Path() or path.exists()
