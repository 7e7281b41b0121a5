"""Whether a video's file is shorter than its own headers state."""

from __future__ import annotations

import os
import struct
from pathlib import Path
from typing import BinaryIO

_ISO_MEDIA = frozenset((b"ftyp", b"moov", b"mdat", b"moof", b"free", b"skip", b"wide"))
_TO_THE_END = 0  # the size of a box of MP4 or MOV that ends with the file
_LONG = 1  # the size of one whose size follows in 8 bytes
_UNKNOWN = (0, 0xFFFFFFFF)  # the size of an AVI that was written into a pipe, or not ended


def lacks_bytes(path: Path) -> bool:
    """Return whether a video with too few frames lacks bytes; False where nothing tells.

    In a y4m all frames have one size, so that it is always bytes that lack.
    """
    with path.open("rb") as file:
        begin = file.read(12)
        held = os.fstat(file.fileno()).st_size
        if begin[:4] == b"RIFF":
            return _end_of_avi(file, held) > held
        if begin.startswith(b"YUV4MPEG2"):
            return True
        return begin[4:8] in _ISO_MEDIA and _end_of_boxes(file, held) > held


def _end_of_avi(file: BinaryIO, held: int) -> int:
    """Return where the last RIFF chunk ends: a large AVI has several."""
    place = 0
    while place < held:
        file.seek(place)
        name, size = struct.unpack("<4sI", file.read(8).ljust(8, b"\0"))
        if name != b"RIFF" or size in _UNKNOWN:
            break
        place += 8 + size
    return place


def _end_of_boxes(file: BinaryIO, held: int) -> int:
    """Return where the last box of an MP4 or MOV ends."""
    place = 0
    while place < held:
        file.seek(place)
        size, name, long = struct.unpack(">I4sQ", file.read(16).ljust(16, b"\0"))
        size = long if size == _LONG else size
        if name not in _ISO_MEDIA or size == _TO_THE_END:
            break  # of other boxes nothing is known, such as of what a program appended
        place += size
    return place
