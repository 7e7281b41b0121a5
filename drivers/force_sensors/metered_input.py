"""A board's inputs, with the force read by a meter in the board's place."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from numbers import Real
from typing import TypeGuard

import numpy as np

from drivers.identity import identities_of
from drivers.interfaces import (
    Clock,
    DeviceError,
    DeviceIdentity,
    DeviceTimeoutError,
    FloatArray,
    ForceSensor,
    OverloadError,
    SampleClock,
    SignalBlock,
    SignalInput,
    ThreadHandle,
)

FORCE = "force"
INTERVAL_S = 0.05  # between readings of the meter: such a meter converts 20 times a second
SILENT_S = 1.0  # a meter without a good reading for so long has failed
_READINGS = 4096  # kept: some minutes of them
_FEW = 3  # readings that show how far apart they are
_TICK_S = 0.01
_JOIN_S = 5.0


class MeteredInput:
    """A `SignalInput`: the board's channels, and before them `force`, whose unit is newtons.

    A thread asks the meter from `open` to `close`. A reading counts at the middle of its exchange;
    the force of a sample lies on the straight line between the readings before and after it. So
    samples arrive only when the meter has read the force after them.
    """

    def __init__(
        self, board: SignalInput, sensor: ForceSensor, clock: Clock, kind: str = ""
    ) -> None:
        self.board = board  # what makes safe reads the drive voltage from it: it needs no meter
        self._sensor = sensor
        self._name = f"the force meter '{kind}'" if kind else "the force meter"
        self.sensor_identities: tuple[DeviceIdentity, ...] = ()  # of the meter, once it is open
        self._clock = clock
        self._lock = threading.Lock()
        self._readings: deque[tuple[float, float]] = deque(maxlen=_READINGS)  # time, force
        self._fault: DeviceError | None = None  # the last one, until a good reading comes
        self._good_s = 0.0  # when the last good reading came
        self._closing = threading.Event()
        self._thread: ThreadHandle | None = None
        self._sample_clock: SampleClock | None = None
        self._waiting = np.empty((0, 0))  # samples of the board whose force is not known yet
        self._first_index = 0  # of the first of them

    @property
    def channels(self) -> Sequence[str]:
        """See `SignalInput.channels`."""
        return (FORCE, *self.board.channels)

    @property
    def ranges_V(self) -> Sequence[float]:
        """See `SignalInput.ranges_V`; that of the force is in N."""
        return (self._sensor.range_N, *self.board.ranges_V)

    @property
    def rate_hz(self) -> float:
        """See `SignalInput.rate_hz`."""
        return self.board.rate_hz

    def open(self) -> None:
        """See `SignalInput.open`."""
        self.board.open()
        if self._thread is not None:
            return
        try:
            self._sensor.open()
            self._require_range()
        except BaseException:
            self.board.close()
            raise
        self.sensor_identities = identities_of(self._sensor)  # before its thread has it
        self._closing.clear()
        self._fault = None
        self._good_s = self._clock.now()
        self._thread = self._clock.start_thread(self._read_until_closed, "force meter")

    def start(self) -> SampleClock:
        """See `SignalInput.start`."""
        self._sample_clock = self.board.start()
        self._waiting = np.empty((len(self.board.channels), 0))
        self._first_index = 0
        return self._sample_clock

    def read_available(self) -> SignalBlock:
        """See `SignalInput.read_available`. Raises OverloadError when the meter reports one."""
        block = self.board.read_available()
        self._check_meter()
        self._append(block)
        when, force = self._history(self._times(self._first_index, 1)[0])
        known = self._count_until(when[-1]) if when.size else 0
        first, volts = self._first_index, self._waiting[:, :known]
        self._waiting, self._first_index = self._waiting[:, known:], first + known
        force_N = np.empty(0)
        if known:
            force_N = np.interp(self._times(first, known), when, force, left=np.nan)
        return SignalBlock(first, np.vstack([force_N, volts]), block.read_s)

    def stop(self) -> None:
        """See `SignalInput.stop`."""
        self.board.stop()

    def measure(self, duration_s: float) -> FloatArray:
        """See `SignalInput.measure`; waits for the meter's reading after the last sample."""
        volts = self.board.measure(duration_s)
        ended_s = self._clock.now()
        while not (self._readings and self._readings[-1][0] >= ended_s):
            self._check_meter()
            self._clock.sleep_until(self._clock.now() + _TICK_S)
        count = volts.shape[1]
        times = ended_s - np.arange(count, 0, -1) / self.rate_hz
        return np.vstack([np.interp(times, *self._history(times[0])), volts])

    def force_times_s(self, begin_s: float, end_s: float) -> FloatArray:
        """See `InterpolatedForce.force_times_s`."""
        times, _ = self._history(begin_s)
        return times[: np.searchsorted(times, end_s) + 1]

    def interval_s(self) -> float:
        """Return the time from one reading of the meter to the next; waits for a few of them.

        Raises DeviceError where none come.
        """
        while len(self._readings) < _FEW:
            self._check_meter()
            self._clock.sleep_until(self._clock.now() + _TICK_S)
        with self._lock:
            times = [time_s for time_s, _ in self._readings]
        return float(np.median(np.diff(times)))

    def close(self) -> None:
        """See `SignalInput.close`."""
        thread, self._thread = self._thread, None
        self._closing.set()
        try:
            self.board.close()
        finally:
            if thread is not None and not thread.join(_JOIN_S):
                raise DeviceTimeoutError(
                    f"{self._name} did not end its last reading in {_JOIN_S:g} s; check its "
                    "connection, and restart labrig before using it again"
                )
            self._sensor.close()

    def _require_range(self) -> None:
        """Raise DeviceError, with the meter closed, where its range is none."""
        range_N: object = self._sensor.range_N
        if not (_is_real(range_N) and 0 < range_N < math.inf):
            with suppress(Exception):  # what is wrong is said below
                self._sensor.close()
            raise DeviceError(f"{self._name} states the range {range_N!r}, not one in N above 0")

    def _append(self, block: SignalBlock) -> None:
        """Put a block behind the waiting samples; those that never came are NaN."""
        lost = block.first_index - self._first_index - self._waiting.shape[1]
        gap = np.full((len(self._waiting), max(lost, 0)), np.nan)
        self._waiting = np.concatenate([self._waiting, gap, block.volts], axis=1)

    def _times(self, first: int, count: int) -> FloatArray:
        clock = self._started()
        return clock.start_s + (first + np.arange(count)) / clock.rate_hz

    def _count_until(self, time_s: float) -> int:
        """How many of the waiting samples were acquired by a clock time."""
        index = int(np.floor(self._started().index_at(time_s)))
        return min(max(index + 1 - self._first_index, 0), self._waiting.shape[1])

    def _started(self) -> SampleClock:
        if self._sample_clock is None:
            raise DeviceError("the inputs are not acquiring: start them first")
        return self._sample_clock

    def _history(self, since_s: float) -> tuple[FloatArray, FloatArray]:
        """Return times and forces of the meter's readings, from the last one before `since_s` on.

        All of them would cost the working loop a millisecond at each call.
        """
        found: list[tuple[float, float]] = []
        with self._lock:
            for reading in reversed(self._readings):
                found.append(reading)
                if reading[0] <= since_s:
                    break
        rows = np.array(found[::-1], dtype=float).reshape(-1, 2)
        return rows[:, 0], rows[:, 1]

    def _check_meter(self) -> None:
        """Raise what keeps the meter from reading; one spoilt reading does not."""
        fault = self._fault
        if isinstance(fault, OverloadError):
            raise fault
        silent_s = self._clock.now() - self._good_s
        if silent_s > SILENT_S:
            raise DeviceTimeoutError(
                f"{self._name} has given no reading for {silent_s:.1f} s: "
                f"{fault or 'it does not answer'}"
            ) from fault

    def _read_until_closed(self) -> None:
        """Run the meter's thread."""
        while not self._closing.is_set():
            began_s = self._clock.now()
            self._read_once(began_s)
            self._clock.sleep_until(began_s + INTERVAL_S)

    def _read_once(self, began_s: float) -> None:
        try:
            force_N: object = self._sensor.read_force()
            if not _is_real(force_N):
                raise DeviceError(f"its read_force returned {force_N!r:.60}, not a force in N")
        except DeviceError as fault:
            self._fault = fault
        except BaseException as fault:  # noqa: BLE001 - a thread has nobody to raise to
            self._fault = DeviceError(f"unexpected {type(fault).__name__}: {fault}")
            self._fault.__cause__ = fault  # in whose code it was raised
        else:
            self._good_s = self._clock.now()
            with self._lock:
                self._readings.append((0.5 * (began_s + self._good_s), float(force_N)))
            self._fault = None


def _is_real(value: object) -> TypeGuard[float]:
    """Whether it is a number, or an array that is one."""
    if isinstance(value, np.ndarray):
        return value.ndim == 0 and value.dtype.kind in "fiu"
    return isinstance(value, Real) and not isinstance(value, bool)
