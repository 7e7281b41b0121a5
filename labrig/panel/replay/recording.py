"""What a replay needs of a session: its messages by their time, its signals and pictures."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from drivers.interfaces import Frame
from labrig.config import parse_sheet
from labrig.errors import BadInputError
from labrig.panel.live.event_stream import Message, Picture
from labrig.panel.live.frames import raw_picture
from labrig.panel.live.messages import MessageEncoder, plan_message
from labrig.panel.live.optics_message import setup_message
from labrig.panel.live.plans import optics_message
from labrig.panel.live.strip_chart import BIN_S, KEEP_S, Envelope, StripChart
from labrig.panel.live.strip_rows import strip_rows, strip_samples
from labrig.panel.replay.recorded_events import events_of
from labrig.panel.replay.recorded_values import is_known, recorded_values
from labrig.panel.replay.stored_curves import StoredCurves
from labrig.session import RecordedSession, RunRecord, open_session
from labrig.vision import Optics
from protocols.execution import events as ev

_NOT_MARKED = {"voltage", "reading", "output", "action", "answered"}


# A reading's image is there by then, and a step to the reading shows it.
SHOWN_AFTER_S = 0.1


@dataclass(frozen=True)
class Span:
    """One run on the session's own time."""

    run: int
    from_s: float
    to_s: float


class Recording:
    """An open session. One thread uses it."""

    def __init__(self, path: Path, name: str) -> None:
        """Open a session. Raises BadInputError when it cannot be replayed."""
        self.name = name
        self._session = open_session(path, live=True)
        try:
            self._prepare()
        except BaseException:
            self._session.close()
            raise

    def close(self) -> None:
        """Let go of the file."""
        self._session.close()

    def _prepare(self) -> None:
        session = self._session
        events = events_of(session)
        if not events:
            raise BadInputError(f"{self.name}: nothing of it was recorded over time.")
        if "load_cell.toml" not in session.texts or "rig" not in session.resolved:
            raise BadInputError(
                f"{self.name}: holds no rig and no load cell; only a session that labrig has "
                "recorded can be replayed."
            )
        self._begin_s = events[0].time_s
        encoder = MessageEncoder()
        timed = [(event.time_s - self._begin_s, encoder.message(event)) for event in events]
        self.timed = [(at_s, message) for at_s, message in timed if message is not None]
        self._times = [at_s for at_s, _ in self.timed]
        self.duration_s = self._times[-1]
        self.spans = _spans(events, self._begin_s)
        self.plan = _plan(session, self.name)
        self.setup = setup_message(_optics(session), _sheets(session))
        self._strips: tuple[int, StripChart] | None = None
        self._frames = self._all_frames()
        self._frame_times = [at_s for at_s, _, _ in self._frames]
        self._curves = StoredCurves(session, session.path, _optics(session))

    def marks(self) -> list[Message]:
        """Return what a slider shows: runs, readings, and what was logged."""
        found = []
        for at_s, message in self.timed:
            if message["type"] == "run_started":
                found.append({"at_s": at_s, "kind": "run", "text": message["log"]})
            elif message["type"] == "reading":
                found.append({"at_s": at_s, "kind": "reading", "text": "", **_of_reading(message)})
            elif "log" in message and message["type"] not in _NOT_MARKED:
                found.append({"at_s": at_s, "kind": "log", "text": message["log"]})
        return found

    @property
    def first_s(self) -> float:
        """When the first reading and its image are there; the beginning where there is none."""
        of_readings = (at_s for at_s, message in self.timed if message["type"] == "reading")
        return min(next(of_readings, -SHOWN_AFTER_S) + SHOWN_AFTER_S, self.duration_s)

    def story(self, at_s: float) -> list[Message]:
        """All that had happened by then."""
        return [
            self.plan,
            *(message for _, message in self.timed[: bisect_right(self._times, at_s)]),
        ]

    def between(self, after_s: float, to_s: float) -> list[Message]:
        """Return what happened in this time, its end included."""
        first, last = bisect_right(self._times, after_s), bisect_right(self._times, to_s)
        return [message for _, message in self.timed[first:last]]

    def strip(self, after_s: float, to_s: float, *, fresh: bool) -> StripChart | None:
        """Return the signals of this time; of the run at its end, where there are several."""
        span = self.span_at(to_s)
        if span is None:
            return None
        whole = self._whole_strip(span.run)
        zero_s = self._session.run(span.run).time_zero_s - self._begin_s
        times = whole.values[0]
        new = fresh or after_s < span.from_s
        from_s = to_s - KEEP_S if fresh else after_s
        # a bin is known when it is over
        low, high = np.searchsorted(times + BIN_S / 2, [from_s - zero_s, to_s - zero_s], "right")
        if low >= high:
            return None
        return replace(whole, values=whole.values[:, low:high], fresh=new)

    def span_at(self, at_s: float) -> Span | None:
        """Return the run that is on, or was the last one to be."""
        begun = [span for span in self.spans if span.from_s <= at_s]
        return begun[-1] if begun else None

    def next_s(self, at_s: float) -> float | None:
        """When something happens next; now, while a run is on."""
        span = self.span_at(at_s)
        if span is not None and at_s < span.to_s:
            return at_s
        following = [span.from_s for span in self.spans if span.from_s > at_s]
        at = bisect_right(self._times, at_s)
        following += self._times[at : at + 1]
        return min(following, default=None)

    def picture(self, after_s: float, to_s: float) -> Picture | None:
        """Return the newest picture of this time."""
        at = bisect_right(self._frame_times, to_s) - 1
        if at < 0 or self._frame_times[at] <= after_s:
            return None
        at_s, run_index, row = self._frames[at]
        run = self._session.run(run_index)
        number = int(run.frame_column("number")[row])
        frame = Frame(number=number, time_s=at_s, device_time_s=None, image=run.image(row))
        voltage_V = self._voltage_at(run, at_s)
        force_mN = self._force_at(run_index, voltage_V, at_s)
        return raw_picture(frame, at_s, run.planned, voltage_V, force_mN=force_mN)

    def _force_at(self, run: int, voltage_V: float, at_s: float) -> float | None:
        """Return the force of the last good reading of the run at this voltage, in mN."""
        for _, message in reversed(self.timed[: bisect_right(self._times, at_s)]):
            if message["type"] == "run_started":
                return None
            if (
                message["type"] == "reading"
                and message["run"] == run
                and message["valid"]
                and message["voltage_V"] == voltage_V
            ):
                return float(message["force_mN"])
        return None

    def stored_curve(self, after_s: float, to_s: float) -> Message | None:
        """Return the curve that the analysis has found in the newest picture of this time."""
        at = bisect_right(self._frame_times, to_s) - 1
        if at < 0 or self._frame_times[at] <= after_s:
            return None
        at_s, run_index, row = self._frames[at]
        run = self._session.run(run_index)
        if int(run.frame_column("reading")[row]) < 0:
            return None
        number = int(run.frame_column("number")[row])
        return self._curves.message(number, run_index, at_s)

    def _voltage_at(self, run: RunRecord, at_s: float) -> float:
        writes = run.writes
        at = int(np.searchsorted(writes["after_s"], at_s + self._begin_s, "right")) - 1
        return float(writes["sheet_V"][at]) if at >= 0 else 0.0

    def _all_frames(self) -> list[tuple[float, int, int]]:
        """Time, run and row of every picture."""
        found = []
        for run in self._session.runs:
            if run.started:
                zero_s = run.time_zero_s - self._begin_s
                times = run.frame_column("time")
                found += [(zero_s + float(t), run.planned.index, i) for i, t in enumerate(times)]
        return sorted(found)

    def _whole_strip(self, run: int) -> StripChart:
        if self._strips is None or self._strips[0] != run:
            self._strips = (run, _strip_of(self._session, self._session.run(run)))
        return self._strips[1]


def _of_reading(message: Message) -> Message:
    return {key: message[key] for key in ("run", "index", "voltage_V")}


def _spans(events: list[ev.Event], begin_s: float) -> list[Span]:
    from_s: dict[int, float] = {}
    found = []
    for event in events:
        if isinstance(event, ev.RunStarted):
            from_s[event.run.index] = event.sample_clock.start_s - begin_s
        elif isinstance(event, ev.RunStopped) and event.run in from_s:
            found.append(Span(event.run, from_s[event.run], event.time_s - begin_s))
    return sorted(found, key=lambda span: span.from_s)


def _strip_of(session: RecordedSession, run: RunRecord) -> StripChart:
    """Return all signals of a run, in the units of its rows."""
    values = recorded_values(session, run)
    rows = strip_rows([channel for channel in run.signals if channel.name in values])
    keys = tuple(row.key for row in rows)
    found = Envelope(run.planned.index, keys).add(strip_samples(rows, run.time_s, values))
    empty = np.empty((1 + 2 * len(keys), 0), dtype=np.float32)
    return found or StripChart(run=run.planned.index, keys=keys, values=empty)


def _plan(session: RecordedSession, name: str) -> Message:
    rig: dict[str, Any] = session.resolved.get("rig", {})
    limits = rig.get("limits", {})
    capacity_N = session.resolved.get("load_cell", {}).get("capacity_N")
    plan = plan_message(
        session.schedule,
        clock="replay",
        session=name,
        simulated=session.simulated,
        limits={
            "sheet_voltage_V": limits.get("sheet_voltage_V"),
            "time_under_voltage_s": limits.get("time_under_voltage_s"),
            "capacity_mN": None if capacity_N is None else 1e3 * capacity_N,
        },
        picture=optics_message(_optics(session)),
        channels=[each for each in session.signals if is_known(session, each)],
    )
    return {**plan, "recorded_clock": session.clock}


def _optics(session: RecordedSession) -> Optics | None:
    text = session.texts.get("optics.json")
    return None if text is None else Optics.from_json(text)


def _sheets(session: RecordedSession) -> Any:
    text = session.texts.get("sheet.toml")
    return {} if text is None else parse_sheet(text, f"{session.path}: sheet.toml")
