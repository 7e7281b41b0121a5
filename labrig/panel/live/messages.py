"""A session's events as the messages that pages understand.

The messages: docs/reference/panel_messages.md.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from math import degrees, nan
from typing import Any

from drivers.interfaces import Prompt
from labrig.panel.live.strip_rows import rows_message, strip_rows
from protocols import describe, free_shapes_in_words
from protocols.execution import events as ev
from protocols.execution.channels import CURRENT_A, DRIVE_V, FORCE_N, Channel
from protocols.execution.operator import REPEAT
from protocols.planning.schedule import PlannedRun, Schedule

Message = dict[str, Any]


class MessageEncoder:
    """Encode the events of one session. Not thread-safe; events come in order."""

    def __init__(self) -> None:
        self._begun_s: float | None = None
        self._zero_s: dict[int, float] = {}  # clock time of each run's time 0
        self._asked = 0
        self._ways: dict[type, Callable[[Any], Message]] = {
            ev.SessionStarted: self._started,
            ev.OperatorAsked: lambda event: self.asked(event.time_s, event.prompt)[1],
            ev.OperatorAnswered: lambda event: self.answered(
                event.time_s, event.done, event.prompt.kind, expired=event.expired
            ),
            ev.OperatorNotAsked: self._not_asked,
            ev.RunStarted: self._run_started,
            ev.VoltageSet: self._voltage,
            ev.ReadingTaken: self._reading,
            ev.LoadCellLeft: lambda event: self._moved(event, "leaves for"),
            ev.LoadCellArrived: lambda event: self._moved(event, "is at"),
            ev.ReadingMarked: self._marked,
            ev.ActionTaken: self._action,
            ev.OutputChanged: self._output,
            ev.Warned: self._warned,
            ev.RunStopped: self._run_stopped,
            ev.SessionStopped: self._stopped,
        }

    def message(self, event: ev.Event) -> Message | None:
        """Return an event's message; None: it shows elsewhere (signals, images) or not at all."""
        way = self._ways.get(type(event))
        return None if way is None else way(event)

    def asked(self, time_s: float, prompt: Prompt) -> tuple[int, Message]:
        """Return a prompt, and the number by which it is answered."""
        self._asked += 1
        return self._asked, {
            "type": "prompt",
            "time_s": self.since_begin(time_s),
            "prompt": self._asked,
            "kind": prompt.kind,
            "text": prompt.text,
            "configuration": prompt.configuration,
            "position_mm": _milli(prompt.position_m),
            "load_mN": _milli(prompt.load_N),
            "log": prompt.text,
        }

    def _not_asked(self, event: ev.OperatorNotAsked) -> Message:
        return {
            "type": "not_asked",
            "time_s": self.since_begin(event.time_s),
            "kind": event.prompt.kind,
            "text": event.prompt.text,
            "log": f"not asked: {event.prompt.text}",
        }

    def answered(self, time_s: float, done: bool, kind: str, *, expired: bool = False) -> Message:
        """Return the message that the last prompt, of this kind, was answered, or `expired`."""
        said = answer_text(kind, done)
        return {
            "type": "answered",
            "time_s": self.since_begin(time_s),
            "prompt": self._asked,
            "done": done,
            "log": f"nobody answered: {said}" if expired else f"answered: {said}",
        }

    def since_begin(self, time_s: float) -> float:
        """Session time of a clock time."""
        return round(time_s - (time_s if self._begun_s is None else self._begun_s), 6)

    def run_s(self, run: int, time_s: float) -> float:
        """Time within a run of a clock time."""
        return round(time_s - self._zero_s.get(run, time_s), 6)

    # ------------------------------------------------------------------------------------- events

    def _started(self, event: ev.SessionStarted) -> Message:
        self._begun_s = event.time_s
        return {"type": "started", "wall": event.wall, "log": f"the session begins, {event.wall}"}

    def _run_started(self, event: ev.RunStarted) -> Message:
        run = event.run
        self._zero_s[run.index] = event.time_s
        where = "free" if run.position_m is None else f"{1e3 * run.position_m:g} mm"
        if run.extra:
            where += f", {run.in_words}"
        again = "" if run.repeats is None else f", run {run.repeats + 1} again"
        return {
            "type": "run_started",
            "time_s": self.since_begin(event.time_s),
            "run": run.index,
            "stage_position_mm": _milli(event.stage_position_m),
            "since_wetting_s": event.since_wetting_s,
            "log": f"run {run.index + 1} begins: {run.configuration}, {where}{again}",
        }

    def _moved(self, event: ev.LoadCellLeft | ev.LoadCellArrived, what: str) -> Message:
        position_mm = 1e3 * event.position_m
        return {
            "type": "load_cell",
            "time_s": self.since_begin(event.time_s),
            "run": event.run,
            "position_mm": position_mm,
            "log": f"the load cell {what} {position_mm:g} mm",
        }

    def _voltage(self, event: ev.VoltageSet) -> Message:
        middle_s = 0.5 * (event.write.before_s + event.write.after_s)
        return {
            "type": "voltage",
            "time_s": self.since_begin(middle_s),
            "run": event.run,
            "run_s": self.run_s(event.run, middle_s),
            "step": event.step,
            "sheet_V": event.write.sheet_V,
            "late_ms": round(1e3 * (middle_s - event.due_s), 3),
        }

    def _reading(self, event: ev.ReadingTaken) -> Message:
        planned, frame = event.planned, event.frame
        offset_s = event.frame_offset_s
        message = {
            "type": "reading",
            "time_s": self.since_begin(event.sample_time_s),
            "run": event.run,
            "run_s": self.run_s(event.run, event.sample_time_s),
            "index": planned.index,
            "step": planned.step,
            "kind": planned.kind.value,
            "voltage_V": planned.voltage_V,
            "force_mN": 1e3 * event.values[FORCE_N],
            "drive_V": event.values[DRIVE_V],
            "current_mA": 1e3 * event.values.get(CURRENT_A, nan),
            "values": dict(event.values),
            "frame": None if frame is None else frame.number,
            "frame_offset_ms": None if offset_s is None else round(1e3 * offset_s, 3),
            "valid": event.valid,
            "why": event.why,
        }
        if event.valid:
            return message
        which = f"reading {planned.index + 1} of run {event.run + 1}"
        return {**message, "log": f"{which} ({planned.voltage_V:+g} V) does not count: {event.why}"}

    def _marked(self, event: ev.ReadingMarked) -> Message:
        what = f"run {event.run + 1}"
        if event.reading is not None:
            what = f"reading {event.reading + 1} of {what}"
        return {
            "type": "marked",
            "time_s": self.since_begin(event.time_s),
            "run": event.run,
            "reading": event.reading,
            "why": event.why,
            "who": event.who,
            "log": f"{what} is marked invalid by {event.who}: {event.why}",
        }

    def _action(self, event: ev.ActionTaken) -> Message:
        return {
            "type": "action",
            "time_s": self.since_begin(event.time_s),
            "who": event.who,
            "what": event.what,
            "log": f"{event.who} {event.what}".strip(),
        }

    def _output(self, event: ev.OutputChanged) -> Message:
        return {
            "type": "output",
            "time_s": self.since_begin(event.time_s),
            "state": event.state.value,
            "why": event.why,
            "log": f"output {event.state.value.upper()}: {event.why}",
        }

    def _warned(self, event: ev.Warned) -> Message:
        time_s = self.since_begin(event.time_s)
        return {"type": "warning", "time_s": time_s, "text": event.text, "log": event.text}

    def _run_stopped(self, event: ev.RunStopped) -> Message:
        how = "is complete" if event.completed else "was broken off"
        lost = f"; {event.losses}" if event.losses else ""
        return {
            "type": "run_stopped",
            "time_s": self.since_begin(event.time_s),
            "run": event.run,
            "completed": event.completed,
            "lost_samples": event.lost_samples,
            "frames_grabbed": event.frames_grabbed,
            "frames_dropped": event.frames_dropped,
            "frames_incomplete": event.frames_incomplete,
            "frames_missed": event.frames_missed,
            "log": f"run {event.run + 1} {how}{lost}",
        }

    def _stopped(self, event: ev.SessionStopped) -> Message:
        return {
            "type": "ended",
            "time_s": self.since_begin(event.time_s),
            "outcome": event.outcome.value,
            "reason": event.reason,
            "output": event.output.value,
            "wall": event.wall,
            "log": f"{event.outcome.value}: {event.reason}; output {event.output.value.upper()}",
        }


def answer_text(kind: str, done: bool) -> str:
    """Return an operator's answer to a prompt of this kind in words."""
    if kind == REPEAT:
        return "go on" if done else "measure it again"
    return "done" if done else "stop the session"


def plan_message(
    schedule: Schedule,
    *,
    clock: str,
    session: str | None,
    simulated: bool,
    limits: Message,
    picture: Message | None,
    channels: Sequence[Channel],
    done: Collection[int] = (),
    warnings: Sequence[str] = (),
) -> Message:
    """Return what is going to be done, for the timeline."""
    found = describe(schedule)
    rows = {row.run: row for row in found.rows}
    return {
        "type": "plan",
        "protocol": schedule.protocol,
        "clock": clock,
        "session": session,
        "simulated": simulated,
        "limits": limits,
        "estimate_s": found.estimate_s,
        "running_s": found.running_s,
        "frame_rate_hz": schedule.frame_rate_hz,
        "picture": picture,
        "channels": rows_message(strip_rows(channels)),
        "done": sorted(done),
        "free_shapes": free_shapes_in_words(schedule),
        "warnings": list(warnings),
        "runs": [
            {
                "starts_s": rows[run.index].starts_s,
                "under_voltage_s": rows[run.index].under_voltage_s,
                "prompts": list(rows[run.index].prompts),
                **_run(run),
            }
            for run in schedule.runs
        ],
        "repeats": [_run(run) for run in schedule.repeats],
    }


def _run(run: PlannedRun) -> Message:
    return {
        "run": run.index,
        "repeats": run.repeats,
        "purpose": run.purpose.value,
        "extra": run.extra,
        "configuration": run.configuration,
        "position_mm": _milli(run.position_m),
        "mounting": run.mounting,
        "approach": run.approach,
        "moisten": run.moisten,
        "load_mN": _milli(run.load_N),
        "tilt_deg": round(degrees(run.tilt_rad), 9),
        "duration_s": run.duration_s,
        "steps": [[round(step.time_s, 6), step.voltage_V] for step in run.steps],
        "readings": [
            [r.index, round(run.time_of(r), 6), r.voltage_V, r.kind.value] for r in run.readings
        ],
    }


def _milli(value: float | None) -> float | None:
    return None if value is None else round(1e3 * value, 9)
