"""Cases of a benchmark, done as `labrig batch` does its own: a killed process loses nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from labrig.batch import LocalPool, worked

T = TypeVar("T")
R = TypeVar("R")


def done(
    todo: Iterable[T], jobs: int, work: Callable[[T], R], lost: Callable[[T, BaseException], R]
) -> Iterator[R]:
    """Yield what `work` makes of cases as they are done, in `jobs` processes.

    `lost` answers for a case whose process was killed, or that raised, three times.
    """
    if jobs <= 1:
        yield from map(work, todo)
        return
    pool = LocalPool(jobs)
    try:
        for together in worked(todo, work, pool, lambda: pool.workers):
            for one in together:
                error = one.error
                yield lost(one.task, error) if error is not None else one.result
    finally:
        pool.kill()
