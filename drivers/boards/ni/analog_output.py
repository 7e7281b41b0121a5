"""One analog output of an NI board, written on demand, or by the clock of the board's inputs.

The PCI-6703 knows no other way than on demand. A board keeps its last voltage for ever, through the
end of the task and of the process, and most through a device reset. Only a written 0 V makes it
safe.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from drivers.amplifier import BoardWrite
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.errors import TaskGoneError
from drivers.boards.ni.timed_run import load_run, samples_of
from drivers.interfaces import Clock, DeviceError, LimitError, TimedVoltage

WRITE_TIMEOUT_S = 0.2  # a write on demand has nothing to wait for
OUTPUT_TASK = "labrig-output"


class NiVoltageOutput:
    """An analog output in board volts. Its task carries a name by which a guard can attach to it.

    `limit_V` is enforced here, at the last step before the board, and again by the driver: it is
    the channel's range, so that a value beyond it is refused (-200561).
    """

    def __init__(
        self,
        connection: NiConnection,
        clock: Clock,
        channel: str,
        limit_V: float,
        task_name: str = OUTPUT_TASK,
        trigger: str | None = None,
    ) -> None:
        """`trigger`: the terminal of the start of inputs that share its board's clock, if any."""
        self._connection = connection
        self._clock = clock
        self._channel = channel
        self._limit_V = limit_V
        self._task_name = task_name
        self._task: Any = None
        self._last_V: float | None = None
        self._trigger = trigger
        self._is_timed = False
        self._loaded = False  # the task is that of a run
        self._left_behind = False  # such a task, that could not be ended

    @property
    def is_timed(self) -> bool:
        """See `TimedBoardOutput.is_timed`."""
        return self._is_timed

    def open(self) -> None:
        """Take the output and write 0 V; an output that is open already is left as it is."""
        if self._task is not None:
            return
        self._is_timed = self._trigger is not None and self._can_be_timed()
        self._open_on_demand()

    def _can_be_timed(self) -> bool:
        """Return whether the board's outputs have a sample clock; one that cannot tell has none."""
        try:
            return self._connection.has_output_clock(self._channel.partition("/")[0])
        except DeviceError:
            return False

    def _open_on_demand(self) -> None:
        if self._left_behind:
            self._end_left_behind()
        task = self._connection.create_task(self._task_name)
        try:
            with self._connection.errors(f"opening the output {self._channel}"):
                add_channel(task, self._channel, self._limit_V)
                # Started once: a write then needs one round trip, and the channel stays ours.
                task.start()
            self._task = task
            self.write(0.0)
        except BaseException:
            self._task = None
            self._connection.discard(task)
            raise

    def load(self, waveform: Sequence[TimedVoltage], rate_hz: float) -> None:
        """See `TimedBoardOutput.load`. The task keeps its name, by which the guard finds it."""
        for each in waveform:
            self._check(each.volts)
        if not self._is_timed:
            raise DeviceError(f"the output {self._channel} has no clock: it cannot be given a run")
        self.write(0.0)
        on_demand, self._task = self._task, None
        with self._connection.errors(f"freeing the output {self._channel} (at 0 V)"):
            on_demand.close()
        task = self._connection.create_task(self._task_name)
        try:
            with self._connection.errors(f"giving a run to the output {self._channel}"):
                add_channel(task, self._channel, self._limit_V)
                load_run(task, samples_of(waveform), rate_hz, str(self._trigger))
        except BaseException:
            self._connection.discard(task)
            with suppress(DeviceError):  # the output is at 0 V, and remains ours if possible
                self._open_on_demand()
            raise
        self._task, self._loaded = task, True

    def is_done(self) -> bool:
        """See `TimedBoardOutput.is_done`."""
        task = self._task
        if task is None or not self._loaded:
            raise DeviceError(f"the output {self._channel} has been given no run")
        try:
            with self._connection.errors(f"the run of the output {self._channel}"):
                return bool(task.is_task_done())
        except TaskGoneError:
            self._task, self._loaded = None, False
            raise

    def _unload(self) -> None:
        """End the run that the board was given; the output keeps its voltage for a moment."""
        task, self._task, self._loaded = self._task, None, False
        self._left_behind = True
        with self._connection.errors(f"ending the run of the output {self._channel}"):
            task.close()  # stops it, too
        self._left_behind = False

    def _end_left_behind(self) -> None:
        """End the run's task, by its name: whoever failed to end it no longer has it."""
        task = self._connection.attach_task(self._task_name)
        if task is not None:
            with self._connection.errors(f"ending the run of the output {self._channel}"):
                task.close()
        self._left_behind = False

    def write(self, board_V: float) -> BoardWrite:
        """Put `board_V` on the terminal; blocks for one round trip."""
        self._check(board_V)
        if self._loaded:
            self._unload()
            self._open_on_demand()
        task = self._task
        if task is None:
            raise DeviceError(f"the output {self._channel} is not open; nothing was written")
        try:
            with self._connection.errors(self._doing(board_V)):
                before_s = self._clock.now()
                write_now(task, board_V)
                after_s = self._clock.now()
        except TaskGoneError:
            self._task = None  # somebody has made the output safe; it can be opened again
            raise
        self._last_V = board_V
        return BoardWrite(before_s, after_s)

    def close(self) -> None:
        """Write 0 V and let go of the output.

        Where 0 V is refused the task stays, so that a second `close`, or another process by the
        task's name, can try again.
        """
        if self._task is None:
            return
        self.write(0.0)
        task, self._task = self._task, None
        with self._connection.errors(f"closing the output {self._channel} (at 0 V)"):
            task.close()

    def abandon(self) -> None:
        """Let go of the output as it is: for whoever else is going to write 0 V at once."""
        task, self._task, self._loaded = self._task, None, False
        if task is not None:
            self._connection.discard(task)

    def _check(self, board_V: float) -> None:
        if not abs(board_V) <= self._limit_V:  # so written, NaN is refused too
            raise LimitError(
                f"{board_V} V was asked for at {self._channel}, but this output is limited to "
                f"±{self._limit_V:.6g} V; nothing was written"
            )

    def _doing(self, board_V: float) -> str:
        known = "none was confirmed yet"
        if self._last_V is not None:
            known = f"the last one confirmed is {self._last_V:g} V, before the amplifier"
        return f"writing {board_V:g} V to {self._channel} (which holds its voltage; {known})"


def write_now(task: Any, board_V: float) -> None:
    """Write one sample in one round trip (nidaqmx' `Task.write` makes several)."""
    from nidaqmx.stream_writers import AnalogSingleChannelWriter

    writer = AnalogSingleChannelWriter(task.out_stream, auto_start=False)
    writer.write_one_sample(board_V, timeout=WRITE_TIMEOUT_S)


def add_channel(task: Any, channel: str, limit_V: float) -> None:
    """Add the output channel to a nidaqmx.Task, its range the limit."""
    task.ao_channels.add_ao_voltage_chan(channel, min_val=-limit_V, max_val=limit_V)
