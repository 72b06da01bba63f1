"""One holder at a time, among processes and within one; a lock dies with its process, however that ends."""

from __future__ import annotations

import select
import signal
import subprocess
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

import pytest

from sessions.filelock import FileLock, alone, is_locked, lock_open

HOLDER = """
import sys
from pathlib import Path
from sessions.filelock import FileLock
lock = FileLock(Path(sys.argv[1]))
print(lock.take(), flush=True)
sys.stdin.read()
"""


@contextmanager
def another(path: Path) -> Generator[subprocess.Popen[str]]:
    """Another process that took the lock."""
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "True\n"
        yield holder


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "one.lock"


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
def test_a_lock_is_one_processs_and_dies_with_it(path: Path, end: signal.Signals) -> None:
    mine = FileLock(path)
    with another(path) as holder:
        assert not mine.take()
        assert not mine.held
        assert is_locked(path)
        with alone(path) as free:
            assert not free
        holder.send_signal(end)
    assert not is_locked(path)
    assert mine.take()
    assert mine.held


def test_two_objects_of_one_process_exclude_each_other(path: Path) -> None:
    first, second = FileLock(path), FileLock(path)
    assert first.take()
    assert first.take(), "twice does no harm"
    assert not second.take()
    second.release()
    assert is_locked(path)
    first.release()
    first.release()
    assert second.take()


def test_who_waits_gets_it_when_it_is_free(path: Path) -> None:
    waiter = HOLDER.replace("print(lock.take()", "print('asks', flush=True)\nprint(lock.take(wait=True)")
    mine = FileLock(path)
    assert mine.take()
    with subprocess.Popen(
        [sys.executable, "-c", waiter, str(path)], bufsize=0, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as waiting:
        said = waiting.stdout
        assert said is not None
        assert said.readline() == b"asks\n"
        assert select.select([said], [], [], 0.3)[0] == []
        mine.release()
        assert said.readline() == b"True\n"


def test_a_child_does_not_keep_it(path: Path) -> None:
    with alone(path) as free:
        assert free
        child = subprocess.Popen(["sleep", "60"], close_fds=False)
    assert not is_locked(path)
    child.kill()
    child.wait()


def test_a_block_that_fails_gives_it_back(path: Path) -> None:
    with pytest.raises(KeyError), alone(path):
        raise KeyError
    assert not is_locked(path)


def test_the_holder_is_written_into_it(path: Path) -> None:
    lock = FileLock(path)
    assert lock.take()
    lock.write("a longer name")
    lock.write("name")
    assert path.read_text() == "name"
    assert path.stat().st_mode & 0o777 == 0o600


def test_to_look_makes_no_file_and_takes_nothing(path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        is_locked(path)
    assert not path.exists()
    with path.open("wb") as file:
        assert not is_locked(path)
        assert lock_open(file)
        assert is_locked(path)
    assert not is_locked(path)
