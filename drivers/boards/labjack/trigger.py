"""A digital line that begins exposures of a camera: a pulse each, made on demand."""

from __future__ import annotations

from drivers.boards.labjack.device import LabJackDevice
from drivers.boards.labjack.registers import line_number, line_register
from drivers.boards.labjack.wire import Write
from drivers.interfaces import Clock, DeviceError, TriggerPulse


class LabJackTrigger:
    """One digital output, such as `EIO1`. A `FrameTrigger`."""

    def __init__(self, device: LabJackDevice, clock: Clock, line: str) -> None:
        self._device = device
        self._clock = clock
        self._line = line
        self._register = line_register(line_number(line))
        self._open = False

    def open(self) -> None:
        """See `FrameTrigger.open`: the line is low afterwards."""
        self._device.wire.write(f"opening the trigger line {self._line}", Write(self._register, 0))
        self._open = True

    def fire(self) -> TriggerPulse:
        """See `FrameTrigger.fire`."""
        if not self._open:
            raise DeviceError(f"the trigger line {self._line} is not open")
        doing, wire = f"triggering the camera by {self._line}", self._device.wire
        before_s = self._clock.now()
        wire.write(doing, Write(self._register, 1))
        after_s = self._clock.now()
        wire.write(doing, Write(self._register, 0))
        return TriggerPulse(before_s, after_s)

    def close(self) -> None:
        """See `FrameTrigger.close`."""
        self._open = False
