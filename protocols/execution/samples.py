"""The samples of a run that readings still need."""

from __future__ import annotations

from collections import deque

import numpy as np

from drivers.interfaces import FloatArray, SignalBlock


class SampleBuffer:
    """Blocks as they came; samples that never came read as NaN."""

    def __init__(self, channels: int) -> None:
        self._channels = channels
        self._blocks: deque[SignalBlock] = deque()
        self._lost = 0
        self._end = 0

    @property
    def end(self) -> int:
        """Index after the last sample that has arrived."""
        return self._end

    @property
    def lost(self) -> int:
        """Samples missing between blocks so far."""
        return self._lost

    def add(self, block: SignalBlock) -> None:
        """Append a block; a gap before it counts as lost samples."""
        self._lost += max(0, block.first_index - self._end)
        self._end = block.first_index + block.volts.shape[1]
        self._blocks.append(block)

    def forget_before(self, index: int) -> None:
        """Let go of blocks that end before `index`."""
        while self._blocks and _end(self._blocks[0]) <= index:
            self._blocks.popleft()

    def between(self, first: int, last: int) -> FloatArray:
        """Return samples `first` to `last`, both included, as (channels, samples)."""
        found = np.full((self._channels, last - first + 1), np.nan)
        for block in self._blocks:
            start, end = max(first, block.first_index), min(last + 1, _end(block))
            if start < end:
                found[:, start - first : end - first] = block.volts[
                    :, start - block.first_index : end - block.first_index
                ]
        return found


def _end(block: SignalBlock) -> int:
    return block.first_index + int(block.volts.shape[1])
