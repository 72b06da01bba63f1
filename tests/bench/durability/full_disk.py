"""Lets the disk be full at random places: one sentence, nothing sealed is altered, and later it goes on.

``python -m tests.bench.durability.full_disk --times 300`` takes minutes; the suite runs a few. The disk is
played by a bound on the size of every file (``RLIMIT_FSIZE``), which refuses a write as a full disk does.
"""

from __future__ import annotations

import argparse
import json
import mmap
import os
import resource
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path

import numpy as np

from rehab_app.errors import REFUSALS
from sessions.errors import Refused
from sessions.store import SessionWriter, partials, recover, verify

from .acts import ACTS, Act, make_pattern
from .recording import PERIOD_NS, Page, check_rows, header, name_of, record_for_ever, record_rows

_LONG_ROWS = 1000
LOSS_ROWS = 1_000_000_000 // PERIOD_NS
DONE, REFUSED, BROKEN = 0, 1, 2


def campaign(times: int, seed: int, folder: Path) -> dict[str, int]:
    """Fill the disk so often while recording, and so often in each act; how often it was met.

    Args:
        times: How often each.
        seed: Of the places.
        folder: An empty folder to work in.

    Raises:
        AssertionError: Something was harmed, was told in anything but one sentence, or did not go on.
    """
    rng = np.random.default_rng(seed)
    largest = _long_recording(folder / "long")
    met = sum(_recording(folder / "recordings", int(rng.integers(0, largest)), rng) for _ in range(times))
    figures = {"recording": met}
    pattern = folder / "pattern"
    make_pattern(pattern)
    for act in ACTS:
        figures[act.name] = _act(act, pattern, folder / "place", times, rng)
    return figures


def _long_recording(folder: Path) -> int:
    """Bytes of a session so long that one as long comes soon."""
    folder.mkdir()
    with SessionWriter(name_of(folder, 0), header(0)) as writer:
        record_rows(writer, 0, range(_LONG_ROWS))
        return writer.seal().bytes


def _recording(folder: Path, bound: int, rng: np.random.Generator) -> int:
    """Record until the disk is full; what was sealed stays, what was not is restored once there is room."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    page = Page(mmap.mmap(-1, mmap.PAGESIZE))
    page.tell(0, 0, 0)
    seed = int(rng.integers(2**31))
    assert strike(lambda: record_for_ever(folder, page, 0, seed), bound)
    number, rows, sealed = page.told
    for done in range(sealed):
        path = name_of(folder, done)
        verify(path)
        assert check_rows(path, done) > 0
    last = name_of(folder, number)
    left = [path for path in partials(folder) if path.name.startswith(last.stem)]
    if last.exists():  # refused after its last byte
        verify(last)
    elif left and not _restored(left[0], last, number, rows):
        assert rows <= LOSS_ROWS, f"{rows} rows are gone at {bound} bytes"
    return 1


def _restored(partial: Path, path: Path, number: int, rows: int) -> bool:
    try:
        recover(partial)
    except Refused:
        return False
    found = check_rows(path, number)
    assert rows - found <= LOSS_ROWS, f"{rows - found} of {rows} rows are gone"
    return True


def _act(act: Act, pattern: Path, place: Path, times: int, rng: np.random.Generator) -> int:
    """Meet a full disk in an act so often; afterwards there is room, and it is done again."""
    _anew(act, pattern, place)
    before = _sizes(place)
    said = strike(lambda: act.do(place), resource.RLIM_INFINITY)
    assert not said, f"{act.name}: {said}"
    after = _sizes(place)
    largest = max(size for path, size in after.items() if before.get(path) != size)
    met = 0
    for _ in range(times):
        _anew(act, pattern, place)
        met += bool(strike(lambda: act.do(place), int(rng.integers(0, largest))))
        act.check(pattern, place)
    return met


def _anew(act: Act, pattern: Path, place: Path) -> None:
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    act.prepare(pattern, place)


def _sizes(place: Path) -> dict[str, int]:
    return {str(path): path.stat().st_size for path in place.rglob("*") if path.is_file()}


def strike(do: Callable[[], None], bound_bytes: int) -> str:
    """Do something in a child none of whose files may outgrow a bound: the sentence of its refusal, or none.

    Args:
        do: What.
        bound_bytes: Largest size of a file that is written.

    Raises:
        AssertionError: It ended in anything but an end or a sentence.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        resource.setrlimit(resource.RLIMIT_FSIZE, (bound_bytes, resource.RLIM_INFINITY))
        outcome, said = BROKEN, ""
        try:
            do()
            outcome = DONE
        except REFUSALS as refusal:
            outcome, said = REFUSED, str(refusal)
        except Exception:
            said = traceback.format_exc()
            raise
        finally:
            os.write(writing, said.encode()[-4000:])
            os._exit(outcome)
    os.close(writing)
    with os.fdopen(reading) as told:
        said = told.read()
    outcome = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    assert outcome in (DONE, REFUSED), f"at {bound_bytes} bytes: {said}"
    assert outcome == DONE or (said.endswith(".") and "\n" not in said), said
    return said


def main() -> None:
    """Run a campaign and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    begun_s = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        figures = campaign(chosen.times, chosen.seed, Path(folder))
    sys.stdout.write(json.dumps(figures | {"wall_s": round(time.monotonic() - begun_s, 1)}) + "\n")


if __name__ == "__main__":
    main()
