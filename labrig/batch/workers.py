"""Where the work is done: processes of this computer, or a Dask cluster."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from labrig.batch.pool import LocalPool
from labrig.errors import BadInputError, NotReadyError

_ANSWER_S = 20.0  # for a scheduler
_LOOK_EVERY_S = 5.0  # at how many workers a cluster has
_AHEAD = 2  # tasks handed over for each thread of a cluster: the next one waits where it is done


@dataclass(frozen=True)
class Workers:
    """An executor, how many tasks it may be given, and how to end what is under way."""

    executor: Executor
    places: Callable[[], int]
    kill: Callable[[], None]


@contextmanager
def local_workers(count: int) -> Iterator[Workers]:
    """Yield processes of this computer."""
    pool = LocalPool(count)
    try:
        yield Workers(pool, lambda: pool.workers, pool.kill)
    except BaseException:
        pool.kill()
        raise
    pool.shutdown()


@contextmanager
def cluster_workers(address: str) -> Iterator[Workers]:
    """Yield the workers of a Dask scheduler. Raises BadInputError, NotReadyError."""
    try:
        from distributed import Client
    except ImportError:
        raise BadInputError(
            "--scheduler needs Dask, which is not installed; pip install labrig[cluster]."
        ) from None
    try:
        client = Client(address, timeout=_ANSWER_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        told = " ".join(str(error).split()) or type(error).__name__
        raise NotReadyError(
            f"--scheduler {address}: no scheduler answers there ({told})."
        ) from None
    with client:
        # Each attempt is another task for Dask: what it lost it must not take for known.
        executor = client.get_executor(pure=False, retries=0)
        yield Workers(executor, _threads_of(client), lambda: executor.shutdown(wait=False))


def _threads_of(client: Any) -> Callable[[], int]:
    """Return how many tasks a cluster may have, which grows and shrinks; asked now and then."""
    known, asked_s = 1, -_LOOK_EVERY_S

    def places() -> int:
        nonlocal known, asked_s
        now_s = time.monotonic()
        if now_s - asked_s >= _LOOK_EVERY_S:
            asked_s = now_s
            known = max(1, _AHEAD * sum(client.nthreads().values()))
        return known

    return places
