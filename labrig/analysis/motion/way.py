"""How a load cell goes from one position to another during a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drivers.interfaces import FloatArray
from labrig.session import RecordedSession, RunRecord
from labrig.session.reading.moves import moves_of
from protocols.execution.events import LoadCellArrived, LoadCellLeft


@dataclass(frozen=True, kw_only=True)
class Way:
    """The load cell's way to another position: the smoothest (minimum jerk) in its time."""

    from_m: float
    to_m: float
    left_s: float
    arrived_s: float

    @staticmethod
    def of(session: RecordedSession, run: RunRecord, begin_s: float) -> Way | None:
        """Return the way as the log has it; None where the load cell rests."""
        zero_s, move = run.time_zero_s + begin_s, run.planned.move
        left = arrived = None
        for event in moves_of(session, run):
            if isinstance(event, LoadCellLeft):
                left = event
            elif isinstance(event, LoadCellArrived):
                arrived = event
        if move is None or left is None or arrived is None or run.planned.position_m is None:
            return None
        return Way(
            from_m=run.planned.position_m, to_m=move.position_m, left_s=left.time_s - zero_s,
            arrived_s=max(arrived.time_s, left.time_s + 1e-3) - zero_s,
        )  # fmt: skip

    def at(self, time_s: FloatArray) -> FloatArray:
        """Return the position at each time."""
        u = np.clip((time_s - self.left_s) / (self.arrived_s - self.left_s), 0.0, 1.0)
        return self.from_m + (self.to_m - self.from_m) * u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
