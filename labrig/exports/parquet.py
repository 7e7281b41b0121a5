"""The same tables as CSV has, as Apache Parquet with typed columns."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from labrig.exports._files import new_file
from labrig.files import all_or_none
from labrig.session import export_session
from labrig.session.recording.disk import written_beside
from labrig.session.tables.write import TABLES

_TABLES = (*TABLES, "control.csv")
_TEXTS = ("configuration", "kind", "approach", "extra", "why")
_WHOLE_NUMBERS = ("reading", "point", "mounting", "run")


class _Parquet:
    summary = "Forces, curves and signals as Parquet, one file a table; columns as in CSV."
    extra = "dataframe"

    def write(self, session: Path, folder: Path) -> list[Path]:
        import pyarrow.parquet  # before the tables are written: it may be missing

        del pyarrow
        with tempfile.TemporaryDirectory() as beside:
            tables = [p for p in export_session(session, Path(beside)) if p.name in _TABLES]
            targets = {table: new_file(folder, f"{table.stem}.parquet") for table in tables}
            with all_or_none(targets.values()):
                for table, target in targets.items():
                    _convert(table, target)
        return list(targets.values())


def _convert(table: Path, target: Path) -> None:
    import pyarrow.csv
    import pyarrow.parquet

    names = table.read_text(encoding="utf-8").split("\n", 1)[0].split(",")
    options = pyarrow.csv.ConvertOptions(
        column_types={name: _type(name) for name in names}, strings_can_be_null=True
    )
    read = pyarrow.csv.read_csv(table, convert_options=options)
    with written_beside(target) as beside:
        pyarrow.parquet.write_table(read, beside)


def _type(name: str) -> Any:
    """Return a column's type, which must not depend on the rows that happen to be there."""
    import pyarrow as pa

    if name in _TEXTS or not name.isidentifier():
        return pa.string()
    if name in _WHOLE_NUMBERS:
        return pa.int64()
    if name == "valid":
        return pa.bool_()
    has_unit = "_" in name
    return pa.float64() if has_unit else pa.string()


FORMAT = _Parquet()
