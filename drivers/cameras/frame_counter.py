"""Counts a camera's losses by its own frame numbers."""

from __future__ import annotations

_SHORT = 1 << 16  # GigE Vision numbers blocks from 1 to 65535, unless it has long numbers


class FrameCounter:
    """Frames that came incomplete, and those that never came."""

    def __init__(self) -> None:
        self.incomplete = 0
        self.missed = 0
        self._last: int | None = None
        self._without_number = 0  # since the last one with a number

    def count(self, number: int, *, whole: bool) -> None:
        """Count a frame that came, whole or not, by its number.

        Where the part is missing that has the number, it is 0.
        """
        if not whole and number == 0:
            self.count_incomplete()
            return
        if not whole:
            self.incomplete += 1
        step = 1 if self._last is None else self._step(number, self._last)
        if step > 0:
            self.missed += max(step - 1 - self._without_number, 0)
            self._without_number = 0
            self._last = number
        elif self.missed:  # it was overtaken, and is not missed after all
            self.missed -= 1

    def count_incomplete(self) -> None:
        """Count an incomplete frame of which nobody says the number."""
        self.incomplete += 1
        if self._last is not None:
            self._without_number += 1

    @staticmethod
    def _step(number: int, last: int) -> int:
        """Return how many frames further a number is; short numbers begin again at 1, or at 0."""
        if number < last < _SHORT and last - number > _SHORT // 2:
            return max(number, 1) + _SHORT - 1 - last
        return number - last
