"""`[table] file = "drive.csv"` of protocol.toml: the rows take the file's place in the text.

So the text that a session keeps says all that was written, and needs no other file.
"""

from __future__ import annotations

import csv
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

from labrig.config.base import read_text
from labrig.config.file_kinds import PROTOCOL
from labrig.errors import BadInputError

_TABLE, _KEY = "table", "file"
_COLUMNS = ("time_s", "voltage_V")
_LINE = re.compile(r"(?m)^[ \t]*file[ \t]*=.*$")


def read_protocol(path: Path) -> str:
    """Return protocol.toml's text, with the rows of the file that its [table] names."""
    return with_rows(read_text(path, PROTOCOL), path.parent, str(path))


def with_rows(text: str, folder: Path, name: str) -> str:
    """Return the text with the rows of the file; `folder` is where its path begins."""
    try:
        table = tomllib.loads(text).get(_TABLE)
    except (ValueError, RecursionError):  # whoever reads the file says what is wrong with it
        return text
    if not isinstance(table, dict) or _KEY not in table:
        return text
    file = table[_KEY]
    if not isinstance(file, str) or not file:
        raise BadInputError(
            f'{name}: [table] file must be the path of a CSV file, such as "a.csv".'
        )
    if {"times_s", "voltages_V"} & table.keys():
        raise BadInputError(f"{name}: [table] has both file and lists of values; keep one of them.")
    if len(_LINE.findall(text)) != 1:
        raise BadInputError(f"{name}: write [table] with file = ... on a line of its own.")
    rows = list(_rows(folder / file))
    lists = ", ".join(repr(row[0]) for row in rows), ", ".join(repr(row[1]) for row in rows)
    values = f"times_s = [{lists[0]}]\nvoltages_V = [{lists[1]}]"
    return _LINE.sub(lambda _: f"# of {file}:\n{values}".replace("\r", " "), text)


def _rows(path: Path) -> Iterator[tuple[float, float]]:
    lines = csv.DictReader(read_text(path).splitlines())
    missing = [name for name in _COLUMNS if name not in (lines.fieldnames or ())]
    if missing:
        raise BadInputError(f"{path}: it has no column {' and '.join(missing)}.")
    for row in lines:
        values = []
        for name in _COLUMNS:
            try:
                values.append(float(row[name] or ""))
            except ValueError:
                raise BadInputError(
                    f"{path}, line {lines.line_num}: {name} = {row[name]!r} is not a number."
                ) from None
        yield values[0], values[1]
