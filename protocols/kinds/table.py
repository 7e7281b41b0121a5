"""Any waveform, as a table of times and voltages."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from itertools import pairwise
from typing import ClassVar

from protocols.errors import ScheduleError
from protocols.kinds.fields import LARGEST_VOLTAGE_V, LONGEST_S, count
from protocols.kinds.waveform import Waveform

MOST_ROWS = 20_000


@dataclass(frozen=True, kw_only=True)
class Table(Waveform):
    """Voltages at times, with straight lines between them, or held until the next one.

    In protocol.toml `file = "drive.csv"` (columns time_s, voltage_V) may stand for the two lists.
    """

    name: ClassVar[str] = "table"

    times_s: tuple[float, ...] = field(
        default=(0.0, 1.0, 3.0, 4.0),
        metadata={
            "items": {"ge": 0, "le": LONGEST_S},
            "min_length": 2,
            "max_length": MOST_ROWS,
            "unit": "s",
            "description": "times, rising from 0",
        },
    )
    voltages_V: tuple[float, ...] = field(
        default=(0.0, 1.0, -1.0, 0.0),
        metadata={
            "items": {"ge": -LARGEST_VOLTAGE_V, "le": LARGEST_VOLTAGE_V},
            "min_length": 2,
            "max_length": MOST_ROWS,
            "unit": "V",
            "description": "voltage at each time",
        },
    )
    held: bool = field(
        default=False,
        metadata={"description": "whether a voltage holds until the next time: stairs, no lines"},
    )
    cycles: int = count(1, "one after the other", at_least=1, repeats=True)

    def check(self) -> None:
        """Raise ScheduleError unless the times rise from 0 and each has a voltage."""
        if len(self.times_s) != len(self.voltages_V):
            raise ScheduleError(
                f"times_s has {len(self.times_s)} entries and voltages_V {len(self.voltages_V)}; "
                "each time needs a voltage"
            )
        if self.times_s[0] != 0.0:
            raise ScheduleError(f"times_s begins at {self.times_s[0]:g} s; it must begin at 0")
        for row, (earlier_s, later_s) in enumerate(pairwise(self.times_s), start=2):
            if later_s <= earlier_s:
                raise ScheduleError(
                    f"time {row} of times_s, {later_s:g} s, does not come after {earlier_s:g} s"
                )
        self.require_length()

    @property
    def length_s(self) -> float:
        """See `Waveform.length_s`."""
        return self.cycles * self.times_s[-1]

    def value_V(self, time_s: float) -> float:
        """See `Waveform.value_V`."""
        within_s = time_s % self.times_s[-1]
        row = min(bisect_right(self.times_s, within_s) - 1, len(self.times_s) - 2)
        begin_V, end_V = self.voltages_V[row], self.voltages_V[row + 1]
        if self.held:
            return begin_V
        share = (within_s - self.times_s[row]) / (self.times_s[row + 1] - self.times_s[row])
        return begin_V + share * (end_V - begin_V)


PROTOCOL = Table
