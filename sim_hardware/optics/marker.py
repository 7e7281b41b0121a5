"""The frame number and the time written into the image, so that a test can measure true latency.

A row of square blocks at the top left, white for 1 and black for 0: 32 bits of number, 48 bits of
time in microseconds (all ones: not known), 8 bits of check sum.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

BLOCK_PX = 6
_NUMBER_BITS, _TIME_BITS, _CHECK_BITS = 32, 48, 8
_BITS = _NUMBER_BITS + _TIME_BITS + _CHECK_BITS
MARKER_COLUMNS = _BITS * BLOCK_PX
_NO_TIME = (1 << _TIME_BITS) - 1


def _check_sum(payload: int) -> int:
    return (sum(payload.to_bytes(10, "big")) ^ 0x5A) & 0xFF


def write_marker(image: npt.NDArray[np.uint8], number: int, time_s: float | None = None) -> None:
    """Write the marker into a image of at least `MARKER_COLUMNS` columns."""
    microseconds = _NO_TIME if time_s is None else round(time_s * 1e6)
    payload = (number % (1 << _NUMBER_BITS)) << _TIME_BITS | (microseconds & _NO_TIME)
    word = payload << _CHECK_BITS | _check_sum(payload)
    bits = np.array([word >> k & 1 for k in reversed(range(_BITS))], dtype=np.uint8)
    image[:BLOCK_PX, :MARKER_COLUMNS] = np.repeat(bits * np.uint8(255), BLOCK_PX)[None, :]


def read_marker(image: npt.NDArray[np.uint8]) -> tuple[int, float | None] | None:
    """Frame number and time in s of a image's marker; None where there is no valid one."""
    blocks = image[BLOCK_PX // 2, BLOCK_PX // 2 : MARKER_COLUMNS : BLOCK_PX]
    if len(blocks) < _BITS:
        return None
    word = int("".join("1" if level > 127 else "0" for level in blocks), 2)
    payload = word >> _CHECK_BITS
    if word & 0xFF != _check_sum(payload):
        return None
    microseconds = payload & _NO_TIME
    return payload >> _TIME_BITS, None if microseconds == _NO_TIME else microseconds / 1e6
