"""forces.csv, curves.csv and signals.csv into measurements, and back without loss."""

from labrig.session.tables_in import read_tables
from labrig.session.tables_out import write_tables

__all__ = ["read_tables", "write_tables"]
