"""A DPM-3 panel meter that reads the load cell, on its RS-232 line.

The protocol is the custom ASCII protocol of this meter family: a command is `*`, the address (0:
whichever meter is there), a letter and a digit, and CR; line feeds are ignored. A reading is sign,
five digits with a point, perhaps the letter of the alarms, CR, perhaps LF.
"""

from __future__ import annotations

import math
import re

import numpy as np

from drivers.interfaces import Clock
from sim_hardware.serial_devices.contract import ForceWorld, SimulatedSerial

GRAM_FORCE_N = 9.80665e-3
_COMMAND = re.compile(rb"\*([0-9A-V])(B1|CA|CB|A0|A1)")
_DIGITS = 5
_STALE_S = 1.0  # unasked readings older than this are not kept for a late listener


class SimulatedDpm3Meter:
    """The meter, by default displaying gram-force to three places.

    In continuous mode it sends readings unasked, `rate_hz` of them, and listens to nothing but the
    command that ends this. `alarms_N`: with them each reading carries a letter: A neither, B the
    first, C the second, D both; E to H the same at overload. All noise is drawn from the seed, one
    draw for each reading.
    """

    def __init__(
        self,
        world: ForceWorld,
        clock: Clock,
        *,
        address: str = "1",
        newtons_per_unit: float = GRAM_FORCE_N,
        decimals: int = 3,
        noise_N: float = 2e-5,
        rate_hz: float = 20.0,
        continuous: bool = False,
        alarms_N: tuple[float, float] | None = None,
        line_feed: bool = False,
        baudrate: int = 9600,
        seed: int = 0,
    ) -> None:
        self.baudrate = baudrate
        self._world = world
        self._clock = clock
        self._address = address.encode("ascii")
        self._newtons_per_unit = newtons_per_unit
        self._decimals = decimals
        self._noise_N = noise_N
        self._period_s = 1 / rate_hz
        self._alarms_N = alarms_N
        self._end = b"\r\n" if line_feed else b"\r"
        self._random = np.random.default_rng((seed, 0xD93))
        self._tare_N = 0.0
        self._received = b""
        self._next_s: float | None = clock.now() if continuous else None

    def respond(self, data: bytes) -> bytes:
        """See `SerialDevice.respond`."""
        *lines, self._received = (self._received + data).replace(b"\n", b"").split(b"\r")
        return b"".join(self._execute(line) for line in lines)

    def poll(self) -> bytes:
        """Return the readings of continuous mode that are due."""
        sent = b""
        now = self._clock.now()
        while self._next_s is not None and self._next_s <= now:
            if self._next_s > now - _STALE_S:
                sent += self._reading(self._next_s)
            self._next_s += self._period_s
        return sent

    def _execute(self, line: bytes) -> bytes:
        match = _COMMAND.fullmatch(line)
        if match is None or match[1] not in (b"0", self._address):
            return b""
        command = match[2]
        now = self._clock.now()
        if command == b"A1":
            self._next_s = None
        elif self._next_s is not None:
            pass  # continuous mode is deaf to everything else
        elif command == b"A0":
            self._next_s = now + self._period_s
        elif command == b"CA":
            self._tare_N = self._measured_N(now)
        elif command == b"CB":
            self._tare_N = 0.0
        else:
            return self._reading(now)
        return b""

    def _measured_N(self, when: float) -> float:
        return self._world.true_force_N(when) + self._noise_N * self._random.standard_normal()

    def _reading(self, when: float) -> bytes:
        force_N = self._measured_N(when) - self._tare_N
        counts = round(force_N / self._newtons_per_unit * 10**self._decimals)
        largest = 10**_DIGITS - 1
        shown = max(-largest, min(largest, counts))
        digits = f"{abs(shown):0{_DIGITS}d}"
        point = _DIGITS - self._decimals
        text = f"{'-' if math.copysign(1, shown) < 0 else '+'}{digits[:point]}.{digits[point:]}"
        letter = self._alarm_letter(force_N, overload=shown != counts)
        return (text + letter).encode("ascii") + self._end

    def _alarm_letter(self, force_N: float, *, overload: bool) -> str:
        if self._alarms_N is None:
            return ""
        on = [abs(force_N) >= limit for limit in self._alarms_N]
        return "ABCDEFGH"[on[0] + 2 * on[1] + 4 * overload]


SERIAL_DEVICE = SimulatedSerial(
    "meter", lambda world, clock, seed: SimulatedDpm3Meter(world, clock, seed=seed)
)
