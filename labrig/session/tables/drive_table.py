"""A CSV table of a drive, and the protocol.toml whose `[table] file = "drive.csv"` names it.

The rows take the file's place in the protocol's text: so the text that a session keeps says all
that was written, and needs no other file.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

from labrig.config import ProtocolConfig, parse_protocol, read_text
from labrig.config.file_kinds import PROTOCOL
from labrig.errors import BadInputError
from labrig.session.tables.csv_rows import NUMBER, CsvRow
from labrig.session.tables.decimals import from_plain
from labrig.session.tables.table import read_table
from labrig.session.tables.text.meaning import ExpectedColumns

_TABLE, _KEY = "table", "file"
_TIME, _VOLTAGE = "time_s", "voltage_V"
_COLUMNS = ExpectedColumns(kind="drive", required=(_TIME, _VOLTAGE), renamed=False)
_MOST_ROWS = 1_000_000
_LINE = re.compile(r"(?m)^[ \t]*file[ \t]*=.*$")


def drive_rows(path: Path) -> Iterator[tuple[CsvRow, float, float]]:
    """Yield each row of a drive's table, with its time and its voltage. Raises BadInputError."""
    rows = read_table(path, _COLUMNS).rows()
    if len(rows) > _MOST_ROWS:
        raise BadInputError(f"{path}: a drive has at most {_MOST_ROWS} rows.")
    for row in rows:
        yield row, row.get(_TIME, from_plain, NUMBER), row.get(_VOLTAGE, from_plain, NUMBER)


def load_protocol(path: Path) -> ProtocolConfig:
    """Read protocol.toml, and the table that it names."""
    return parse_protocol(read_protocol(path), str(path))


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
    rows = list(drive_rows(folder / file))
    times = ", ".join(repr(time_s) for _, time_s, _ in rows)
    volts = ", ".join(repr(voltage_V) for _, _, voltage_V in rows)
    values = f"times_s = [{times}]\nvoltages_V = [{volts}]"
    return _LINE.sub(lambda _: f"# of {file}:\n{values}".replace("\r", " "), text)
