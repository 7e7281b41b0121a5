"""A simulated device: its registers, its terminals, and the rig that is wired to them."""

from __future__ import annotations

import math
import struct
import threading
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from drivers.interfaces import Clock
from sim_hardware.labjack import refusal
from sim_hardware.labjack.faults import LabJackFaults
from sim_hardware.labjack.models import SimulatedModel
from sim_hardware.labjack.refusal import RefusedError
from sim_hardware.labjack.stream import ScanStream
from sim_hardware.labjack.watchdog import (
    CLEAR,
    DAC_V,
    ENABLE,
    WHOLE,
    DeviceWatchdog,
)
from sim_hardware.simulated_rig import AnalogSide

FloatArray = npt.NDArray[np.float64]
_RATE, _COUNT, _BUFFER, _TARGET, _ENABLE = 4002, 4004, 4012, 4016, 4990
_DATA, _LIST, _LAST_ERROR, _NAME = 4500, 4100, 55000, 60500
_POINTER, _FLASH = 61810, 61812
_FLOATS = frozenset({_RATE, 4008, *DAC_V})
_STREAM_WORDS = (4002, 4004, 4006, 4008, 4010, 4012, 4016, 4018, 4020)
_TICK_V, _TICK_BITS = 10.0, 14
_LINES = 23
_PORTS = (("FIO", 8), ("EIO", 8), ("CIO", 4), ("MIO", 3))
_COMMAND_RESPONSE = 16
LINE_NAMES = tuple(f"{port}{n}" for port, count in _PORTS for n in range(count))


class SimulatedLabJack:
    """One device. May be used by several threads. `faults` may be changed at any time."""

    def __init__(
        self,
        rig: AnalogSide,
        clock: Clock,
        model: SimulatedModel,
        *,
        name: str = "LabJack",
        serial: int = 470012345,
        seed: int | None = 0,
    ) -> None:
        self.model = model
        self.serial = serial
        self.clock = clock
        self.faults = LabJackFaults()
        # called with a line's name, its level and the time
        self.wired: Callable[[str, bool, float], None] | None = None
        self._rig = rig
        self._name = name
        self._lock = threading.RLock()
        self._random = np.random.default_rng(seed)
        self._words: dict[int, float] = dict.fromkeys((*_STREAM_WORDS, _POINTER), 0.0)
        self._words |= {_LIST + 2 * n: 0.0 for n in range(128)}
        self._words |= {46100 + 2 * n: 0.0 for n in range(40)}
        self._ranges = [model.ranges_V[0]] * model.inputs
        self._negative = [199] * model.inputs
        self._dac_V = [model.stage.zero_V if model.output == f"DAC{n}" else 0.0 for n in (0, 1)]
        self._lines = [False] * _LINES
        self._last_error = 0
        self._stream: ScanStream | None = None
        self.watchdog = DeviceWatchdog(set_dac=self._set_dac, set_lines=self._set_lines)

    # --------------------------------------------------------------------------- for the server

    def advance(self) -> None:
        """Let the watchdog act if it is due."""
        with self._lock:
            self.watchdog.advance(self.clock.now())

    def heard(self) -> None:
        """Note that a request has come."""
        with self._lock:
            now_s = self.clock.now()
            self.watchdog.advance(now_s)
            self.watchdog.heard(now_s)

    def note(self, error: int) -> None:
        """Keep the code of the last error."""
        self._last_error = error

    def read(self, address: int, registers: int) -> bytes:
        """Return so many registers. RefusedError."""
        with self._lock:
            if address == _DATA:
                return self._read_stream(registers)
            if address == _FLASH:
                return self._read_flash(registers)
            if address == _NAME:
                text = f"simulated {self._name}".encode()
                return text[: 2 * registers].ljust(2 * registers, b"\0")
            data = b""
            while registers > 0:
                value = self._read_value(address)
                data += value
                address += len(value) // 2
                registers -= len(value) // 2
            if registers < 0:
                raise RefusedError(refusal.ILLEGAL_ADDRESS, refusal.WRONG_SIZE)
            return data

    def write(self, address: int, data: bytes) -> None:
        """Write registers. RefusedError."""
        with self._lock:
            while data:
                size = 2 * self._size(address)
                if len(data) < size:
                    raise RefusedError(refusal.ILLEGAL_ADDRESS, refusal.WRONG_SIZE)
                self._write_value(address, data[:size])
                address, data = address + size // 2, data[size:]

    def level(self, line: int) -> bool:
        """Return whether a digital line is high."""
        return self._lines[line]

    # ------------------------------------------------------------------------------ single values

    @staticmethod
    def _size(address: int) -> int:
        """Return how many registers a value takes."""
        one = 2000 <= address < 2000 + _LINES or 41000 <= address < 42000 or address == _LAST_ERROR
        return 1 if one else 2

    def _read_value(self, address: int) -> bytes:
        if self._size(address) == 1:
            return struct.pack(">H", self._read_short(address))
        if address in (60000, 60002, 60004):
            number = {60000: float(self.model.product_id), 60002: 1.3, 60004: 1.0292}[address]
            return struct.pack(">f", number)
        if address == 60028:
            return struct.pack(">I", self.serial)
        if 0 <= address < 2 * self.model.inputs:
            return struct.pack(">f", self._measured_V(address // 2))
        if address in (1000, 1002):
            return struct.pack(">f", self._dac_V[(address - 1000) // 2])
        if 40000 <= address < 40000 + 2 * self.model.inputs:
            return struct.pack(">f", self._ranges[(address - 40000) // 2])
        if address == _ENABLE:
            return struct.pack(">I", int(self._stream is not None))
        values = self.watchdog.values if address in (*WHOLE, *DAC_V) else self._words
        if address not in values:
            raise RefusedError(refusal.ILLEGAL_ADDRESS, refusal.NO_REGISTER)
        return _packed(address, values[address])

    def _read_short(self, address: int) -> int:
        if address == _LAST_ERROR:
            return self._last_error
        if address < 3000:
            return int(self._lines[address - 2000])
        return self._negative[self._input(address - 41000)]

    def _write_value(self, address: int, data: bytes) -> None:
        now_s = self.clock.now()
        if self._size(address) == 1:
            self._write_short(address, struct.unpack(">H", data)[0], now_s)
            return
        number = struct.unpack(">f", data)[0]
        whole = float(struct.unpack(">I", data)[0])
        if address in (1000, 1002) or 30000 <= address < 30044:
            self._write_output(address, number, now_s)
        elif 40000 <= address < 40000 + 2 * self.model.inputs:
            self._set_range((address - 40000) // 2, number)
        elif address in (*WHOLE, *DAC_V, CLEAR):
            self._write_watchdog(address, number if address in _FLOATS else whole, now_s)
        elif address == _ENABLE:
            self._switch_stream(whole, now_s)
        elif address in self._words:
            value = number if address in _FLOATS else whole
            self._words[address] = _coerced_hz(value) if address == _RATE else value
        else:
            raise RefusedError(refusal.ILLEGAL_ADDRESS, refusal.NO_REGISTER)

    def _write_short(self, address: int, value: int, now_s: float) -> None:
        if address == _LAST_ERROR:
            raise RefusedError(refusal.ILLEGAL_ADDRESS, refusal.READ_ONLY)
        if address < 3000:
            self._set_line(address - 2000, high=bool(value), when=now_s)
            return
        number = self._input(address - 41000)
        if self.model.paired and value not in (199, number + 1 if number % 2 == 0 else 199):
            raise RefusedError(refusal.DEVICE_FAILED, refusal.BAD_PAIR)
        if not self.model.paired and value != 199 and self.model.product_id == 4:
            raise RefusedError(refusal.DEVICE_FAILED, refusal.BAD_PAIR)
        self._negative[number] = value

    def _input(self, number: int) -> int:
        if not 0 <= number < self.model.inputs:
            raise RefusedError(refusal.ILLEGAL_ADDRESS, refusal.NO_REGISTER)
        return number

    def _set_range(self, number: int, range_V: float) -> None:
        if range_V == 0:
            range_V = self.model.ranges_V[0]
        found = [r for r in self.model.ranges_V if math.isclose(r, range_V, rel_tol=1e-5)]
        if not found:
            raise RefusedError(refusal.DEVICE_FAILED, refusal.BAD_RANGE)
        self._ranges[number] = found[0]

    # ------------------------------------------------------------------------------------ outputs

    def _write_output(self, address: int, volts: float, now_s: float) -> None:
        if self.faults.refuse_outputs:
            raise RefusedError(refusal.DEVICE_FAILED, 0)
        if address in (1000, 1002):
            self._set_dac((address - 1000) // 2, volts, now_s)
            return
        number = (address - 30000) // 2
        if not self.model.tick_dac or number > 1:
            raise RefusedError(refusal.DEVICE_FAILED, refusal.NO_TICK_DAC)
        step_V = 2 * _TICK_V / (2**_TICK_BITS)
        clipped = max(-_TICK_V, min(_TICK_V - step_V, volts))
        self._put_out(f"TDAC{number}", round(clipped / step_V) * step_V, now_s)

    def _set_dac(self, number: int, volts: float, when: float) -> None:
        step_V = self.model.dac_V / (2**self.model.dac_bits - 1)
        self._dac_V[number] = round(max(0.0, min(self.model.dac_V, volts)) / step_V) * step_V
        self._put_out(f"DAC{number}", self._dac_V[number], when)

    def _put_out(self, terminal: str, volts: float, when: float) -> None:
        if terminal == self.model.output and not self.faults.stuck:
            stage = self.model.stage
            self._rig.write(self._name, "ao0", (volts - stage.zero_V) * stage.gain, when)

    def _set_line(self, line: int, *, high: bool, when: float) -> None:
        changed = self._lines[line] is not high
        self._lines[line] = high
        if changed and self.wired is not None:
            self.wired(LINE_NAMES[line], high, when)

    def _set_lines(self, state: int, direction: int, inhibit: int, when: float) -> None:
        for line in range(_LINES):
            if direction >> line & 1 and not inhibit >> line & 1:
                self._set_line(line, high=bool(state >> line & 1), when=when)

    def _write_watchdog(self, address: int, value: float, now_s: float) -> None:
        dog = self.watchdog
        if address == CLEAR:
            dog.clear(value, now_s)
            return
        if dog.enabled and address != ENABLE:
            raise RefusedError(refusal.DEVICE_FAILED, refusal.WATCHDOG_RUNS)
        dog.values[address] = value
        if address == ENABLE and value:
            dog.enable(now_s)

    # ------------------------------------------------------------------------------------- inputs

    def _codes(self, number: int, when: FloatArray) -> npt.NDArray[np.uint16]:
        """Return what the converter gives; a T7's pair is one input of the rig."""
        model = self.model
        channel = f"ai{number // 2 if model.paired else number}"
        if f"AIN{number}" in self.faults.dead_inputs:
            return np.full(when.shape, 65535, np.uint16)
        range_V = self._ranges[number]
        line = model.line(number, range_V)
        volts = self._rig.read(self._name, channel, when)
        volts = volts + model.noise_V * range_V / 10.0 * self._random.standard_normal(when.shape)
        exact = np.rint((volts / line.slope + line.centre) / model.step_codes) * model.step_codes
        return np.asarray(np.clip(exact, 0, 65535), dtype=np.uint16)

    def _measured_V(self, number: int) -> float:
        """Return one reading, which the device corrects itself."""
        if self._stream is not None:
            raise RefusedError(refusal.DEVICE_FAILED, refusal.STREAM_ACTIVE)
        line = self.model.line(number, self._ranges[number])
        code = self._codes(number, np.array([self.clock.now()]))[0]
        return float((float(code) - line.centre) * line.slope)

    def _switch_stream(self, on: float, now_s: float) -> None:
        if not on:
            if self._stream is None:
                raise RefusedError(refusal.DEVICE_FAILED, refusal.NO_STREAM)
            self._stream = None
            return
        if self._stream is not None:
            raise RefusedError(refusal.DEVICE_FAILED, refusal.STREAM_ACTIVE)
        words = self._words
        count, rate_hz = int(words[_COUNT]), words[_RATE]
        addresses = [int(words[_LIST + 2 * n]) for n in range(count)]
        known = all(a % 2 == 0 and 0 <= a < 2 * self.model.inputs for a in addresses)
        if not addresses or not known or int(words[_TARGET]) != _COMMAND_RESPONSE:
            raise RefusedError(refusal.DEVICE_FAILED, refusal.NOT_STREAMABLE)
        if rate_hz <= 0 or rate_hz * count > self.model.most_samples_hz:
            raise RefusedError(refusal.DEVICE_FAILED, refusal.RATE_TOO_GREAT)
        buffer_bytes = int(words[_BUFFER])
        if buffer_bytes & (buffer_bytes - 1) or buffer_bytes > 32768:
            raise RefusedError(refusal.DEVICE_FAILED, refusal.BAD_BUFFER)
        inputs = [address // 2 for address in addresses]
        self._stream = ScanStream(inputs, rate_hz, buffer_bytes, now_s, self._codes)

    def _read_stream(self, registers: int) -> bytes:
        if self._stream is None:
            raise RefusedError(refusal.DEVICE_FAILED, refusal.NO_STREAM)
        if registers < 5:
            raise RefusedError(refusal.ILLEGAL_ADDRESS, refusal.WRONG_SIZE)
        if self.faults.lose_samples:
            self._stream.lose, self.faults.lose_samples = True, False
        return self._stream.read(registers - 4, self.clock.now())

    def _read_flash(self, registers: int) -> bytes:
        image = self.model.flash()
        at = int(self._words[_POINTER]) - self.model.flash_at
        if registers % 2 or not 0 <= at <= len(image) - 2 * registers:
            raise RefusedError(refusal.ILLEGAL_ADDRESS, refusal.NO_REGISTER)
        return image[at : at + 2 * registers]


def _packed(address: int, value: float) -> bytes:
    return struct.pack(">f", value) if address in _FLOATS else struct.pack(">I", int(value))


def _coerced_hz(rate_hz: float) -> float:
    """Return the rate of the next whole number of clock periods: 100 ns, or 1 us where slow."""
    if not rate_hz > 0:
        return 0.0
    tick_s = 1e-7 if rate_hz > 152.588 else 1e-6
    return 1.0 / (max(1, round(1.0 / (rate_hz * tick_s))) * tick_s)
