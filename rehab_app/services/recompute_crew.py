"""Who measures: processes of this machine, or a Dask cluster by its address."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Generator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import connection
from typing import Any

from rehab_app.errors import Refused

_PATIENCE_S = 4
"""So long a scheduler may take to answer, and again its first worker to be there."""
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""A process for each core needs no threads within, and sums do not depend on their number."""
_NICE = 10
_WORK = "rehab_app.services.recompute_work"


@dataclass(frozen=True, slots=True)
class Crew:
    """Somebody to give work to.

    Attributes:
        executor: Takes the work.
        workers: How many files it measures at once.
    """

    executor: Executor
    workers: int


@contextmanager
def local_crew(workers: int) -> Generator[Crew]:
    """Processes of this machine, each with one thread; whoever breaks off ends them at once.

    Args:
        workers: How many, 0 for one per core.
    """
    count = workers or len(os.sched_getaffinity(0))
    before = {child.pid for child in multiprocessing.active_children()}
    kept = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ |= _ONE_THREAD  # read by numpy when a process is born
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([_WORK])  # one import for all of them; the server itself has no thread
    pool = ProcessPoolExecutor(count, context, initializer=_begin)
    whole = False
    try:
        yield Crew(pool, count)
        whole = True
    finally:
        if not whole:
            _end_children(before)
        pool.shutdown(wait=whole, cancel_futures=True)
        for name, value in kept.items():
            _set_back(name, value)


@contextmanager
def dask_crew(address: str) -> Generator[Crew]:
    """The workers of a Dask cluster, which need the clinic folder under the same path.

    Args:
        address: Of the scheduler, such as ``tcp://10.0.0.5:8786``.

    Raises:
        Refused: The extra is missing, the address is none, or no scheduler or worker answers.
    """
    client = _client(address)
    try:
        count = _threads(client, address)
        yield Crew(client.get_executor(), count)
    finally:
        client.close(timeout=_PATIENCE_S)


def _client(address: str) -> Any:
    try:
        distributed: Any = import_module("distributed")
    except ModuleNotFoundError as error:
        raise Refused(
            "scheduler", "given without the Dask client", "installed", "install the extra dask"
        ) from error
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        return distributed.Client(address, timeout=_PATIENCE_S, set_as_default=False)
    except (OSError, ValueError, TypeError, ImportError) as error:
        raise _unreachable(address, "no scheduler that answers") from error


def _threads(client: Any, address: str) -> int:
    """How many files the cluster measures at once."""
    try:
        client.wait_for_workers(1, timeout=_PATIENCE_S)
        return max(1, sum(client.nthreads().values()))
    except (OSError, TimeoutError) as error:
        client.close(timeout=_PATIENCE_S)
        raise _unreachable(address, "a scheduler without workers") from error


def _unreachable(address: str, value: str) -> Refused:
    return Refused(
        f"scheduler {address}",
        value,
        f"there with a worker within {_PATIENCE_S} s",
        "start it, correct the address, or leave it out to measure on this machine",
    )


def _begin() -> None:
    """What a process of the pool does first: yield to the server, leave Ctrl-C to its parent, end with it."""
    os.nice(_NICE)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)


def _end_children(before: set[int | None]) -> None:
    """End the processes that were born since."""
    for child in multiprocessing.active_children():
        if child.pid not in before:
            child.terminate()


def _set_back(name: str, value: str | None) -> None:
    if value is None:
        os.environ.pop(name, None)
    else:
        os.environ[name] = value
