"""Threads of the clock that tell a running task's listeners what has happened."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nidaqmx._stubs import nidaqmx_pb2 as pb

from sim_hardware.ni.rpc import Message
from sim_hardware.ni.tasks.events import EveryNSamples, Stream

if TYPE_CHECKING:
    from sim_hardware.ni.signals.acquisition import Acquisition
    from sim_hardware.ni.tasks.engine import Engine
    from sim_hardware.ni.tasks.tasks import Task

ACQUIRED_INTO_BUFFER = 1  # nidaqmx.constants.EveryNSamplesEventType
_OVERWRITTEN = -200279
_WAIT_PIECE_S = 0.1  # a thread notices so soon that its task has been stopped


def announce(engine: Engine, task: Task, acquisition: Acquisition) -> None:
    """Start a thread for each registration of a task that has just started."""
    every_n, done = task.events.every_n, task.events.done
    start_thread = engine.clock.start_thread
    if every_n is not None:
        start_thread(
            lambda: _every_n_samples(engine, task, acquisition, every_n), f"events of {task.name}"
        )
    if done is not None:
        start_thread(lambda: _done(engine, task, acquisition, done), f"end of {task.name}")


def _every_n_samples(
    engine: Engine, task: Task, acquisition: Acquisition, wish: EveryNSamples
) -> None:
    event = pb.RegisterEveryNSamplesEventResponse(
        every_n_samples_event_type_raw=ACQUIRED_INTO_BUFFER, n_samples=wish.samples
    )
    count = wish.samples
    total = acquisition.plan.total
    while total is None or count <= total:
        _wait(engine, task, acquisition, acquisition.time_of(count))
        if not _tell(engine, task, acquisition, wish.stream, event):
            return
        count += wish.samples


def _done(engine: Engine, task: Task, acquisition: Acquisition, stream: Stream) -> None:
    """A finite acquisition ends with its last sample, any other only by an overflow."""
    total = acquisition.plan.total
    while total is None:
        overflow_s = acquisition.overflow_s()
        _wait(engine, task, acquisition, overflow_s)
        if task.acquisition is not acquisition or stream.closed:
            return
        if acquisition.overflow_s() <= overflow_s:
            _tell(
                engine, task, acquisition, stream, pb.RegisterDoneEventResponse(status=_OVERWRITTEN)
            )
            return
    _wait(engine, task, acquisition, acquisition.time_of(total))
    _tell(engine, task, acquisition, stream, pb.RegisterDoneEventResponse(status=0))


def _wait(engine: Engine, task: Task, acquisition: Acquisition, when: float) -> None:
    """Wait until `when`, or until the acquisition is over."""
    clock = engine.clock
    while task.acquisition is acquisition and clock.now() < when:
        clock.sleep_until(min(when, clock.now() + _WAIT_PIECE_S))


def _tell(
    engine: Engine, task: Task, acquisition: Acquisition, stream: Stream, event: Message
) -> bool:
    """Send an event of an acquisition that is still the task's; False when it is not."""
    if task.acquisition is not acquisition or stream.closed:
        return False
    if engine.is_virtual:
        stream.send_and_wait(event)  # virtual time stands still while a listener works
    else:
        stream.send(event)
    return True
