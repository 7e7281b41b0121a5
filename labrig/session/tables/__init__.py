"""forces.csv, curves.csv and signals.csv into measurements, and back without loss."""

from labrig.session.tables.read import read_tables
from labrig.session.tables.write import write_tables

__all__ = ["read_tables", "write_tables"]
