"""Analog inputs of a T-series device: its stream, which its own clock drives."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

from drivers.boards.acquisition import Acquisition
from drivers.boards.contract import BoardInput
from drivers.boards.labjack.calibration import Conversion, conversions
from drivers.boards.labjack.device import LabJackDevice
from drivers.boards.labjack.registers import (
    AUTO_TARGET,
    BUFFER_BYTES,
    COMMAND_RESPONSE,
    DATA_TYPE,
    NUM_ADDRESSES,
    NUM_SCANS,
    SCAN_LIST,
    SCAN_RATE_HZ,
    SETTLING_US,
    STREAM_DATA,
    STREAM_ENABLE,
    STREAM_RESOLUTION,
    input_number,
    input_register,
)
from drivers.boards.labjack.wire import MOST_REGISTERS, Write
from drivers.interfaces import (
    Clock,
    DeviceError,
    FloatArray,
    LostSamplesError,
    SampleClock,
    SignalBlock,
)

_HEAD = struct.Struct(">4H")  # samples, backlog in bytes, status, what belongs to the status
_BUFFER_BYTES = 32768  # the largest that every model has: 4 s of four inputs at 1 kHz
_RECOVERING, _RECOVERED, _TOO_FAST, _OVERFLOW, _DONE, _FULL = range(2940, 2946)
_GOOD = (0, _DONE)


class LabJackSignalInput(Acquisition):
    """Several inputs of one device, hardware-timed and continuous. A `SignalInput`."""

    def __init__(
        self, device: LabJackDevice, clock: Clock, inputs: Sequence[BoardInput], rate_hz: float
    ) -> None:
        super().__init__(clock, inputs, rate_hz, "the network and the device")
        self._device = device
        self._conversions: list[Conversion] = []  # empty: not open
        self._left = b""  # samples of a scan that has not come as a whole

    def open(self) -> None:
        """Set ranges and pairs, read the calibration, learn the true rate."""
        if self._conversions:
            return
        wire, model = self._device.wire, self._device.model
        doing = f"opening the inputs {self._wiring}"
        numbers = [input_number(each.terminal) for each in self._inputs]
        ranges = tuple(model.range_for(each.range_V) for each in self._inputs)
        if wire.read(doing, STREAM_ENABLE)[0]:
            raise DeviceError(
                f"{doing} failed: a stream of another program runs on {wire.where}; close that, or "
                "run `labrig safe` if it is gone"
            )
        for number, range_V in zip(numbers, ranges, strict=True):
            wire.write(doing, *self._device.input_settings(number, range_V))
        found = conversions(wire, model, numbers, ranges)
        wire.write(doing, Write(SCAN_RATE_HZ, self._asked_hz), Write(NUM_ADDRESSES, len(numbers)))
        rate_hz = wire.read(doing, SCAN_RATE_HZ)[0]
        if not 0.5 < rate_hz / self._asked_hz < 2.0:
            raise DeviceError(
                f"{doing} failed: {wire.where} says that it samples at {rate_hz:g} Hz where "
                f"{self._asked_hz:g} Hz were asked for; choose another sample_rate_hz"
            )
        self._ranges, self._rate_hz, self._conversions = ranges, rate_hz, found

    def start(self) -> SampleClock:
        """See `SignalInput.start`. The device takes the first scan a period after the request."""
        self._require_open()
        self._require_stopped()
        wire, doing = self._device.wire, f"starting the inputs {self._wiring}"
        numbers = [input_number(each.terminal) for each in self._inputs]
        settings = (
            Write(SCAN_RATE_HZ, self._asked_hz),
            Write(NUM_ADDRESSES, len(numbers)),
            Write(SETTLING_US, 0.0),
            Write(STREAM_RESOLUTION, 0),
            Write(BUFFER_BYTES, _BUFFER_BYTES),
            Write(AUTO_TARGET, COMMAND_RESPONSE),
            Write(NUM_SCANS, 0),
            Write(DATA_TYPE, 0),
        )
        wire.write(doing, *settings)
        addresses = [input_register(number).address for number in numbers]
        wire.write_block(doing, SCAN_LIST, struct.pack(f">{len(addresses)}I", *addresses))
        before_s = self._clock.now()
        wire.write(doing, Write(STREAM_ENABLE, 1))
        after_s = self._clock.now()
        self._running, self._next_index, self._left = True, 0, b""
        half_s = 0.5 * (after_s - before_s)
        first_s = before_s + half_s + 1.0 / self._rate_hz
        self._clock.sleep_until(first_s)
        return SampleClock(first_s, half_s, self._rate_hz)

    def read_available(self) -> SignalBlock:
        """See `SignalInput.read_available`."""
        self._require_open()
        self._require_running()
        return self._block(self._read_all())

    def stop(self) -> None:
        """See `SignalInput.stop`."""
        if not self._running:
            return
        doing = f"stopping the inputs {self._wiring}"
        if self._device.wire.read(doing, STREAM_ENABLE)[0]:  # it stops by itself when it overflows
            self._device.wire.write(doing, Write(STREAM_ENABLE, 0))
        self._running = False  # not before: whoever failed to stop it may try again

    def close(self) -> None:
        """See `SignalInput.close`."""
        if not self._conversions:
            return
        self.stop()
        self._conversions = []

    def _require_open(self) -> None:
        if not self._conversions:
            raise DeviceError(f"the inputs {self._wiring} are not open")

    def _read_all(self) -> FloatArray:
        """Return all whole scans that wait in the device."""
        channels = len(self._inputs)
        count = (MOST_REGISTERS - 4) // channels * channels
        data = self._left
        doing = f"reading the inputs {self._wiring}"
        while True:
            block = self._device.wire.read_block(doing, STREAM_DATA, 4 + count)
            samples, backlog, status, more = _HEAD.unpack_from(block)
            if status not in _GOOD or samples > count:
                raise self._fault(doing, status, more)
            data += block[_HEAD.size : _HEAD.size + 2 * samples]
            if not backlog or not samples:
                break
        whole = len(data) // (2 * channels) * 2 * channels
        self._left = data[whole:]
        codes = np.frombuffer(data[:whole], dtype=">u2").astype(np.uint16).reshape(-1, channels).T
        volts = np.empty(codes.shape)
        for row, conversion in enumerate(self._conversions):
            volts[row] = conversion.volts(codes[row])
        return volts

    def _fault(self, doing: str, status: int, more: int) -> DeviceError:
        if status in (_RECOVERING, _RECOVERED, _OVERFLOW, _FULL):
            lost = f"{more} samples" if status == _RECOVERED and more else "some samples"
            return LostSamplesError(
                f"{doing} failed: {lost} of each channel are lost after sample {self._next_index}: "
                "samples were overwritten before they were read; repeat the run on a less busy "
                "computer or at a lower sample_rate_hz"
            )
        if status == _TOO_FAST:
            return DeviceError(
                f"{doing} failed: {self._device.wire.where} cannot sample so many inputs at these "
                "ranges so fast; lower [labjack] sample_rate_hz"
            )
        return DeviceError(f"{doing} failed: the stream reports status {status}; repeat the run")
