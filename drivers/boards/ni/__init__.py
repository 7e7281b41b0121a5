"""National Instruments boards: of this computer, or behind an NI gRPC Device Server."""

from drivers.boards.ni.family import BOARDS

__all__ = ["BOARDS"]
