"""A digital line that begins exposures of a camera: a pulse each, made on demand.

Nobody depends on the line's level when the program has died. So a task of that name that another
program left behind is freed, not respected: who has the output has the rig.
"""

from __future__ import annotations

from typing import Any

from drivers.boards.ni.connection import NiConnection
from drivers.interfaces import Clock, DeviceError, TriggerPulse


class NiTrigger:
    """One output line, such as `PCI6703/port0/line1`. A `FrameTrigger`."""

    def __init__(
        self, connection: NiConnection, clock: Clock, line: str, task_name: str = "labrig-trigger"
    ) -> None:
        self._connection = connection
        self._clock = clock
        self._line = line
        self._task_name = task_name
        self._task: Any = None
        self._writer: Any = None

    def open(self) -> None:
        """See `FrameTrigger.open`: the line is low afterwards."""
        if self._task is not None:
            return
        left = self._connection.attach_task(self._task_name)
        if left is not None:
            self._connection.discard(left)
        task = self._connection.create_task(self._task_name)
        try:
            with self._connection.errors(f"opening the trigger line {self._line}"):
                from nidaqmx.stream_writers import DigitalSingleChannelWriter

                task.do_channels.add_do_chan(self._line)
                task.start()
                self._writer = DigitalSingleChannelWriter(task.out_stream, auto_start=False)
                self._set(high=False)
        except BaseException:
            self._connection.discard(task)
            raise
        self._task = task

    def fire(self) -> TriggerPulse:
        """See `FrameTrigger.fire`."""
        if self._task is None:
            raise DeviceError(f"the trigger line {self._line} is not open")
        with self._connection.errors(f"triggering the camera by {self._line}"):
            before_s = self._clock.now()
            self._set(high=True)
            after_s = self._clock.now()
            self._set(high=False)
        return TriggerPulse(before_s, after_s)

    def close(self) -> None:
        """See `FrameTrigger.close`."""
        if self._task is None:
            return
        task, self._task, self._writer = self._task, None, None
        with self._connection.errors(f"closing the trigger line {self._line}"):
            task.close()

    def _set(self, *, high: bool) -> None:
        self._writer.write_one_sample_one_line(high, timeout=1.0)
