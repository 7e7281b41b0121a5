"""Tables of forces, curves and signals into measurements, and back without loss."""

from labrig.session.tables.read import ReadTables, read_and_understood, read_tables
from labrig.session.tables.stated import column_names
from labrig.session.tables.text.meaning import ColumnNames
from labrig.session.tables.write import write_tables

__all__ = [
    "ColumnNames",
    "ReadTables",
    "column_names",
    "read_and_understood",
    "read_tables",
    "write_tables",
]
