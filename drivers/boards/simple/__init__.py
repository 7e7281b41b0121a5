"""A family of boards from a few calls of its maker's library: see `board.SimpleBoard`."""

from drivers.boards.simple.board import SimpleBoard, SimpleSettings
from drivers.boards.simple.family import simple_family

__all__ = ["SimpleBoard", "SimpleSettings", "simple_family"]
