"""Positioners that move the load cell along the arc: one kind a file."""

from drivers.positioners.contract import DEFAULT, POSITIONERS, PositionerKind

__all__ = ["DEFAULT", "POSITIONERS", "PositionerKind"]
