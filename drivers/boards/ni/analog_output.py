"""One analog output of an NI board, written on demand (the PCI-6703 knows no other way).

The board keeps its last voltage for ever, through the end of the task, of the process and through
a device reset. Only a written 0 V makes it safe.
"""

from __future__ import annotations

from typing import Any

from drivers.amplifier import BoardWrite
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.errors import TaskGoneError
from drivers.interfaces import Clock, DeviceError, LimitError

WRITE_TIMEOUT_S = 1.0
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
    ) -> None:
        self._connection = connection
        self._clock = clock
        self._channel = channel
        self._limit_V = limit_V
        self._task_name = task_name
        self._task: Any = None
        self._last_V: float | None = None

    def open(self) -> None:
        """Take the output and write 0 V; an output that is open already is left as it is."""
        if self._task is not None:
            return
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

    def write(self, board_V: float) -> BoardWrite:
        """Put `board_V` on the terminal; blocks for one round trip."""
        if not abs(board_V) <= self._limit_V:  # so written, NaN is refused too
            raise LimitError(
                f"{board_V} V was asked for at {self._channel}, but this output is limited to "
                f"±{self._limit_V:.6g} V; nothing was written"
            )
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
        task, self._task = self._task, None
        if task is not None:
            self._connection.discard(task)

    def _doing(self, board_V: float) -> str:
        known = "none was confirmed yet"
        if self._last_V is not None:
            known = f"the last one confirmed is {self._last_V:g} V"
        return f"writing {board_V:g} V to {self._channel} (which holds its voltage; {known})"


def write_now(task: Any, board_V: float) -> None:
    """Write one sample in one round trip (nidaqmx' `Task.write` makes several)."""
    from nidaqmx.stream_writers import AnalogSingleChannelWriter

    writer = AnalogSingleChannelWriter(task.out_stream, auto_start=False)
    writer.write_one_sample(board_V, timeout=WRITE_TIMEOUT_S)


def add_channel(task: Any, channel: str, limit_V: float) -> None:
    """Add the output channel to a nidaqmx.Task, its range the limit."""
    task.ao_channels.add_ao_voltage_chan(channel, min_val=-limit_V, max_val=limit_V)
