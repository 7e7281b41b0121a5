"""A digital line that the working loop keeps toggling, for an external interlock.

A board's line keeps its level when the program dies, so that a level says nothing. A retriggerable
one-shot behind a toggling line does: it drops the amplifier's supply when the edges stop.
"""

from __future__ import annotations

from typing import Any

from drivers.boards.ni.connection import NiConnection
from drivers.interfaces import Clock, DeviceError

EVERY_S = 0.05  # between edges; the one-shot holds for 0.3 s


class NiInterlock:
    """One output line, such as `PCI6703/port0/line0`. `beat` belongs into the working loop."""

    def __init__(
        self,
        connection: NiConnection,
        clock: Clock,
        line: str,
        task_name: str = "labrig-interlock",
    ) -> None:
        self._connection = connection
        self._clock = clock
        self._line = line
        self._task_name = task_name
        self._task: Any = None
        self._writer: Any = None
        self._high = False
        self._due_s = 0.0

    def open(self) -> None:
        """Take the line; it makes no edge yet. Raises DeviceNotFoundError, DeviceError."""
        if self._task is not None:
            return
        task = self._connection.create_task(self._task_name)
        try:
            with self._connection.errors(f"opening the interlock line {self._line}"):
                from nidaqmx.stream_writers import DigitalSingleChannelWriter

                task.do_channels.add_do_chan(self._line)
                task.start()
                self._writer = DigitalSingleChannelWriter(task.out_stream, auto_start=False)
        except BaseException:
            self._connection.discard(task)
            raise
        self._task = task
        self._due_s = self._clock.now()

    def beat(self) -> None:
        """Make an edge when one is due; called at least every 50 ms while energised."""
        if self._task is None:
            raise DeviceError(f"the interlock line {self._line} is not open")
        now = self._clock.now()
        if now < self._due_s:
            return
        self._due_s = now + 0.5 * EVERY_S
        self._high = not self._high
        with self._connection.errors(f"toggling the interlock line {self._line}"):
            self._writer.write_one_sample_one_line(self._high, timeout=1.0)

    def close(self) -> None:
        """Let go of the line: without edges the one-shot drops. May be called twice."""
        if self._task is None:
            return
        task, self._task, self._writer = self._task, None, None
        with self._connection.errors(f"closing the interlock line {self._line}"):
            task.close()
