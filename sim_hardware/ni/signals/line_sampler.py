"""Samples of digital lines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from sim_hardware.ni.signals.acquisition import Samples
from sim_hardware.ni.signals.adc import FloatArray
from sim_hardware.ni.signals.digital_lines import Lines
from sim_hardware.ni.signals.shown_signals import count_of

Words = npt.NDArray[np.uint32]


class LineSampler:
    """Samples digital channels: bit i of a word is line i of the channel."""

    def __init__(
        self, lines: Lines, channels: Sequence[Sequence[str]], *, counts: bool, first: int = 0
    ) -> None:
        """`channels`: the lines of each, with their device; `counts`: lines that nobody writes."""
        self._lines = lines
        self._channels = tuple(channels)
        self._counts = counts
        self._next = first

    def sample(self, times_s: FloatArray, convert_s: float, latest_s: float) -> Samples:  # noqa: ARG002
        """See `SampleSource.sample`."""
        number = self._next + np.arange(len(times_s), dtype=np.int64)
        self._next += len(times_s)
        words = np.zeros((len(self._channels), len(times_s)), np.uint32)
        for row, lines in enumerate(self._channels):
            for bit, line in enumerate(lines):
                words[row] |= self._levels(line, times_s, number) << np.uint32(bit)
        return Samples(words, words.astype(np.float64))

    def _levels(self, line: str, times_s: FloatArray, number: npt.NDArray[np.int64]) -> Words:
        if self._counts and not self._lines.was_written(line):
            return count_of(line, number)
        return self._lines.levels_at(line, times_s)
