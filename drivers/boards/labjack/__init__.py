"""LabJack T4, T7 and T8, over Modbus TCP: sockets and struct, no library of the maker."""

from drivers.boards.labjack.family import BOARDS

__all__ = ["BOARDS"]
