"""Which pieces of work there are, and which of them are to be done."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from labrig.batch.choice import version_of
from labrig.batch.contract import BatchInput, BatchItem, BatchTask
from labrig.batch.keys import content_of, options_key, piece_key, stamp_of
from labrig.batch.rows import PieceOutcome, Row, rows_in
from labrig.batch.worker import Piece
from labrig.errors import BadInputError

ROWS = "rows.jsonl"
_EACH = "each"
_ODD = re.compile(r'[<>:"|?*\x00-\x1f]')


@dataclass(frozen=True, kw_only=True)
class BatchPlan:
    """All pieces in their order, by name; those to be done; how many were done before."""

    folder: Path  # of this task's results
    names: Sequence[str]
    todo: Sequence[Piece]
    done: int
    faulty: int  # ended with a fault before, and left alone
    later: int  # left for another time by a limit


@dataclass(frozen=True, kw_only=True)
class BatchOrder:
    """What a person asked for."""

    name: str
    task: BatchTask
    inputs: Sequence[BatchInput]
    output: Path
    retry_errors: bool = False
    limit: int | None = None


def folder_of(output: Path, name: str) -> Path:
    """Return where the results of a task lie: several tasks share an output folder."""
    return output / name


def plan(wanted: BatchOrder) -> BatchPlan:
    """Compare what is wanted with the rows that there are. Raises LabrigError."""
    folder = folder_of(wanted.output, wanted.name)
    options = options_key(wanted.name, wanted.task, version_of(wanted.name, wanted.task))
    known = {row.name: row for row in rows_in(folder / ROWS)}
    names, todo, done, faulty = list[str](), list[Piece](), 0, 0
    contents: dict[Path, str] = {}  # of files that were looked into, for all their pieces
    for source in wanted.inputs:
        for item in wanted.task.items(source):
            names.append(item.name)
            key = piece_key(options, item)
            row = known.get(item.name)
            if row is None or not _holds(row, key, source, contents):
                todo.append(_piece(wanted, item, key, folder))
            elif row.outcome is PieceOutcome.DONE:
                done += 1
            elif wanted.retry_errors or row.outcome is PieceOutcome.LOST:
                todo.append(_piece(wanted, item, key, folder))
            else:
                faulty += 1
    if len(set(names)) < len(names):
        raise BadInputError(f"{wanted.name}: two pieces of work have the same name.")
    most = len(todo) if wanted.limit is None else wanted.limit
    return BatchPlan(
        folder=folder,
        names=names,
        todo=todo[:most],
        done=done,
        faulty=faulty,
        later=max(0, len(todo) - most),
    )


def _holds(row: Row, key: str, source: BatchInput, contents: dict[Path, str]) -> bool:
    """Whether a row is of these options and of the files as they are now.

    Files whose times and sizes are those of the row are not read again.
    """
    if row.key != key:
        return False
    try:
        if stamp_of(source) == row.stamp:
            return True
        if source.path not in contents:
            contents[source.path] = content_of(source)
    except OSError:
        return not row.content and row.outcome is not PieceOutcome.DONE
    return contents[source.path] == row.content


def _piece(wanted: BatchOrder, item: BatchItem, key: str, folder: Path) -> Piece:
    return Piece(wanted.task, item, key, (folder / _EACH / _file_name(item)).absolute())


def _file_name(item: BatchItem) -> Path:
    """Return the place of a piece's files, below the folder whatever its name is."""
    parts = [_ODD.sub("_", part) for part in Path(item.source.name).parts]
    inside = ["up" if part == ".." else part.strip("/\\") or "root" for part in parts]
    path = Path(*inside)
    label = _ODD.sub("_", item.label).replace("/", "_").replace(" ", "-")
    return path.with_name(f"{path.name}-{label}") if label else path
