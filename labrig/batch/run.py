"""Work off a plan: the rows are kept as the pieces end."""

from __future__ import annotations

import datetime as dt
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Any

from labrig.batch.keys import content_of, stamp_of
from labrig.batch.loop import ATTEMPTS, Ended, worked
from labrig.batch.plan import ROWS, BatchPlan
from labrig.batch.pool import WorkerLostError
from labrig.batch.row_file import row_file
from labrig.batch.rows import PieceOutcome, Row
from labrig.batch.worker import Piece, PieceEnd, do


@dataclass(kw_only=True)
class BatchProgress:
    """How far a batch is."""

    wanted: int  # of this run
    done: int = 0
    faults: int = 0  # and lost
    cpu_s: float = 0.0  # of the workers
    began_s: float = 0.0

    @property
    def ended(self) -> int:
        """Pieces that have ended in this run."""
        return self.done + self.faults

    def left_s(self, now_s: float) -> float | None:
        """Return the time that the rest will take; None while nobody can know."""
        if not self.ended:
            return None
        return (now_s - self.began_s) / self.ended * (self.wanted - self.ended)


def run_batch(
    plan: BatchPlan,
    executor: Executor,
    places: Callable[[], int],
    tell: Callable[[BatchProgress, Row], None] = lambda *_: None,
    *,
    attempts: int = ATTEMPTS,
) -> BatchProgress:
    """Do what is to be done. Raises LabrigError where rows cannot be kept, or no worker be had."""
    progress = BatchProgress(wanted=len(plan.todo), began_s=time.monotonic())
    if not plan.todo:
        return progress
    with row_file(plan.folder / ROWS) as rows:
        ends = worked(plan.todo, do, executor, places, attempts=attempts, again=_again)
        with closing(ends) as together:  # type: ignore[type-var]  # a generator
            for ended in together:
                new = [_row(one) for one in ended]
                rows.append(new)
                for row in new:
                    _count(progress, row)
                    tell(progress, row)
    return progress


def _again(end: PieceEnd) -> bool:
    return end.again


def _row(ended: Ended[Piece, PieceEnd]) -> Row:
    piece, end = ended.task, ended.result
    if end is not None:
        return replace(end.row, attempts=ended.attempts)
    return Row(
        name=piece.item.name,
        key=piece.key,
        outcome=PieceOutcome.LOST,
        sentence=_why_lost(ended.error, ended.attempts),
        attempts=ended.attempts,
        ended=dt.datetime.now(dt.UTC).isoformat(timespec="milliseconds"),
        **_state(piece),
    )


def _state(piece: Piece) -> dict[str, Any]:
    try:
        source = piece.item.source
        return {"stamp": stamp_of(source), "content": content_of(source)}
    except OSError:
        return {}


def _why_lost(error: BaseException | None, attempts: int) -> str:
    why = str(error) if isinstance(error, WorkerLostError) else f"{type(error).__name__}: {error}"
    return f"no worker gave an answer in {attempts} attempts; the last time: {why}."


def _count(progress: BatchProgress, row: Row) -> None:
    progress.cpu_s += row.cpu_s
    if row.outcome is PieceOutcome.DONE:
        progress.done += 1
    else:
        progress.faults += 1


def one_by_one(pieces: Iterable[Piece]) -> Iterator[Row]:
    """Do pieces in this process, one after the other, and keep no rows: to compare with."""
    for piece in pieces:
        yield do(piece).row
