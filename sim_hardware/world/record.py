"""The world's own record: what really happened, whatever the software under test believes."""

from __future__ import annotations

from pathlib import Path
from typing import TextIO

from sim_hardware.world.loading import WorldError

_HEADER = "time_s,drive_V,force_mN,position_mm\n"


class Record:
    """A CSV file, flushed at each row, so that it survives whatever happens to this process.

    `time_s` is the clock's; `drive_V` what the board asks for, in sheet volts; `position_mm` is
    empty where the load cell does not touch the sheet.
    """

    def __init__(self, path: Path) -> None:
        try:
            self._file: TextIO | None = path.open("w", encoding="utf-8", newline="")
        except OSError as fault:
            raise WorldError(f"{path}: the record cannot be written ({fault.strerror})") from None
        self._file.write(_HEADER)

    def row(self, time_s: float, drive_V: float, force_N: float, position_m: float | None) -> None:
        """Add a row."""
        if self._file is None:
            return
        place = "" if position_m is None else f"{position_m * 1e3:.4f}"
        self._file.write(f"{time_s:.6f},{drive_V:.6g},{force_N * 1e3:.6f},{place}\n")
        self._file.flush()

    def close(self) -> None:
        """No more rows. May be called twice."""
        if self._file is not None:
            self._file.close()
            self._file = None
