"""Tasks worked off by processes that may be killed."""

from __future__ import annotations

import signal
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Protocol, TypeVar

LIVES = 3  # pools that may die with a task under way


class _Keyed(Protocol):
    @property
    def key(self) -> str: ...


T = TypeVar("T", bound=_Keyed)
R = TypeVar("R")


def worked(
    todo: Sequence[T], jobs: int, work: Callable[[T], R], lost: Callable[[T], R]
) -> Iterator[R]:
    """Yield what `work` makes of tasks as they are done, in `jobs` processes.

    Where a process is killed (by the system when memory is short, say) the tasks that were under
    way are given to a new pool; for one that was under way `LIVES` times `lost` answers.
    """
    if jobs <= 1:
        yield from map(work, todo)
        return
    rest, deaths = list(reversed(todo)), Counter[str]()
    while rest:
        gone = yield from _pooled(rest, jobs, work)
        deaths.update(task.key for task in gone)
        for task in reversed(gone):
            if deaths[task.key] < LIVES:
                rest.append(task)
            else:
                yield lost(task)


def _pooled(rest: list[T], jobs: int, work: Callable[[T], R]) -> Generator[R, None, list[T]]:
    """Work off a list from its end, in one pool; the tasks that it took with it when it died."""
    waiting: dict[Future[R], T] = {}
    with ProcessPoolExecutor(jobs, get_context("spawn"), _undisturbed) as pool:
        try:
            while rest or waiting:
                while rest and len(waiting) < jobs:
                    waiting[pool.submit(work, rest[-1])] = rest[-1]
                    rest.pop()
                for one in wait(waiting, return_when=FIRST_COMPLETED).done:
                    found = one.result()
                    del waiting[one]
                    yield found
        except BrokenProcessPool:
            return list(waiting.values())
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
    return []


def _undisturbed() -> None:
    """Ctrl-C is for the process that keeps the records."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
