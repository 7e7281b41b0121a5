"""Follows a run: its events become messages, strips of signals, pictures."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from drivers.interfaces import Frame
from labrig.experiment.rig.rig import Rig
from labrig.panel.job.preview import Preview
from labrig.panel.live.event_stream import EventStream
from labrig.panel.live.frames import exposure_time, raw_picture
from labrig.panel.live.messages import MessageEncoder
from labrig.panel.live.strip_chart import Envelope
from labrig.panel.live.strip_rows import StripRow, strip_rows, strip_samples
from protocols.execution import events as ev
from protocols.execution.channels import FORCE_N
from protocols.execution.scheduler import Scheduler
from protocols.execution.states import RunState


class Follower:
    """Subscribe to a run's events. `asks_itself`: whoever asks a prompt publishes it."""

    def __init__(self, stream: EventStream, encoder: MessageEncoder, *, asks_itself: bool) -> None:
        self._stream = stream
        self._encoder = encoder
        self._left_out: tuple[type, ...] = ()
        if asks_itself:
            self._left_out = (ev.OperatorAsked, ev.OperatorAnswered)
        self._rig: Rig | None = None
        self._preview: Preview | None = None
        self._state: tuple[RunState, int | None] | None = None
        self._run: ev.RunStarted | None = None
        self._envelope: Envelope | None = None
        self._rows: tuple[StripRow, ...] = ()
        self._sheet_V = 0.0
        self._forces_mN: dict[float, float] = {}  # by voltage: of the last good reading of the run
        self.scheduler: Scheduler | None = None
        self.on_begin: Callable[[], None] = lambda: None  # called once, after SessionStarted
        self.going = False  # between the session's first event and its last

    def attach(self, rig: Rig, preview: Preview | None) -> None:
        """Set the rig that is followed."""
        self._rig, self._preview = rig, preview

    def __call__(self, event: ev.Event) -> None:
        """See `protocols.execution.event_bus`."""
        if isinstance(event, ev.SessionStopped):
            self.going = False
        self._note(event)
        if not isinstance(event, self._left_out):
            message = self._encoder.message(event)
            if message is not None:
                self._stream.publish(message)
        self.publish_state()
        if isinstance(event, ev.SignalsArrived):
            self._signals(event)
        if isinstance(event, ev.ReadingTaken) and self._preview is None and event.frame is not None:
            self._picture(event.frame, event.planned.voltage_V)
        elif self._preview is not None and (frame := self._preview.newest()) is not None:
            self._picture(frame, self._sheet_V)
        if isinstance(event, ev.SessionStarted):
            self.going = True
            self.on_begin()

    def _note(self, event: ev.Event) -> None:
        if isinstance(event, ev.RunStarted):
            self._run = event
            if self._rig is not None:
                self._rows = strip_rows(self._rig.devices().rows().channels)
            self._envelope = Envelope(event.run.index, [row.key for row in self._rows])
            self._forces_mN = {}
        elif isinstance(event, ev.VoltageSet):
            self._sheet_V = event.write.sheet_V
        elif isinstance(event, ev.ReadingTaken) and event.valid:
            self._forces_mN[event.planned.voltage_V] = 1e3 * event.values[FORCE_N]

    def publish_state(self) -> None:
        """Publish the scheduler's state when it has changed; its last comes after all events."""
        if self.scheduler is None:
            return
        status = self.scheduler.status
        if (status.state, status.run) != self._state:
            self._state = (status.state, status.run)
            self._stream.publish({"type": "state", "state": status.state.value, "run": status.run})

    def _signals(self, event: ev.SignalsArrived) -> None:
        if self._rig is None or self._run is None or self._envelope is None:
            return
        rows = self._rig.devices().rows()
        values = rows.values_by_name(event.block.volts)
        clock = self._run.sample_clock
        first_s = clock.time_of(event.block.first_index) - self._run.time_s
        run_s = first_s + np.arange(event.block.volts.shape[1]) / clock.rate_hz
        strip = self._envelope.add(strip_samples(self._rows, run_s, values))
        if strip is not None:
            self._stream.publish_strip(strip)

    def _picture(self, frame: Frame, voltage_V: float) -> None:
        run = None if self._run is None else self._run.run
        time_s = self._encoder.since_begin(frame.time_s)
        exposed_s = None if self._rig is None else exposure_time(self._rig.clock, frame.time_s)
        self._stream.publish_picture(
            raw_picture(
                frame,
                time_s,
                run,
                voltage_V,
                exposed_s=exposed_s,
                force_mN=self._forces_mN.get(voltage_V),
            )
        )
