"""Processes of this computer that work off tasks: one that is killed takes its own task along.

`ProcessPoolExecutor` gives up all its processes and what they were doing when one of them is
killed, and waits for ever for an answer that was cut short. Here each process has a pipe and a
thread of its own: its end is seen at once, by nobody else, and another process takes its place.
"""

from __future__ import annotations

import os
import pickle
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any, ParamSpec, TypeVar

from labrig.parent_process import end_with_parent, interrupts_blocked

P = ParamSpec("P")
R = TypeVar("R")
# Read when numpy, numba and OpenCV are loaded: a process is a core here.
ONE_THREAD = (
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "OMP_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "OPENCV_FOR_THREADS_NUM",
    "VECLIB_MAXIMUM_THREADS",
)
_END_S = 10.0  # for a process to end by itself
_starting = threading.Lock()  # the environment is the whole program's


class WorkerLostError(BrokenExecutor):
    """The process that had a task has ended without an answer."""


class LocalPool(Executor):
    """So many processes, started when they are needed; each does one task at a time."""

    def __init__(self, workers: int) -> None:
        self.workers = max(1, workers)
        self._threads = ThreadPoolExecutor(self.workers, "batch")
        self._own = threading.local()  # each thread's process
        self._started: set[_Worker] = set()
        self._lock = threading.Lock()
        self._over = False

    def submit(self, fn: Callable[P, R], /, *args: P.args, **kwargs: P.kwargs) -> Future[R]:
        """Let a process call `fn`; the future raises WorkerLostError where that was killed."""
        return self._threads.submit(self._in_process, fn, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes when their tasks are done."""
        self._threads.shutdown(wait=wait, cancel_futures=cancel_futures)
        if wait:
            self._end_all()

    def kill(self) -> None:
        """End the processes at once; what they were doing is lost."""
        self._over = True
        with self._lock:
            for worker in self._started:
                worker.kill()
        self._threads.shutdown(wait=True, cancel_futures=True)
        self._end_all()

    @property
    def pids(self) -> list[int]:
        """The processes that there are now."""
        with self._lock:
            return [worker.pid for worker in self._started]

    def _in_process(self, fn: Callable[..., R], args: Any, kwargs: Any) -> R:
        worker = getattr(self._own, "worker", None)
        if worker is None:
            worker = self._own.worker = self._new()
        try:
            answer: R = worker.call(fn, args, kwargs)
        except WorkerLostError:
            self._own.worker = None
            with self._lock:
                self._started.discard(worker)
            raise
        return answer

    def _new(self) -> _Worker:
        worker = _Worker()
        with self._lock:
            self._started.add(worker)
            if self._over:
                worker.kill()
        return worker

    def _end_all(self) -> None:
        with self._lock:
            ended, self._started = self._started, set()
        for worker in ended:
            worker.end()


class _Worker:
    """One process, used by one thread."""

    def __init__(self) -> None:
        # Spawned everywhere, as Windows does it: a forked HDF5 library would share its open files.
        context = get_context("spawn")
        self._end, other = context.Pipe()
        self._process: BaseProcess = context.Process(target=_serve, args=(other,), daemon=True)
        with _starting, _one_thread(), interrupts_blocked():
            self._process.start()
        other.close()  # else the pipe would not end with the process

    @property
    def pid(self) -> int:
        return self._process.pid or 0

    def call(self, fn: Callable[..., R], args: Any, kwargs: Any) -> R:
        """Return the answer, raise what `fn` raised or WorkerLostError."""
        order = pickle.dumps((fn, args, kwargs))
        try:
            self._end.send_bytes(order)
            answer = self._end.recv_bytes()
        except (EOFError, OSError):
            self._process.join(_END_S)
            code = self._process.exitcode
            self._end.close()
            raise WorkerLostError(f"its process ended {_how(code)}") from None
        good, value = pickle.loads(answer)  # noqa: S301 - our own process wrote it
        if not good:
            raise value
        result: R = value
        return result

    def kill(self) -> None:
        with suppress(OSError, ValueError):
            self._process.kill()

    def end(self) -> None:
        """Let it end: it does when its pipe is closed."""
        self._end.close()
        self._process.join(_END_S)
        if self._process.is_alive():
            self.kill()
            self._process.join()
        self._process.close()


def _how(code: int | None) -> str:
    if code is None:
        return "without a reason"
    if code < 0:
        with suppress(ValueError):
            return f"by {signal.Signals(-code).name}"
    return f"with code {code}"


def _serve(end: Connection) -> None:
    """Work off orders until the pipe is closed."""
    end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that keeps the rows
    while True:
        try:
            order = end.recv_bytes()
        except (EOFError, OSError):
            return
        end.send_bytes(_answer(order))


def _answer(order: bytes) -> bytes:
    try:
        fn, args, kwargs = pickle.loads(order)  # noqa: S301 - our own process wrote it
        return pickle.dumps((True, fn(*args, **kwargs)))
    except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever it is, the one who asked is told
        try:
            told = pickle.dumps((False, error))
            pickle.loads(told)  # noqa: S301 - some errors can be written and not read
        except Exception:  # noqa: BLE001
            return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))
        return told


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let processes that are started now use one thread each."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
