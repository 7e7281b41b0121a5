"""The world's own record, followed while it grows."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path

ZERO_V = 0.05
LEVEL_V = 0.1  # two voltages nearer than this are one


@dataclass(frozen=True)
class Row:
    """What the world was like at a moment of the computer's monotonic clock."""

    time_s: float
    drive_V: float
    force_N: float

    @property
    def is_energised(self) -> bool:
        """Whether there was a voltage on the sheet."""
        return abs(self.drive_V) > ZERO_V


@dataclass(frozen=True)
class Pulse:
    """A voltage other than 0 between two edges."""

    begin_s: float
    end_s: float  # infinite: it has not ended
    volts: float


class WorldRecord:
    """The rows that were written since it was made, each read once."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._at = path.stat().st_size
        self._rest = b""
        self.rows: list[Row] = []

    def look(self) -> list[Row]:
        """Take in what is new; all rows up to now."""
        with self._path.open("rb") as file:
            file.seek(self._at)
            text = file.read()
        self._at += len(text)
        lines = (self._rest + text).split(b"\n")
        self._rest = lines.pop()
        for line in lines:
            time_s, drive_V, force_mN, _ = line.decode("ascii").split(",")
            self.rows.append(Row(float(time_s), float(drive_V), float(force_mN) / 1000))
        return self.rows

    @property
    def is_energised(self) -> bool:
        """Whether there is a voltage on the sheet now."""
        rows = self.look()
        return bool(rows) and rows[-1].is_energised

    @property
    def was_energised(self) -> bool:
        """Whether there has been one."""
        return any(row.is_energised for row in self.look())


def volts_at(rows: list[Row], time_s: float) -> float:
    """The voltage at a moment; 0 before the first row."""
    before = [row for row in rows if row.time_s <= time_s]
    return before[-1].drive_V if before else 0.0


def force_between(rows: list[Row], begin_s: float, end_s: float) -> float | None:
    """Mean force of a span; None where the record has none (it has them of a driven sheet)."""
    found = [row.force_N for row in rows if begin_s <= row.time_s <= end_s]
    return sum(found) / len(found) if found else None


def pulses(rows: list[Row]) -> list[Pulse]:
    """All pulses, in order."""
    if not rows:
        return []
    edges = [
        rows[0],
        *(b for a, b in itertools.pairwise(rows) if abs(a.drive_V - b.drive_V) > LEVEL_V),
    ]
    ends = [*(row.time_s for row in edges[1:]), float("inf")]
    return [
        Pulse(row.time_s, end_s, row.drive_V)
        for row, end_s in zip(edges, ends, strict=True)
        if row.is_energised
    ]


def zero_since(rows: list[Row], fault_s: float) -> float | None:
    """When the voltage was 0 for good, counted from a moment at which it was not.

    None: it was 0 V at that moment, or did not come down.
    """
    if abs(volts_at(rows, fault_s)) <= ZERO_V:
        return None
    last = max(i for i, row in enumerate(rows) if row.is_energised)
    return rows[last + 1].time_s - fault_s if last + 1 < len(rows) else None
