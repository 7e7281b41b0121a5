"""The loop that has tasks done by an executor: each ends once, whatever happens to the workers.

Any `concurrent.futures.Executor` will do: `LocalPool`, Dask's, a pool of threads. A task whose
worker was lost is given to another one, up to `ATTEMPTS` times in all. No more tasks are handed
over than there are places, so that a kill costs little and memory does not grow with the batch.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from dataclasses import dataclass
from typing import Generic, TypeVar

from labrig.errors import LabrigError

T = TypeVar("T")
R = TypeVar("R")
ATTEMPTS = 3


@dataclass(frozen=True, kw_only=True)
class Ended(Generic[T, R]):
    """A task that has ended: with a result, or with why there is none."""

    task: T
    result: R | None = None
    error: BaseException | None = None  # of the last attempt; None: there is a result
    attempts: int = 1


def worked(
    todo: Iterable[T],
    work: Callable[[T], R],
    executor: Executor,
    places: Callable[[], int],
    *,
    attempts: int = ATTEMPTS,
    again: Callable[[R], bool] = lambda _: False,
) -> Iterator[list[Ended[T, R]]]:
    """Yield tasks as they end, those that ended together in one list.

    `places`: how many tasks may be under way. `again` says of a result whether another attempt is
    worth it. Raises LabrigError where the executor takes no more tasks. Closing the iterator gives
    up what is not under way yet.
    """
    waiting: dict[Future[R], _Try[T]] = {}
    rest = _Remaining(iter(todo))
    try:
        while True:
            for one in rest.up_to(max(1, places()) - len(waiting)):
                waiting[_submitted(executor, work, one.task)] = one
            if not waiting:
                return
            ended = []
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                one = waiting.pop(future)
                found = _end_of(future, one)
                hopeless = one.number >= attempts
                retry = found.error is not None or again(_sure(found))
                if retry and not hopeless:
                    rest.once_more(one)
                else:
                    ended.append(found)
            if ended:
                yield ended
    finally:
        for future in waiting:
            future.cancel()


@dataclass(frozen=True)
class _Try(Generic[T]):
    task: T
    number: int  # from 1


class _Remaining(Generic[T]):
    """What is to be done: what is tried again comes last.

    What kills workers now may be over then: another program that takes the memory, say.
    """

    def __init__(self, todo: Iterator[T]) -> None:
        self._todo = todo
        self._again: deque[_Try[T]] = deque()

    def once_more(self, one: _Try[T]) -> None:
        self._again.append(_Try(one.task, one.number + 1))

    def up_to(self, count: int) -> Generator[_Try[T], None, None]:
        for _ in range(count):
            for task in self._todo:
                yield _Try(task, 1)
                break
            else:
                if not self._again:
                    return
                yield self._again.popleft()


def _submitted(executor: Executor, work: Callable[[T], R], task: T) -> Future[R]:
    try:
        return executor.submit(work, task)
    except Exception as error:
        raise LabrigError(
            f"no worker takes another task ({type(error).__name__}: {error}); what has ended is"
            " kept, and the same command goes on."
        ) from error


def _end_of(future: Future[R], one: _Try[T]) -> Ended[T, R]:
    try:
        return Ended(task=one.task, result=future.result(), attempts=one.number)
    except (Exception, CancelledError) as error:  # noqa: BLE001 - of whatever executor it is
        return Ended(task=one.task, error=error, attempts=one.number)


def _sure(found: Ended[T, R]) -> R:
    result: R = found.result  # type: ignore[assignment]  # there is no error
    return result
