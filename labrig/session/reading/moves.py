"""When the load cell was moved during a run, from the session's log."""

from __future__ import annotations

from collections.abc import Iterator

from labrig.session.format.layout import MOVE_BEGAN, MOVE_ENDED
from labrig.session.reading.run_record import RunRecord
from labrig.session.reading.session import RecordedSession
from protocols.execution.events import LoadCellArrived, LoadCellLeft


def moves_of(
    session: RecordedSession, run: RunRecord, shift_s: float = 0.0
) -> Iterator[LoadCellLeft | LoadCellArrived]:
    """Yield the events of a run's move, `shift_s` later than they were recorded."""
    index, move = run.planned.index, run.planned.move
    for row in session.events if move is not None else ():
        if move is None or row.run != index:
            continue
        at_s = row.time_s + shift_s
        if row.kind == MOVE_BEGAN:
            yield LoadCellLeft(at_s, run=index, position_m=move.position_m)
        elif row.kind == MOVE_ENDED:
            reported_m = float(row.subject.split()[0]) / 1e3 if row.subject else None
            yield LoadCellArrived(
                at_s, run=index, position_m=move.position_m, reported_m=reported_m
            )
