"""Kills a recording at random moments, again and again: nothing sealed may change, and a second may be lost.

``python -m tests.bench.durability.kills --kills 1000`` takes minutes; the suite runs twenty.
"""

from __future__ import annotations

import argparse
import json
import mmap
import os
import signal
import sys
import tempfile
import time
import traceback
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from sessions.errors import Refused
from sessions.store import partials, recover, verify

from .recording import PERIOD_NS, Page, check_rows, name_of, record_for_ever

LOSS_NS = 1_000_000_000


@dataclass(slots=True)
class Tally:
    """What a campaign met.

    Attributes:
        kills: Recordings killed.
        sealed: Sessions that were sealed before the kill.
        recovered: Sessions that were restored after it.
        finished: Sessions killed in the last step of sealing.
        nothing_written: Kills before anything was written that could be lost.
        worst_loss_s: The longest end that was lost, session time.
        digests: Digest of every sealed file by name.
    """

    kills: int = 0
    sealed: int = 0
    recovered: int = 0
    finished: int = 0
    nothing_written: int = 0
    worst_loss_s: float = 0.0
    digests: dict[str, str] = field(default_factory=dict[str, str])


def campaign(folder: Path, kills: int, seed: int) -> Tally:
    """Kill so many recordings and check after each.

    Args:
        folder: Where sessions are written.
        kills: How many.
        seed: Of the moments and lengths.

    Raises:
        AssertionError: A sealed session was harmed, or more than a second was lost.
    """
    rng, tally, first = np.random.default_rng(seed), Tally(), 0
    page = Page(mmap.mmap(-1, mmap.PAGESIZE))
    for _ in range(kills):
        page.tell(first, 0, 0)
        _killed(folder, page, first, rng)
        number, rows, _ = page.told
        _check(folder, range(first, number + 1), rows, tally)
        tally.kills += 1
        first = number + 1
    for name, digest in tally.digests.items():
        assert verify(folder / name).sha256 == digest, f"{name} was altered"
    return tally


def _killed(folder: Path, page: Page, first: int, rng: np.random.Generator) -> None:
    """Fork a recording and kill it after a random time; half of the kills wait for a moment near a seal."""
    seed, wait_s, near_seal = int(rng.integers(2**31)), float(rng.exponential(0.08)), bool(rng.integers(2))
    child = os.fork()
    if child == 0:
        try:
            record_for_ever(folder, page, first, seed)
        except Exception:
            traceback.print_exc()
            raise
        finally:
            os._exit(1)
    until_s = time.monotonic() + 20.0
    while near_seal and page.told[2] == 0 and time.monotonic() < until_s:
        time.sleep(0.0002)
    time.sleep(wait_s * (0.02 if near_seal else 1.0))
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    assert os.WIFSIGNALED(status), "the recording ended by itself"


def _check(folder: Path, numbers: range, rows: int, tally: Tally) -> None:
    for number in numbers:
        path = name_of(folder, number)
        was_sealed = path.exists()
        left = [one for one in partials(folder) if one.name.startswith(path.stem)]
        if not was_sealed and not _restored(path, left, rows, tally):
            continue
        proof = verify(path)
        assert proof.digest_noted, f"{path.name} lacks its digest"
        found = check_rows(path, number)
        if was_sealed:
            tally.sealed += 1
        else:
            lost_s = (rows - found) * PERIOD_NS / 1e9
            assert lost_s <= LOSS_NS / 1e9, f"{path.name} lost {lost_s:.2f} s"
            tally.worst_loss_s = max(tally.worst_loss_s, lost_s)
        tally.digests[path.name] = proof.sha256
    for one in partials(folder):
        one.unlink()  # restored by now, as a start of the server would


def _restored(path: Path, left: list[Path], rows: int, tally: Tally) -> bool:
    """Whether a killed session was restored; a file that never got its first bytes held nothing."""
    if not left or left[0].stat().st_size == 0:
        assert rows * PERIOD_NS <= LOSS_NS, f"{path.name} is gone with {rows} rows"
        tally.nothing_written += 1
        return False
    try:
        recover(left[0])
    except Refused:
        assert rows * PERIOD_NS <= LOSS_NS, f"{path.name} cannot be restored"
        tally.nothing_written += 1
        return False
    if left[0].exists():
        tally.recovered += 1
    else:
        tally.finished += 1
    return True


def main() -> None:
    """Run a campaign and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    begun_s = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        figures = asdict(campaign(Path(folder), chosen.kills, chosen.seed))
    figures["digests"] = len(figures["digests"])
    sys.stdout.write(json.dumps(figures | {"wall_s": round(time.monotonic() - begun_s, 1)}) + "\n")


if __name__ == "__main__":
    main()
