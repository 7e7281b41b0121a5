"""Analog boards: one family a module or package (`contract` says what a family is)."""

from drivers.boards.contract import (
    BOARD_FAMILIES,
    DEFAULT,
    BoardConnection,
    BoardFamily,
    BoardFinding,
    BoardInput,
    OutputRescue,
    Starter,
)

__all__ = [
    "BOARD_FAMILIES",
    "DEFAULT",
    "BoardConnection",
    "BoardFamily",
    "BoardFinding",
    "BoardInput",
    "OutputRescue",
    "Starter",
]
