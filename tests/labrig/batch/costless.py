"""Tasks that cost nothing, or fail in a way that a test wants; importable by workers."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from labrig.batch import BatchAnswer, BatchInput, BatchItem, BatchTask, InputKind, option
from labrig.errors import BadInputError


def wait(seconds: float) -> None:
    threading.Event().wait(seconds)


def square(number: int) -> int:
    return number * number


def slowly(number: int) -> int:
    wait(0.01)
    return number * number


def raised(number: int) -> int:
    raise RuntimeError(f"no {number}")


def killed(number: int) -> int:
    os.kill(os.getpid(), signal.SIGKILL)
    return number


def killed_once(task: tuple[str, int]) -> int:
    """Its first worker is killed."""
    folder, number = task
    mark = Path(folder) / f"{number}"
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def environment(names: tuple[str, ...]) -> list[str | None]:
    return [os.environ.get(name) for name in names]


def process_id(number: int) -> int:
    del number
    return os.getpid()


@dataclass(frozen=True, kw_only=True)
class Costless(BatchTask):
    """Do nothing, a number of times for each file."""

    takes = frozenset({InputKind.SESSION})
    counted = ("even",)

    count: int = option("pieces of each file", default=10)
    wait_s: float = option("of each piece", default=0.0)
    faulty: int = option("every so many pieces are at fault; 0: none", default=0)
    broken: int = option("every so many pieces raise something; 0: none", default=0)
    deadly: int = option("the worker of this piece is killed, always; -1: of none", default=-1)

    def items(self, source: BatchInput) -> Iterator[BatchItem]:
        for k in range(self.count):
            yield BatchItem(source=source, part={"k": k}, label=f"piece {k}")

    def work(self, item: BatchItem, folder: Path) -> BatchAnswer:
        del folder
        k = item.part["k"]
        if self.wait_s:
            wait(self.wait_s)
        if self.deadly == k:
            os.kill(os.getpid(), signal.SIGKILL)
        if self.faulty and k % self.faulty == 0:
            raise BadInputError(f"{item.source.path}: piece {k} is at fault.")
        if self.broken and k % self.broken == 0:
            raise RuntimeError(f"piece {k}")
        return BatchAnswer(columns={"k": k, "even": k % 2 == 0}, whole={"k": k})


TASK = Costless
