"""A repeated field of doubles as it goes over the wire, without a Python object for each."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

_LENGTH_DELIMITED = 2


def doubles_field(number: int, values: npt.NDArray[np.generic]) -> bytes:
    """Field `number` holding `values`, packed, as protobuf encodes it."""
    data = np.ascontiguousarray(values, dtype="<f8").tobytes()
    return _varint(number << 3 | _LENGTH_DELIMITED) + _varint(len(data)) + data


def _varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)
