"""The stream: scans on the device's clock, kept until they are read (command-response mode)."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
DEFAULT_BYTES = 4096
_RECOVERING, _RECOVERED = 2940, 2941
_BETWEEN_CHANNELS_S = 10e-6
_TINY = 1e-6


class ScanStream:
    """A stream that runs. Nothing goes on in the background: the time says what has been taken."""

    def __init__(
        self,
        inputs: Sequence[int],
        rate_hz: float,
        buffer_bytes: int,
        start_s: float,
        codes: Callable[[int, FloatArray], npt.NDArray[np.uint16]],
    ) -> None:
        """`codes` returns the converter's codes of an input at given times."""
        self._inputs = tuple(inputs)
        self._rate_hz = rate_hz
        self._holds = max(1, (buffer_bytes or DEFAULT_BYTES) // 2 // len(self._inputs))
        self._start_s = start_s
        self._codes = codes
        self._position = 0  # scans that were put out or lost
        self._ready = b""  # samples of scans that were taken and not read
        self._lost = 0  # scans that found no room
        self.lose = False  # a fault: the buffer overflows now

    def read(self, samples: int, now_s: float) -> bytes:
        """Return what a read of the data register gives, padded to `samples`."""
        taken = max(0, math.floor((now_s - self._start_s) * self._rate_hz + _TINY))
        new = taken - self._position
        room = self._holds - len(self._ready) // (2 * len(self._inputs))
        if self.lose:
            room, self.lose = min(room, new // 2), False
            self._lost += 1
        kept = min(new, max(0, room))
        self._ready += self._scans(self._position, kept, now_s)
        self._lost += new - kept
        self._position = taken
        given, self._ready = self._ready[: 2 * samples], self._ready[2 * samples :]
        status, more = 0, 0
        if self._lost:
            status = _RECOVERING if self._ready else _RECOVERED
            more = min(self._lost, 65535)
            self._lost = self._lost if self._ready else 0
        head = struct.pack(">4H", len(given) // 2, min(len(self._ready), 65535), status, more)
        return head + given.ljust(2 * samples, b"\0")

    def _scans(self, first: int, count: int, now_s: float) -> bytes:
        if count <= 0:
            return b""
        # The first scan comes a period after the start.
        times_s = self._start_s + (np.arange(first, first + count) + 1) / self._rate_hz
        rows = np.empty((count, len(self._inputs)), np.uint16)
        for column, number in enumerate(self._inputs):
            when = np.minimum(times_s + column * _BETWEEN_CHANNELS_S, now_s)
            rows[:, column] = self._codes(number, when)
        return rows.astype(">u2").tobytes()
