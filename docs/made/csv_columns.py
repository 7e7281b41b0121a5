"""The columns of the CSV tables, with units, signs and axes."""

from __future__ import annotations

from collections.abc import Iterator

from labrig.session.tables import columns

HEAD = """\
# CSV tables

`labrig import`, `labrig diagnose --forces ...` and `labrig fit` read these tables; `labrig export`
writes them. The first line names the columns, in any order. Columns are separated by commas,
decimals have a point, and an empty field means that the value is not known. The end of a name is
the unit.

Axes and signs: {axes} [Keys of sheet.toml](sheet_file.md)

![The coordinates](../../images/made/coordinates.svg)

`labrig export session.h5 -o tables` writes all three, `labrig config columns` prints this page.
"""


def page() -> str:
    """Return the page's text. Raises KeyError for a column that is not described here."""
    head = HEAD.format(axes=columns.AXES)
    return "\n".join([head, *(line for name in columns.TABLES for line in _table(name))])


def _table(name: str) -> Iterator[str]:
    about, required, optional = columns.TABLES[name]
    yield f"\n## {name}\n"
    yield f"{about}\n"
    yield "| column | required | meaning |"
    yield "|---|---|---|"
    for column in required:
        yield f"| `{column}` | yes | {columns.MEANINGS[column]} |"
    for column in optional:
        yield f"| `{column}` | no | {columns.MEANINGS[column]} |"
    if name == "forces.csv":
        yield (
            f"| `{columns.CHANNEL}NAME_UNIT` | no | a further input of the rig, such as "
            f"`{columns.CHANNEL}temperature_degC` |"
        )
