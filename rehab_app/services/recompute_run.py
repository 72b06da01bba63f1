"""Giving work to a crew and taking the answers as they come; one bad file stops none of the others."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from contextlib import AbstractContextManager
from dataclasses import dataclass, field

from rehab_app.errors import Refused
from rehab_app.services.recompute_crew import Crew
from rehab_app.services.recompute_work import Measured, Work, measured, not_measured

_AHEAD = 2
"""So many files per worker are given out, so that none waits; only these are lost to whoever breaks off."""


@dataclass(slots=True)
class _Table:
    """What is to be done: ``suspects`` were given out when a process died, and go again one by one."""

    waiting: deque[Work]
    suspects: deque[Work] = field(default_factory=deque[Work])
    flying: dict[Future[Measured], Work] = field(default_factory=dict[Future[Measured], Work])

    def open(self) -> bool:
        return bool(self.waiting or self.suspects or self.flying)


def measure_with(
    works: Sequence[Work], hire: Callable[[], AbstractContextManager[Crew]]
) -> Generator[Measured]:
    """Measure every file, in the order in which they get done.

    Args:
        works: What is to be measured.
        hire: Gives a crew; asked again where a process of the first one died.

    Raises:
        Refused: No crew is to be had, or the cluster was lost on the way.
    """
    table = _Table(deque(works))
    while table.open():
        with hire() as crew:
            yield from _until_broken(crew, table)


def _until_broken(crew: Crew, table: _Table) -> Generator[Measured]:
    """Answers until all are there, or a process of the crew died."""
    while table.open():
        if not _give_out(crew, table):
            break
        done, _ = wait(table.flying, return_when=FIRST_COMPLETED)
        broken = False
        for future in done:
            if _died(future):
                broken = True
            else:
                yield _answer(future, table.flying.pop(future))
        if broken:
            break
    if len(table.flying) == 1:
        _, work = table.flying.popitem()
        yield not_measured(work, "its process died while it was measured")
    table.suspects.extend(table.flying.values())
    table.flying.clear()


def _give_out(crew: Crew, table: _Table) -> bool:
    """Keep the crew busy; suspects only one at a time. False where the crew takes nothing any more."""
    source, most = (table.suspects, 1) if table.suspects else (table.waiting, _AHEAD * crew.workers)
    while source and len(table.flying) < most:
        work = source.popleft()
        try:
            table.flying[crew.executor.submit(measured, work)] = work
        except BrokenExecutor:
            source.appendleft(work)
            return False
    return True


def _died(future: Future[Measured]) -> bool:
    return not future.cancelled() and isinstance(future.exception(), BrokenExecutor)


def _answer(future: Future[Measured], work: Work) -> Measured:
    if future.cancelled():
        raise Refused(
            "scheduler", "lost while measuring", "there to the end", "run it again: what was done is kept"
        )
    problem = future.exception()
    if problem is None:
        return future.result()
    return not_measured(work, f"it could not be measured ({type(problem).__name__})")
