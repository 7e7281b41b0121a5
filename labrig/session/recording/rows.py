"""Events as rows for datasets: the only thing that is ever written to a session once it exists.

`EventRows` go both to the file and to the journal, so replaying the journal makes the same file.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from drivers.interfaces import Frame
from labrig.session.format import layout
from labrig.session.format.layout import CONTINUES, NO_RUNS, NOBODY_ANSWERED, Array
from labrig.session.format.setup import SessionSetup
from labrig.session.recording.create import FRAME_COMPRESSION
from labrig.session.recording.nexus import has_scan, scan_columns
from protocols.execution import events as ev
from protocols.execution.channels import Values
from protocols.execution.operator import REPEAT


@dataclass(frozen=True, kw_only=True)
class EventRows:
    """Bytes for one dataset: rows to append at row `at`, or (None) its whole new content."""

    path: str
    at: int | None
    count: int  # rows
    blob: bytes
    packed: bool = False  # deflated: one image, ready to be a chunk

    def array(self, dtype: np.dtype[np.void], row_shape: tuple[int, ...]) -> Array:
        """Return the content as an array of the dataset's type. ValueError when it does not fit."""
        shape = () if self.at is None else (self.count, *row_shape)
        size = dtype.itemsize * math.prod(shape)
        raw = _unpacked(self.blob, size) if self.packed else self.blob
        if len(raw) != size:
            raise ValueError(f"{len(raw)} bytes are no rows of {self.path}")
        return np.frombuffer(raw, dtype=dtype).reshape(shape)


def _unpacked(blob: bytes, size: int) -> bytes:
    """Inflate to at most one byte more than `size`, whatever the blob would make of itself."""
    try:
        return zlib.decompressobj().decompress(blob, size + 1)
    except zlib.error as error:
        raise ValueError(f"a packed image cannot be unpacked ({error})") from None


class Translator:
    """Turns a session's events into rows; knows how many rows each dataset has."""

    def __init__(self, setup: SessionSetup) -> None:
        self._setup = setup
        self._lengths: dict[str, int] = {}
        self._began_s = math.nan  # clock time of the first event: the session's start
        self._started: dict[int, ev.RunStarted] = {}
        self._frames: dict[int, dict[int, int]] = {}  # run -> frame number -> row of its image
        self._ways: dict[type, Callable[[Any], list[EventRows]]] = {
            ev.SessionStarted: self._session_started,
            ev.Resumed: self._resumed,
            ev.OperatorAsked: self._asked,
            ev.OperatorAnswered: self._answered,
            ev.OperatorNotAsked: self._not_asked,
            ev.RunStarted: self._run_started,
            ev.VoltageSet: self._write,
            ev.Controlled: self._controlled,
            ev.SignalsArrived: self._signals,
            ev.ReadingTaken: self._reading,
            ev.FramesArrived: self._frames_arrived,
            ev.LoadCellLeft: self._left,
            ev.LoadCellArrived: self._arrived,
            ev.ReadingMarked: self._marked,
            ev.ActionTaken: self._action_taken,
            ev.OutputChanged: self._output_changed,
            ev.Warned: self._warned,
            ev.RunStopped: self._run_stopped,
            ev.SessionStopped: self._session_stopped,
        }

    def rows(self, event: ev.Event) -> list[EventRows]:
        """Return the rows that record an event, in the order in which they are to be written."""
        way = self._ways.get(type(event))
        if way is None:  # an event of a later version: the log at least knows of it
            return self._log(event, type(event).__name__)
        return way(event)

    # ---------------------------------------------------------------------------------- elements

    def _append(self, path: str, rows: Array) -> EventRows:
        at = self._lengths.get(path, 0)
        self._lengths[path] = at + len(rows)
        return EventRows(
            path=path, at=at, count=len(rows), blob=np.ascontiguousarray(rows).tobytes()
        )

    def _status(self, name: str, text: str) -> EventRows:
        size = layout.STATUS_TEXTS[name]
        value = np.array(layout.cut(text, size), dtype=f"S{size}")
        return EventRows(path=f"{layout.ENTRY}/{name}", at=None, count=1, blob=value.tobytes())

    def _log(
        self,
        event: ev.Event,
        kind: str,
        text: str = "",
        *,
        run: int = -1,
        reading: int = -1,
        subject: str = "",
    ) -> list[EventRows]:
        parts = layout.pieces(text, layout.EVENT_TEXT_BYTES)
        rows = np.zeros(len(parts), dtype=layout.EVENT_ROW)
        rows["time_s"], rows["run"], rows["reading"] = event.time_s, run, reading
        rows["kind"], rows["subject"] = layout.MORE.encode(), layout.cut(subject, 24)
        rows["kind"][0] = layout.cut(kind, 24)
        rows["text"] = parts
        return [self._append(layout.EVENTS, rows)]

    # ----------------------------------------------------------------------------------- session

    def _session_started(self, event: ev.SessionStarted) -> list[EventRows]:
        if math.isnan(self._began_s):  # else it continues a session, whose readings came before
            self._began_s = event.time_s
        return [self._status("start_time", event.wall), *self._log(event, "started")]

    def _resumed(self, event: ev.Resumed) -> list[EventRows]:
        self._began_s = event.time_s
        runs = ", ".join(str(run + 1) for run in event.runs) or NO_RUNS
        text = CONTINUES.format(event.identifier, runs)
        return self._log(event, "resumed", text)

    def _asked(self, event: ev.OperatorAsked) -> list[EventRows]:
        return self._log(event, "asked", event.prompt.text, subject=event.prompt.kind)

    def _answered(self, event: ev.OperatorAnswered) -> list[EventRows]:
        said = "done" if event.done else "again" if event.prompt.kind == REPEAT else "stop"
        if event.expired:
            said = NOBODY_ANSWERED
        return self._log(event, "answered", said, subject=event.prompt.kind)

    def _not_asked(self, event: ev.OperatorNotAsked) -> list[EventRows]:
        return self._log(event, "not asked", event.prompt.text, subject=event.prompt.kind)

    def _action_taken(self, event: ev.ActionTaken) -> list[EventRows]:
        return self._log(event, "action", f"{event.who} {event.what}")

    def _warned(self, event: ev.Warned) -> list[EventRows]:
        return self._log(event, "warned", event.text)

    def _output_changed(self, event: ev.OutputChanged) -> list[EventRows]:
        status = self._status("output_state", event.state.value)
        return [status, *self._log(event, "output", event.why, subject=event.state.value)]

    def _session_stopped(self, event: ev.SessionStopped) -> list[EventRows]:
        return [
            self._status("output_state", event.output.value),
            self._status("end_time", event.wall),
            self._status("reason", event.reason),
            *self._log(event, "stopped", event.reason, subject=event.outcome.value),
            self._status("outcome", event.outcome.value),
        ]

    # -------------------------------------------------------------------------------------- runs

    def _run_started(self, event: ev.RunStarted) -> list[EventRows]:
        index = event.run.index
        self._started[index] = event
        self._frames[index] = {}
        name = event.run.configuration
        place = "free" if event.run.position_m is None else f"{event.run.position_m * 1000:g} mm"
        if event.run.extra:
            place += f", {event.run.in_words}"
        again = event.run.repeats
        more = "" if again is None else f", run {again + 1} again"
        state = self._acquisition(event)
        return [state, *self._log(event, "run started", f"{name}, {place}{more}", run=index)]

    def _run_stopped(self, event: ev.RunStopped) -> list[EventRows]:
        started = self._started[event.run]
        text = "completed" if event.completed else "not completed"
        state = self._acquisition(started, event)
        return [state, *self._log(event, "run stopped", text, run=event.run)]

    def _acquisition(self, event: ev.RunStarted, stopped: ev.RunStopped | None = None) -> EventRows:
        row = np.zeros((), dtype=layout.acquisition_row(self._setup.version))
        clock = event.sample_clock
        row["started"] = True
        row["time_zero_s"] = event.time_s
        row["clock_start_s"] = clock.start_s
        row["clock_start_uncertainty_s"] = clock.start_uncertainty_s
        row["rate_hz"] = clock.rate_hz
        row["stage_position_m"] = _or_nan(event.stage_position_m)
        row["since_wetting_s"] = _or_nan(event.since_wetting_s)
        if stopped is not None:
            row["stopped"] = True
            row["completed"] = stopped.completed
            row["lost_samples"] = stopped.lost_samples
            row["frames_grabbed"] = stopped.frames_grabbed
            row["frames_dropped"] = stopped.frames_dropped
            if self._setup.version >= layout.TRIGGERS_SINCE:
                row["frames_incomplete"] = stopped.frames_incomplete
                row["frames_missed"] = stopped.frames_missed
        return EventRows(
            path=f"{layout.run_path(event.run.index)}/acquisition",
            at=None,
            count=1,
            blob=row.tobytes(),
        )

    def _write(self, event: ev.VoltageSet) -> list[EventRows]:
        started = self._started[event.run]
        write = event.write
        middle = (write.before_s + write.after_s) / 2
        row = np.zeros(1, dtype=layout.WRITE_ROW)
        row["step"] = event.step
        row["planned_s"] = started.run.steps[event.step].time_s
        row["due_s"], row["before_s"], row["after_s"] = event.due_s, write.before_s, write.after_s
        row["lateness_s"] = middle - event.due_s
        row["sample_index"] = started.sample_clock.index_at(middle)
        row["sheet_V"], row["board_V"] = write.sheet_V, write.board_V
        return [self._append(f"{layout.run_path(event.run)}/writes", row)]

    def _controlled(self, event: ev.Controlled) -> list[EventRows]:
        started = self._started[event.run]
        rows = np.zeros(len(event.periods), dtype=layout.CONTROL_ROW)
        rows["zero_N"] = event.zero_N
        for row, period in zip(rows, event.periods, strict=True):
            write = period.write
            row["planned_s"], row["due_s"] = period.due_s - started.time_s, period.due_s
            row["before_s"], row["after_s"] = write.before_s, write.after_s
            row["sample_index"] = period.sample_index
            row["reference_N"], row["force_N"] = period.reference_N, period.force_N
            row["wanted_V"] = period.wanted_V
            row["sheet_V"], row["board_V"] = write.sheet_V, write.board_V
        return [self._append(f"{layout.run_path(event.run)}/control", rows)]

    def _signals(self, event: ev.SignalsArrived) -> list[EventRows]:
        started, volts = self._started[event.run], event.block.volts
        have = self._lengths.get(layout.signal_path(event.run, "time"), 0)
        gap = event.block.first_index - have
        if gap < 0:
            raise ValueError(f"samples {event.block.first_index} to {have} of a run came twice")
        # A row is a sample index, so samples that never came leave their rows as NaN.
        if gap:
            volts = np.hstack([np.full((len(volts), gap), np.nan), volts])
        index = np.arange(have, have + volts.shape[1], dtype=np.float64)
        clock = started.sample_clock
        time_s = clock.start_s + index / clock.rate_hz - started.time_s
        columns = zip(self._setup.channels, volts, strict=True)
        rows = [
            self._append(layout.signal_path(event.run, name), np.asarray(column, dtype=np.float64))
            for name, column in columns
        ]
        return [*rows, self._append(layout.signal_path(event.run, "time"), time_s)]

    def _frame(self, run: int, frame: Frame, reading: int | None) -> list[EventRows]:
        known = self._frames[run]
        if frame.number in known or self._setup.frame_shape is None:
            return []
        started = self._started[run]
        if frame.image.shape != self._setup.frame_shape:
            raise ValueError(
                f"a frame of {frame.image.shape} pixels came from a camera of "
                f"{self._setup.frame_shape}"
            )
        known[frame.number] = len(known)
        path = layout.frame_path(run, "images")
        at = self._lengths.get(path, 0)
        self._lengths[path] = at + 1
        image = np.ascontiguousarray(frame.image, dtype=self._setup.frame_dtype)
        packed = _deflated(image)
        values: dict[str, float] = {
            "time": frame.time_s - started.time_s,
            "number": frame.number,
            "device_time": _or_nan(frame.device_time_s),
            "sample_index": started.sample_clock.index_at(frame.time_s),
            "reading": layout.NO_FRAME if reading is None else reading,
            "device_number": -1 if frame.device_number is None else frame.device_number,
            "trigger_time": _or_nan(frame.trigger_s) - started.time_s,
        }
        columns = [
            self._append(layout.frame_path(run, name), np.array([values[name]], dtype=kind))
            for name, (kind, _) in layout.frame_columns(self._setup.version).items()
        ]
        return [EventRows(path=path, at=at, count=1, blob=packed, packed=True), *columns]

    def _frames_arrived(self, event: ev.FramesArrived) -> list[EventRows]:
        return [rows for frame in event.frames for rows in self._frame(event.run, frame, None)]

    def _left(self, event: ev.LoadCellLeft) -> list[EventRows]:
        text = f"for {1e3 * event.position_m:g} mm"
        return self._log(event, layout.MOVE_BEGAN, text, run=event.run)

    def _arrived(self, event: ev.LoadCellArrived) -> list[EventRows]:
        text = f"at {1e3 * event.position_m:g} mm"
        reported = "" if event.reported_m is None else f"{1e3 * event.reported_m:.4f} mm"
        if reported:
            text += f"; the stage reports {reported}"
        return self._log(event, layout.MOVE_ENDED, text, run=event.run, subject=reported)

    def _reading(self, event: ev.ReadingTaken) -> list[EventRows]:
        started, planned = self._started[event.run], event.planned
        images: list[EventRows] = []
        frame = layout.NO_FRAME
        if event.frame is not None and self._setup.frame_shape is not None:
            images = self._frame(event.run, event.frame, planned.index)
            frame = self._frames[event.run][event.frame.number]
        row = np.zeros(1, dtype=self._setup.reading_row)
        row["index"], row["step"], row["kind"] = planned.index, planned.step, planned.kind.encode()
        row["voltage_V"] = planned.voltage_V
        row["planned_s"] = started.run.time_of(planned)
        row["time_s"] = event.sample_time_s - started.time_s
        row["sample_index"] = event.sample_index
        for column, value in self._values(event.values):
            row[column] = value
        row["frame"], row["frame_offset_s"] = frame, _or_nan(event.frame_offset_s)
        row["valid"], row["why"] = event.valid, layout.cut(event.why, 240)
        rows = [*images, self._append(f"{layout.run_path(event.run)}/readings", row)]
        rows += self._scan(row[0], event.run, started, event.sample_time_s - self._began_s)
        if not event.valid:
            rows += self._log(event, "lost", event.why, run=event.run, reading=planned.index)
        return rows

    def _scan(
        self, reading: np.void, run: int, started: ev.RunStarted, session_s: float
    ) -> list[EventRows]:
        """Rows of the columns of all readings."""
        if not has_scan(self._setup):
            return []
        values: dict[str, float] = {
            "time_s": session_s,
            "voltage_V": reading["voltage_V"],
            "position_m": _or_nan(started.run.position_m),
            "run": run,
            "reading": reading["index"],
            "valid": reading["valid"],
        } | {column: reading[column] for column in self._setup.value_columns}
        types = scan_columns(self._setup)
        paths = {layout.scan_path(name): value for name, value in values.items()}
        return [
            self._append(path, np.array([value], dtype=types[path]))
            for path, value in paths.items()
        ]

    def _values(self, values: Values) -> Iterator[tuple[str, float]]:
        """Yield what each column of the channels holds; NaN where the reading has no value."""
        columns = self._setup.value_columns
        unknown = sorted(values.keys() - set(columns))
        if unknown:
            raise ValueError(f"a reading has a value {unknown[0]}, for which there is no channel")
        for column in columns:
            yield column, values.get(column, math.nan)

    def _marked(self, event: ev.ReadingMarked) -> list[EventRows]:
        row = np.zeros(1, dtype=layout.MARK_ROW)
        reading = -1 if event.reading is None else event.reading
        row["time_s"], row["reading"] = event.time_s, reading
        row["why"], row["who"] = layout.cut(event.why, 240), layout.cut(event.who, 64)
        mark = self._append(f"{layout.run_path(event.run)}/marks", row)
        log = self._log(
            event, "marked", event.why, run=event.run, reading=reading, subject=event.who
        )
        return [mark, *log]


def _deflated(image: Array) -> bytes:
    """Return a zlib stream of an image, as any HDF5 reader unpacks it.

    Camera noise has no strings that come again: not to look for any but runs of one value takes
    two thirds of the time, and the result is a tenth smaller.
    """
    packer = zlib.compressobj(FRAME_COMPRESSION, strategy=zlib.Z_RLE)
    return packer.compress(image.data) + packer.flush()


def _or_nan(value: float | None) -> float:
    return float("nan") if value is None else value
