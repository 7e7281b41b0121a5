"""Do a batch, and print how it goes and what came of it."""

from __future__ import annotations

import os
import time
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.cli.screen import Advance, print_json, print_table, progress, say, warn
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from labrig.batch.contract import BatchTask
    from labrig.batch.plan import BatchPlan
    from labrig.batch.rows import Row
    from labrig.batch.run import BatchProgress
    from labrig.batch.summary.numbers import BatchSummary
    from labrig.batch.summary.write import Written
    from labrig.batch.workers import Workers

_MOST_WARNINGS = 10
_MOST_SHOWN = 20
_TELL_EVERY_S = 0.5


@dataclass(frozen=True, kw_only=True)
class BatchRequest:
    """What the command line says, beside the task's own options."""

    patterns: list[str]
    output: Path
    workers: int | None
    scheduler: str | None
    retry_errors: bool
    limit: int | None
    dry_run: bool
    as_json: bool


def perform_batch(name: str, task: BatchTask, request: BatchRequest) -> None:
    """Find the inputs, do what is not done yet, write table and summary."""
    from labrig.batch.inputs import found_inputs
    from labrig.batch.plan import BatchOrder, plan
    from labrig.batch.rows import PieceOutcome

    if request.scheduler is not None and request.workers is not None:
        raise BadInputError("give either --workers or --scheduler: a cluster has its own workers.")
    if request.output.exists() and not request.output.is_dir():
        raise BadInputError(f"{request.output}: this is a file, a folder is needed.")
    task.check()
    found = found_inputs(request.patterns, task.takes, request.output.absolute().parent)
    wanted = BatchOrder(
        name=name,
        task=task,
        inputs=found.inputs,
        output=request.output,
        retry_errors=request.retry_errors,
        limit=request.limit,
    )
    planned = plan(wanted)
    _say_plan(name, planned, found.left_out, as_json=request.as_json)
    if request.dry_run:
        _show_todo(planned, as_json=request.as_json)
        return
    _work(name, task, planned, request)
    from labrig.batch.summary.write import write_summary

    written = write_summary(planned.folder, planned.names, task)
    _show(written, request, planned)
    outcomes = written.summary.outcomes
    if outcomes and not outcomes.get(PieceOutcome.DONE.value):
        count = sum(outcomes.values())
        raise BadInputError(
            f"{name}: no result; {_rows_ended(count)} with an error, which the table has in words."
        )


def _rows_ended(count: int) -> str:
    return "the one row ended" if count == 1 else f"all {count} rows ended"


def _say_plan(name: str, planned: BatchPlan, left_out: int, *, as_json: bool) -> None:
    parts = [f"{len(planned.names)} in all", f"{len(planned.todo)} to do"]
    if planned.done:
        parts.append(f"{planned.done} done before")
    if planned.faulty:
        parts.append(f"{planned.faulty} ended with an error before (--retry-errors does them)")
    if planned.later:
        parts.append(f"{planned.later} left for later (--limit)")
    if left_out:
        parts.append(f"{left_out} other files left out")
    (warn if as_json else say)(f"{name}: {', '.join(parts)}")


def _show_todo(planned: BatchPlan, *, as_json: bool) -> None:
    names = [piece.item.name for piece in planned.todo]
    if as_json:
        print_json({"todo": names, "done": planned.done, "faulty": planned.faulty})
        return
    for one in names:
        say(one)


def _work(name: str, task: BatchTask, planned: BatchPlan, request: BatchRequest) -> None:
    from labrig.batch.run import run_batch

    if not planned.todo:
        return
    count = min(request.workers or _cores(), len(planned.todo))
    if request.scheduler is None and count > 1:
        task.warm_up()  # else each worker would compile it for itself
    try:
        with (
            _workers(request.scheduler, count) as workers,
            progress(name, estimated=False) as advance,
        ):
            told = _Told(advance)
            run_batch(planned, workers.executor, workers.places, told)
            told.end()
    except KeyboardInterrupt:
        warn("what has ended is kept; the same command goes on.")
        raise


def _workers(scheduler: str | None, count: int) -> AbstractContextManager[Workers]:
    from labrig.batch.workers import cluster_workers, local_workers

    return local_workers(count) if scheduler is None else cluster_workers(scheduler)


def _cores() -> int:
    """Return how many cores this program may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class _Told:
    """Prints how far the batch is, and each of the first errors."""

    def __init__(self, advance: Advance) -> None:
        self._advance = advance
        self._warned = 0
        self._told_s = 0.0
        self._last: BatchProgress | None = None

    def __call__(self, at: BatchProgress, row: Row) -> None:
        self._last = at
        if row.sentence:
            self._warned += 1
            if self._warned <= _MOST_WARNINGS:
                warn(f"{row.name}: {row.sentence}")
            elif self._warned == _MOST_WARNINGS + 1:
                warn("further errors are in the table only.")
        now_s = time.monotonic()
        if now_s - self._told_s >= _TELL_EVERY_S and at.ended < at.wanted:
            self._told_s = now_s
            self._advance(at.ended / at.wanted, _how_far(at, now_s))

    def end(self) -> None:
        if self._last is not None:
            self._advance(1.0, _how_far(self._last, time.monotonic()), last=True)


def _how_far(at: BatchProgress, now_s: float) -> str:
    parts = [f"{at.ended} of {at.wanted}"]
    if at.faults:
        parts.append(f"{at.faults} with an error")
    left_s = at.left_s(now_s)
    if at.ended < at.wanted and left_s is not None:
        parts.append(f"{_duration(left_s)} left")
    elif at.ended:
        parts.append(f"{_duration(now_s - at.began_s)}, {at.cpu_s / at.ended:.2f} s of CPU each")
    return ", ".join(parts)


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"


def _show(written: Written, request: BatchRequest, planned: BatchPlan) -> None:
    summary = written.summary
    if request.as_json:
        print_json({**summary.to_json(), "files": [str(path) for path in written.paths]})
        return
    _print_summary(summary)
    for text in written.notes:
        say(text)
    figures = [path.name for path in written.paths if path.suffix == ".png"]
    tables = [path.name for path in written.paths if path.suffix not in {".png", ".svg"}]
    say(f"wrote {', '.join([*tables, *figures])} in {planned.folder}")


def _print_summary(summary: BatchSummary) -> None:
    from labrig.batch.summary.numbers import wilson
    from labrig.report.parts.table import number

    outcomes = ", ".join(f"{count} {name}" for name, count in sorted(summary.outcomes.items()))
    say(f"rows: {outcomes or 'none'}; {_duration(summary.cpu_s)} of CPU")
    say()
    for column, texts in summary.counts.items():
        rows = []
        for text, count in list(texts.items())[:_MOST_SHOWN]:
            low, high = wilson(count, summary.counted_rows[column])
            rows.append([text, str(count), f"{100 * low:.0f} to {100 * high:.0f}"])
        count = summary.counted_rows[column]
        of = f"{count} row{'' if count == 1 else 's'}"
        print_table(f"{column}, of {of}", ["", "rows", "90 % interval, %"], rows)
    rows = []
    for one in summary.distributions:
        told = one.to_json()
        trend = one.trend
        per_day = "-" if trend is None else f"{number(trend.per_day)} ± {number(trend.sigma, 2)}"
        name = f"{one.measure.title}{f', {one.group}' if one.group else ''}, {one.measure.unit}"
        cells = [number(told[key], 4) for key in ("median", "p05", "p95")]
        rows.append([name, str(told["values"]), *cells, per_day])
    if rows:
        columns = ["quantity", "rows", "median", "5 %", "95 %", "trend per day"]
        print_table("Distributions", columns, rows)
    if summary.faults:
        print_table("Errors", ["", "rows"], [[text, str(count)] for text, count in summary.faults])
