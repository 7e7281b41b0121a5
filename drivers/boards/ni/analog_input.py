"""Analog inputs of an NI board: named channels, acquired by the board's own clock.

The board's sample clock is the time base of a session's signals; `start` ties it to the computer's
clock by the two moments between which the start request ran.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from drivers.boards.acquisition import Acquisition
from drivers.boards.contract import BoardInput
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.errors import TaskGoneError
from drivers.interfaces import (
    Clock,
    DeviceError,
    DeviceNotFoundError,
    FloatArray,
    LostSamplesError,
    SampleClock,
    SignalBlock,
)

INPUT_TASK = "labrig-input"
_THERE_S = 0.2  # for samples that are there already
BUFFER_S = 10.0  # samples unread for longer are lost
_MOST_S = 600.0  # of samples in one read: far beyond any buffer, and still in memory
MARGIN_S = 1.0  # a read may take this much longer than its samples


@dataclass(frozen=True)
class InputChannel:
    """One input: what it is called, where it is wired, and the voltage it must be able to carry."""

    name: str  # force, current, drive
    physical: str  # PCI6034E/ai0
    range_V: float  # either sign; the device takes the next larger range that it has
    terminals: str = "rse"  # differential | rse | nrse | default


class NiSignalInput(Acquisition):
    """Several inputs of one board, hardware-timed and continuous. A `SignalInput`."""

    def __init__(
        self,
        connection: NiConnection,
        clock: Clock,
        channels: Sequence[InputChannel],
        rate_hz: float,
        task_name: str = INPUT_TASK,
    ) -> None:
        wired = [BoardInput(each.name, each.physical, each.range_V) for each in channels]
        super().__init__(clock, wired, rate_hz, "the server")
        self._connection = connection
        self._physical = tuple(channels)
        self._task_name = task_name
        self._task: Any = None
        self._reader: Any = None

    def open(self) -> None:
        """Take the board; an input that is open already is left as it is."""
        if self._task is not None:
            return
        task = self._connection.create_task(self._task_name)
        try:
            with self._connection.errors(f"opening the inputs {self._wiring}"):
                self._configure(task)
        except BaseException:
            self._connection.discard(task)
            raise
        self._task = task

    def start(self) -> SampleClock:
        """See `SignalInput.start`."""
        task = self._taken()
        self._require_stopped()
        with self._errors(f"starting the inputs {self._wiring}"):
            before_s = self._clock.now()
            task.start()
            after_s = self._clock.now()
        self._running = True
        self._next_index = 0
        half_s = 0.5 * (after_s - before_s)
        return SampleClock(before_s + half_s, half_s, self._rate_hz)

    def read_available(self) -> SignalBlock:
        """See `SignalInput.read_available`."""
        task = self._taken()
        self._require_running()
        try:
            with self._errors(f"reading the inputs {self._wiring}"):
                waiting = int(task.in_stream.avail_samp_per_chan)
            volts = self._read(waiting, _THERE_S)
        except LostSamplesError as fault:
            raise LostSamplesError(f"{fault}; {self._how_many_lost(task)}") from fault
        return self._block(volts)

    def stop(self) -> None:
        """See `SignalInput.stop`."""
        if self._task is None or not self._running:
            return
        with self._errors(f"stopping the inputs {self._wiring}"):
            self._task.stop()
        self._running = False  # not before: whoever failed to stop it may try again

    def close(self) -> None:
        """See `SignalInput.close`."""
        if self._task is None:
            return
        task, self._task, self._reader = self._task, None, None
        self._running = False
        with self._connection.errors(f"closing the inputs {self._wiring}"):
            task.close()  # stops it too

    def _taken(self) -> Any:
        if self._task is None:
            raise DeviceError(f"the inputs {self._wiring} are not open")
        return self._task

    @contextmanager
    def _errors(self, doing: str) -> Iterator[None]:
        try:
            with self._connection.errors(doing):
                yield
        except TaskGoneError:
            self._task = None  # somebody has made the rig safe; it can be opened again
            self._running = False
            raise

    def _configure(self, task: Any) -> None:
        from nidaqmx.constants import AcquisitionType, TaskMode
        from nidaqmx.stream_readers import AnalogMultiChannelReader

        for channel in self._physical:
            add_channel(task, channel)
        task.timing.cfg_samp_clk_timing(
            self._asked_hz,
            sample_mode=AcquisitionType.CONTINUOUS,
            samps_per_chan=max(1000, math.ceil(self._asked_hz * BUFFER_S)),
        )
        task.in_stream.auto_start = False  # a late read must not start it again
        task.control(TaskMode.TASK_VERIFY)  # settings are checked only when asked for
        self._rate_hz = float(task.timing.samp_clk_rate)
        self._ranges = tuple(float(chan.ai_max) for chan in task.ai_channels)
        self._check_answers()
        task.control(TaskMode.TASK_COMMIT)  # takes the board, and makes the start itself short
        self._reader = AnalogMultiChannelReader(task.in_stream)
        self._reader.verify_array_shape = False  # ours fits; the check asks the server each time

    def _check_answers(self) -> None:
        """Refuse a rate or a range that cannot be true."""
        rate_fits = 0.5 < self._rate_hz / self._asked_hz < 2.0
        if not rate_fits or not all(0.0 < volts < 1e3 for volts in self._ranges):
            raise DeviceError(
                f"{self._wiring}: the board says that it samples at {self._rate_hz:g} Hz with "
                f"ranges of {', '.join(f'{volts:g}' for volts in self._ranges)} V, which makes no "
                f"sense where {self._asked_hz:g} Hz were asked for; restart the server or driver"
            )

    def _wait_for(self, wanted: int, sample_clock: SampleClock) -> FloatArray:
        """See `Acquisition`; the driver waits."""
        return self._read(wanted, wanted / sample_clock.rate_hz + MARGIN_S)

    def _read(self, samples: int, wait_s: float) -> FloatArray:
        """Exactly this many samples of each channel; waits so long until they have come."""
        if not 0 <= samples <= _MOST_S * self._rate_hz:
            raise DeviceError(
                f"{self._wiring}: {samples} samples are said to wait, more than fit anywhere; "
                "restart the server or driver"
            )
        volts = np.empty((len(self._inputs), samples))
        if samples == 0:
            return volts
        with self._errors(f"reading {samples} samples of {self._wiring}"):
            read = self._reader.read_many_sample(volts, samples, timeout=wait_s)
        if read != samples:
            raise DeviceError(
                f"{self._wiring}: {samples} samples were asked for, {read} came; restart the run"
            )
        return volts

    def _how_many_lost(self, task: Any) -> str:
        """Return what the driver still reports of an overflow; must not fail itself."""
        try:
            with self._connection.errors("asking how many samples are lost"):
                acquired = int(task.in_stream.total_samp_per_chan_acquired)
                buffered = int(task.in_stream.input_buf_size)
        except DeviceError:
            return f"all after sample {self._next_index} of this run are lost; repeat the run"
        lost = max(1, acquired - buffered - self._next_index)
        return (
            f"at least {lost} samples of each channel are lost after sample {self._next_index} "
            f"({acquired} acquired); repeat the run on a less busy computer or at a lower "
            "sample_rate_hz"
        )


def add_channel(task: Any, channel: InputChannel) -> None:
    """Add an input to a nidaqmx.Task."""
    from nidaqmx.constants import TerminalConfiguration

    terminals = {
        "differential": TerminalConfiguration.DIFF,
        "rse": TerminalConfiguration.RSE,
        "nrse": TerminalConfiguration.NRSE,
        "default": TerminalConfiguration.DEFAULT,
    }
    if channel.terminals not in terminals:
        raise DeviceNotFoundError(
            f"{channel.physical}: terminals = '{channel.terminals}' is none of "
            f"{', '.join(terminals)}"
        )
    task.ai_channels.add_ai_voltage_chan(
        channel.physical,
        terminal_config=terminals[channel.terminals],
        min_val=-channel.range_V,
        max_val=channel.range_V,
    )
