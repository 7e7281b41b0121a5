"""All rows as one table: CSV, and Parquet where pyarrow is there."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any, TextIO

from labrig.batch.rows import Row
from labrig.files import as_text, discard, not_written

_ROW_GROUP = 1000
_BETWEEN = "; "
_AROUND = ("attempts", "cpu_s", "wall_s", "ended", "digest")


def write_csv(path: Path, rows: Iterable[Row]) -> None:
    """Write a CSV table: a line for each row. Raises LabrigError where it cannot be written."""
    columns = list(_kinds(rows))
    with _whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        _write_lines(file, columns, rows)


def write_parquet(path: Path, rows: Iterable[Row]) -> bool:
    """Write the same as Parquet, numbers as numbers; False where pyarrow is not installed."""
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        return False
    kinds = _kinds(rows)
    types = {bool: pa.bool_(), float: pa.float64(), str: pa.string()}
    schema = pa.schema([(name, types[kind]) for name, kind in kinds.items()])
    with _whole_file(path) as part, parquet.ParquetWriter(part, schema) as writer:
        lines = (_cells(row) for row in rows)
        while group := list(islice(lines, _ROW_GROUP)):
            data = {
                name: [_as(kind, cells.get(name)) for cells in group]
                for name, kind in kinds.items()
            }
            writer.write_table(pa.table(data, schema=schema))
    return True


def _write_lines(file: TextIO, columns: list[str], rows: Iterable[Row]) -> None:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        cells = _cells(row)
        writer.writerow([_text(cells.get(name)) for name in columns])


def _cells(row: Row) -> dict[str, Any]:
    about = {"name": row.name, "outcome": row.outcome.value, "why": row.sentence}
    cells = {**row.columns, **about, **{name: getattr(row, name) for name in _AROUND}}
    return {k: as_text(value) if isinstance(value, str) else value for k, value in cells.items()}


def _kinds(rows: Iterable[Row]) -> dict[str, type]:
    """Return the columns of all rows, and whether each holds numbers, yes and no, or texts."""
    found: dict[str, type | None] = {}
    for row in rows:
        for name, value in row.columns.items():
            kind = _kind(value)
            known = found.setdefault(name, kind)
            if kind is not None and known is not kind:
                found[name] = kind if known is None else str
    first: dict[str, type] = {"name": str, "outcome": str, "why": str}
    last: dict[str, type] = {
        name: float if name in {"attempts", "cpu_s", "wall_s"} else str for name in _AROUND
    }
    own = {name: kind or str for name, kind in found.items() if name not in {*first, *last}}
    return {**first, **own, **last}


def _kind(value: Any) -> type | None:
    if value is None:
        return None
    if isinstance(value, bool):
        return bool
    return float if isinstance(value, int | float) else str


def _as(kind: type, value: Any) -> Any:
    if value is None or kind is bool:
        return value
    return float(value) if kind is float else _text(value)


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return _BETWEEN.join(str(one) for one in value)
    return repr(value) if isinstance(value, float) else str(value)


@contextmanager
def _whole_file(path: Path) -> Iterator[Path]:
    """Yield a path beside; what was written there takes the file's place."""
    part = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        part.replace(path)
    except OSError as error:
        discard(part)
        raise not_written(path, error) from None
