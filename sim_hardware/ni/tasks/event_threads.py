"""Threads of the clock that send a running task's events to its listeners."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from nidaqmx._stubs import nidaqmx_pb2 as pb

from drivers.interfaces import Clock
from sim_hardware.clock import VirtualClock
from sim_hardware.ni.errors import Code
from sim_hardware.ni.rpc import Message
from sim_hardware.ni.signals.acquisition import Acquisition
from sim_hardware.ni.signals.generation import Generation
from sim_hardware.ni.tasks.events import EveryNSamples, Stream
from sim_hardware.ni.tasks.task import Task

# nidaqmx.constants.EveryNSamplesEventType
ACQUIRED_INTO_BUFFER, TRANSFERRED_FROM_BUFFER = 1, 2
_WAIT_PIECE_S = 0.1  # a thread notices so soon that its task has been stopped


def start_event_threads(clock: Clock, task: Task, timed: Acquisition | Generation) -> None:
    """Start a thread for each registration of a task that has just started."""
    events = _TimedEvents(clock, task, timed)
    every_n, done = task.events.every_n, task.events.done
    if every_n is not None:
        clock.start_thread(lambda: events.every_n_samples(every_n), f"events of {task.name}")
    if done is not None:
        clock.start_thread(lambda: events.done(done), f"end of {task.name}")


@dataclass(frozen=True)
class _TimedEvents:
    """The events of one acquisition or generation of a task."""

    clock: Clock
    task: Task
    timed: Acquisition | Generation

    def every_n_samples(self, registration: EveryNSamples) -> None:
        """Send an event whenever so many samples have been acquired."""
        event = pb.RegisterEveryNSamplesEventResponse(
            every_n_samples_event_type_raw=registration.kind, n_samples=registration.samples
        )
        count = registration.samples
        total = self.timed.plan.total
        while total is None or count <= total:
            self._wait(lambda: self.timed.time_of(count))  # noqa: B023 - asked at once
            if not self._send(registration.stream, event):
                return
            count += registration.samples

    def done(self, stream: Stream) -> None:
        """Send the end: a finite acquisition's with its last sample, any other's by an overflow."""
        total = self.timed.plan.total
        if total is None:
            self._wait(self.timed.overflow_s)
            if self._over or stream.closed:
                return
            output = isinstance(self.timed, Generation)
            status = Code.GENERATION_UNDERFLOW if output else Code.OVERWRITTEN
            self._send(stream, pb.RegisterDoneEventResponse(status=int(status)))
            return
        self._wait(lambda: self.timed.time_of(total))
        self._send(stream, pb.RegisterDoneEventResponse(status=0))

    @property
    def _over(self) -> bool:
        """Whether the task has been stopped, or started again."""
        return self.task.timed is not self.timed

    def _wait(self, when: Callable[[], float]) -> None:
        """Wait until a time that may change meanwhile, or until the acquisition is over."""
        while not self._over and self.clock.now() < (when_s := when()):
            self.clock.sleep_until(min(when_s, self.clock.now() + _WAIT_PIECE_S))

    def _send(self, stream: Stream, event: Message) -> bool:
        """Send an event of an acquisition that is still the task's; False when it is not."""
        if self._over or stream.closed:
            return False
        if isinstance(self.clock, VirtualClock):
            stream.send_and_wait(event)  # virtual time stands still while a listener works
        else:
            stream.send(event)
        return True
