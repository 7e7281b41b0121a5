"""What happens in a worker: one piece of work, from its files to its row."""

from __future__ import annotations

import datetime as dt
import json
import time
from dataclasses import dataclass, replace
from pathlib import Path
from types import NoneType
from typing import Any

from labrig.batch.contract import BatchAnswer, BatchItem, BatchTask
from labrig.batch.keys import content_of, digest, stamp_of
from labrig.batch.rows import PieceOutcome, Row
from labrig.errors import LabrigError
from labrig.files import write_text
from labrig.foreign_code import foreign_place
from labrig.serialise import finite


@dataclass(frozen=True)
class Piece:
    """A task, what it is done with, and where its results are written."""

    task: BatchTask
    item: BatchItem
    key: str
    folder: Path  # of the item's files: FOLDER.json, FOLDER.toml, FOLDER/...


_CELL = (bool, int, float, str, NoneType)


@dataclass(frozen=True)
class PieceEnd:
    """Its row, and whether what went wrong may go right in another attempt."""

    row: Row
    again: bool = False


def do(piece: Piece) -> PieceEnd:
    """Do a piece of work, and write what was found; raises nothing for what is in a file."""
    began, cpu = time.perf_counter(), time.process_time()
    row = Row(name=piece.item.name, key=piece.key, outcome=PieceOutcome.DONE)
    again = False
    try:
        row = _done(piece, row)
    except (Exception, SystemExit) as error:  # noqa: BLE001 - the other pieces shall be done
        known = isinstance(error, LabrigError) or _is_model_error(error)
        again = not known
        row = replace(
            row,
            outcome=PieceOutcome.FAULT,
            sentence=_sentence(error, known=known),
            digest="",
            columns={},
        )
        row = _with_state_of_files(piece, row)
    return PieceEnd(
        replace(
            row,
            cpu_s=round(time.process_time() - cpu, 6),
            wall_s=round(time.perf_counter() - began, 6),
            ended=dt.datetime.now(dt.UTC).isoformat(timespec="milliseconds"),
        ),
        again,
    )


def _done(piece: Piece, row: Row) -> Row:
    source = piece.item.source
    before, content = stamp_of(source), content_of(source)
    answer: object = piece.task.work(piece.item, piece.folder)
    if not isinstance(answer, BatchAnswer):  # other people's task may return anything
        raise TypeError(f"`work` returned {type(answer).__name__}, not a BatchAnswer")
    whole, columns = finite(answer.whole), finite(dict(answer.columns))
    _require_cells(columns)
    _write(piece.folder, answer, whole)
    after = stamp_of(source)
    if after != before:
        content = content_of(source)
    return replace(
        row,
        content=content,
        stamp=after,
        digest=digest(whole),
        columns=columns,
    )


def _require_cells(columns: dict[str, Any]) -> None:
    """Raise TypeError for what no line of the rows holds: it would end the whole batch."""
    for name, cell in columns.items():
        each = cell if isinstance(cell, list) else [cell]
        if not all(isinstance(one, _CELL) for one in each):
            raise TypeError(
                f"its column {name} holds a {type(cell).__name__}; a cell is a number, a text, "
                "True, False, None or a list of texts"
            )


def _with_state_of_files(piece: Piece, row: Row) -> Row:
    try:
        return replace(
            row, stamp=stamp_of(piece.item.source), content=content_of(piece.item.source)
        )
    except OSError:
        return row


def _write(folder: Path, answer: BatchAnswer, whole: object) -> None:
    folder.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(whole, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    for ending, content in {"json": text, **answer.files}.items():
        write_text(folder.with_name(f"{folder.name}.{ending}"), content)


def _is_model_error(error: BaseException) -> bool:
    from model.measurements import ModelError

    return isinstance(error, ModelError)


def _sentence(error: BaseException, *, known: bool) -> str:
    text = " ".join(str(error).split())
    if known:
        return text if text.endswith(".") else f"{text}."
    said = f"failed with {type(error).__name__}: {text}".rstrip(": ").rstrip(".")
    place = foreign_place(error)
    return f"{said}." if place is None else f"{said}, in {place}."
