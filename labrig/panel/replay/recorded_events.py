"""A session's events as they were, made again from its file."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from drivers.interfaces import Frame, Prompt, VoltageWrite
from labrig.session import LoggedEvent, RecordedSession, RunRecord
from labrig.session.format.layout import NOBODY_ANSWERED
from labrig.session.reading.moves import moves_of
from protocols.execution import events as ev
from protocols.execution.events import Outcome, OutputState
from protocols.planning.schedule import PlannedReading

_NO_IMAGE = np.empty((0, 0), dtype=np.uint8)  # a message names a frame, it does not hold it


def events_of(session: RecordedSession) -> list[ev.Event]:
    """In the order of time. What a later version has logged is left out."""
    found = [*_logged(session)]
    for run in session.runs:
        if run.started:
            found += [*_of_run(run, _stopped_s(session, run)), *moves_of(session, run)]
    return sorted(found, key=lambda event: event.time_s)


def _logged(session: RecordedSession) -> Iterator[ev.Event]:
    prompt = Prompt(kind="confirm", text="")
    for line in session.events:
        if line.kind == "asked":
            prompt = Prompt(kind=line.subject, text=line.text)
        way = _LINES.get(line.kind)
        if way is not None:
            yield way(session, line, prompt)


Way = Callable[[RecordedSession, LoggedEvent, Prompt], ev.Event]


def _output(_session: RecordedSession, line: LoggedEvent, _prompt: Prompt) -> ev.Event:
    known = {state.value for state in OutputState}
    state = OutputState(line.subject) if line.subject in known else OutputState.UNKNOWN
    return ev.OutputChanged(line.time_s, state, line.text)


def _marked(_session: RecordedSession, line: LoggedEvent, _prompt: Prompt) -> ev.Event:
    reading = None if line.reading < 0 else line.reading
    return ev.ReadingMarked(
        line.time_s, run=line.run, reading=reading, why=line.text, who=line.subject
    )


def _stopped(session: RecordedSession, line: LoggedEvent, _prompt: Prompt) -> ev.Event:
    known = {outcome.value for outcome in Outcome}
    outcome = Outcome(line.subject) if line.subject in known else Outcome.FAILED
    state = session.output_state
    return ev.SessionStopped(
        line.time_s, outcome=outcome, reason=line.text, output=state, wall=session.ended
    )


_LINES: dict[str, Way] = {
    "started": lambda session, line, _: ev.SessionStarted(line.time_s, session.started),
    "asked": lambda _, line, prompt: ev.OperatorAsked(line.time_s, prompt),
    "answered": lambda _, line, prompt: ev.OperatorAnswered(
        line.time_s, prompt, line.text in ("done", NOBODY_ANSWERED), line.text == NOBODY_ANSWERED
    ),
    "not asked": lambda _, line, __: ev.OperatorNotAsked(
        line.time_s, Prompt(kind=line.subject, text=line.text)
    ),
    "action": lambda _, line, __: ev.ActionTaken(line.time_s, "", line.text),
    "warned": lambda _, line, __: ev.Warned(line.time_s, line.text),
    "output": _output,
    "marked": _marked,
    "stopped": _stopped,
}


def _stopped_s(session: RecordedSession, run: RunRecord) -> float:
    """When a run's acquisition ended; by plan, where nobody wrote it down."""
    index = run.planned.index
    for line in session.events:
        if line.kind == "run stopped" and line.run == index:
            return line.time_s
    return run.time_zero_s + run.planned.duration_s


def _of_run(run: RunRecord, stopped_s: float) -> list[ev.Event]:
    counts, index = run.counts, run.planned.index
    began = ev.RunStarted(
        time_s=run.time_zero_s,
        run=run.planned,
        sample_clock=run.sample_clock,
        channels=tuple(run.channels),
        frame_shape=None,
        stage_position_m=run.stage_position_m,
        since_wetting_s=run.since_wetting_s,
    )
    ended = ev.RunStopped(
        time_s=stopped_s,
        run=index,
        completed=run.completed,
        lost_samples=counts.lost_samples,
        frames_grabbed=counts.frames_grabbed,
        frames_dropped=counts.frames_dropped,
        frames_incomplete=counts.frames_incomplete,
        frames_missed=counts.frames_missed,
    )
    return [began, *_writes(run), *_readings(run), ended]


def _writes(run: RunRecord) -> Iterator[ev.Event]:
    for row in run.writes:
        write = VoltageWrite(
            float(row["sheet_V"]), float(row["board_V"]), float(row["before_s"]),
            float(row["after_s"]),
        )  # fmt: skip
        yield ev.VoltageSet(
            write.after_s,
            run=run.planned.index,
            step=int(row["step"]),
            due_s=float(row["due_s"]),
            write=write,
        )


def _readings(run: RunRecord) -> Iterator[ev.Event]:
    planned = {reading.index: reading for reading in run.planned.readings}
    numbers = run.frame_column("number")
    for row in run.readings_as_taken:
        reading = planned.get(int(row["index"]))
        if reading is not None:
            yield _reading(run, row, reading, numbers)


def _reading(
    run: RunRecord, row: np.void, planned: PlannedReading, numbers: np.ndarray
) -> ev.ReadingTaken:
    sample_s = run.time_zero_s + float(row["time_s"])
    at, offset_s = int(row["frame"]), float(row["frame_offset_s"])
    frame = None
    if 0 <= at < len(numbers):
        frame = Frame(number=int(numbers[at]), time_s=sample_s, device_time_s=None, image=_NO_IMAGE)
    return ev.ReadingTaken(
        time_s=sample_s + planned.half_window_s,  # it was not known before its window was over
        run=run.planned.index,
        planned=planned,
        sample_index=float(row["sample_index"]),
        sample_time_s=sample_s,
        values=run.values(row),
        frame=frame,
        frame_offset_s=None if math.isnan(offset_s) else offset_s,
        valid=bool(row["valid"]),
        why=str(row["why"]),
    )
