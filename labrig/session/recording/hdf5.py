"""Groups, datasets and attributes of a session file, in the types that it may hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from labrig.session.format import layout

# By the end of a column's name; names of the channels' values end with their own unit.
_UNITS = {"_s": "s", "_V": "V", "_m": "m", "_N": "N", "_A": "A", "_hz": "Hz", "_rad": "rad"}


def set_attributes(item: Any, **values: object) -> None:
    """Attributes of a group or dataset."""
    for name, value in values.items():
        if isinstance(value, str):
            _put_text_attribute(item, name, value)
        else:
            item.attrs[name] = value


def _put_text_attribute(item: Any, name: str, value: str) -> None:
    """One text attribute: of variable length, as NeXus libraries want it, since version 5."""
    if _texts_vary(item):
        item.attrs[name] = value
        return
    raw = value.encode("utf-8")
    item.attrs.create(name, np.bytes_(raw), dtype=layout.text_type(len(raw)))


def put_text_list(item: Any, name: str, values: list[str]) -> None:
    """Write an attribute of several texts."""
    if _texts_vary(item):
        item.attrs[name] = values
        return
    raw = [value.encode("utf-8") for value in values]
    kind = layout.text_type(max(len(value) for value in raw))
    item.attrs.create(name, np.array(raw, dtype=kind), dtype=kind)


def _texts_vary(item: Any) -> bool:
    return int(item.file.attrs.get("labrig_format", layout.FORMAT)) >= layout.NEXUS_SINCE


def put_text(group: Any, name: str, value: str, size: int | None = None) -> None:
    """Write a scalar text of a fixed length, as long as it is unless `size` says otherwise."""
    raw = value.encode("utf-8")
    kind = layout.text_type(size or len(raw))
    group.create_dataset(name, data=np.array(raw, dtype=kind), dtype=kind)


def put_texts(group: Any, values: Mapping[str, str]) -> None:
    """Write the texts that are not empty."""
    for name, text in values.items():
        if text:
            put_text(group, name, text)


def create_group(file: Any, path: str, nx_class: str) -> Any:
    """Make a group of a NeXus class."""
    group = file.create_group(path)
    set_attributes(group, NX_class=nx_class)
    return group


def create_column(
    group: Any, name: str, kind: str, *, chunk: int, units: str = "", comment: str = ""
) -> Any:
    """Make a dataset of one value a row that grows."""
    column = group.create_dataset(
        name,
        shape=(0,),
        maxshape=(None,),
        chunks=(chunk,),
        dtype=kind,
        shuffle=True,
        compression="gzip",
    )
    if units:
        set_attributes(column, units=units)
    put_comment(column, comment)
    return column


def create_table(
    group: Any,
    name: str,
    row: np.dtype[Any],
    *,
    rows_in_chunk: int,
    units: Mapping[str, str] | None = None,
    comment: str = "",
) -> None:
    """Make a table that grows; `units` are those of columns whose names do not end with theirs."""
    table = group.create_dataset(
        name, shape=(0,), maxshape=(None,), chunks=(rows_in_chunk,), dtype=row, compression="gzip"
    )
    put_column_units(table, units or {})
    put_comment(table, comment)


def put_comment(item: Any, comment: str) -> None:
    """Write what a reader of a dataset must know of its numbers, if anything."""
    if comment:
        set_attributes(item, comment=comment)


def put_column_units(table: Any, units: Mapping[str, str]) -> None:
    """Write the unit of each column of a table, empty where there is none."""
    if _texts_vary(table):
        put_text_list(
            table, "column_units", [units.get(name, unit_of(name)) for name in table.dtype.names]
        )


def unit_of(column: str) -> str:
    """Return the unit with which the name of a column ends."""
    return next((unit for end, unit in _UNITS.items() if column.endswith(end)), "")
