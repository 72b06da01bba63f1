"""What the disk was told to keep is kept: a power cut may tear only what came after the last settling."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import numpy as np
import pytest

from sessions.store import diskfile, partials, recover, verify
from sessions.store import writer as writing
from sessions.store.writer import SessionWriter
from tests.bench.durability.recording import check_rows, header, record_rows

NUMBER = 7


@pytest.fixture
def settled(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Sizes that the file had each time the disk was asked to keep it; it is asked often here."""
    sizes: list[int] = []
    keep = os.fdatasync

    def keeping(descriptor: int) -> None:
        size = os.fstat(descriptor).st_size  # what reached the system until now is what the disk keeps
        keep(descriptor)
        sizes.append(size)

    monkeypatch.setattr(diskfile.os, "fdatasync", keeping)
    monkeypatch.setattr(writing, "FLUSH_NS", 2_000_000)
    return sizes


def recorded(path: Path, settled: list[int], rows: int) -> bytes:
    """What lies in the file when the power goes: nothing is sealed."""
    enough = threading.Event()
    with SessionWriter(path, header(NUMBER)) as writer:
        for first in range(0, rows, 50):
            record_rows(writer, NUMBER, range(first, first + 50))
            enough.wait(0.004)  # lets the other thread settle now and then
    assert len(settled) > 5, "the recording was hardly ever settled"
    (partial,) = partials(path.parent)
    return partial.read_bytes()


@pytest.mark.parametrize("seed", range(6))
def test_a_power_cut_tears_only_what_was_not_settled(tmp_path, settled, seed):
    rng = np.random.default_rng(seed)
    whole = recorded(tmp_path / "whole.mcap", settled, 1500)
    durable = settled[int(rng.integers(len(settled) // 2, len(settled)))]
    rest = bytearray(whole[durable:][: int(rng.integers(1, 20_000))])
    if rng.integers(2):
        rest[:] = bytes(len(rest))  # blocks that were allocated and never written read as zeros
    else:
        for place in rng.integers(0, max(1, len(rest)), 40):
            rest[int(place) % len(rest)] ^= int(rng.integers(1, 256)) if rest else 0
    found = {}
    for name, content in (("cut", whole[:durable]), ("torn", whole[:durable] + bytes(rest))):
        path = tmp_path / f"{name}.partial.mcap"
        path.write_bytes(content)
        recover(path)
        sealed = tmp_path / f"{name}.mcap"
        verify(sealed)
        found[name] = check_rows(sealed, NUMBER, gaps=True)
    assert found["cut"] > 0
    assert found["torn"] >= found["cut"]


def test_nothing_has_its_final_name_before_the_disk_has_it(tmp_path, monkeypatch):
    order: list[str] = []
    sync, rename = os.fsync, Path.rename

    def syncing(descriptor: int) -> None:
        sync(descriptor)
        order.append("sync " + Path(os.readlink(f"/proc/self/fd/{descriptor}")).name)

    def renaming(path: Path, target: Path) -> Path:
        order.append("rename " + path.name)
        return rename(path, target)

    monkeypatch.setattr(diskfile.os, "fsync", syncing)
    monkeypatch.setattr(Path, "rename", renaming)
    with SessionWriter(tmp_path / "walk.mcap", header(NUMBER)) as writer:
        assert order == [f"sync {tmp_path.name}"], "the name of a growing file must outlive a power cut"
        record_rows(writer, NUMBER, range(10))
        writer.seal()
    assert order[1:] == [
        "sync walk.partial.mcap",
        "sync walk.mcap.sha256.new",
        "rename walk.partial.mcap",
        f"sync {tmp_path.name}",
    ]
